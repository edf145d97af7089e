"""The console script: its list of commands, its version, and unknown commands."""

import subprocess
import sys

import pytest

import sjasim
from sjasim.__main__ import main
from sjasim.commands.command_list import COMMANDS

from .architecture.source import FACES


@pytest.fixture(autouse=True)
def console_script(monkeypatch):
    """The name by which a user calls the console script."""
    monkeypatch.setattr(sys, "argv", ["/usr/bin/sjasim"])


def test_every_command_is_listed_and_exists():
    assert {name.replace("-", "_") for name in COMMANDS} == {face for face in FACES if not face.startswith("_")}
    assert next(iter(COMMANDS)) == "run"


def test_help_lists_all_commands_in_order_and_fits_a_terminal(capsys):
    assert main(["--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    listed = [line.split()[0] for line in lines if line.startswith("  ")]
    assert listed == list(COMMANDS)
    assert max(map(len, lines)) <= 80


def test_the_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"sjasim {sjasim.__version__}\n"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["rnu"], "error: no command named 'rnu'; did you mean run? (see sjasim --help)"),
        (["view"], "error: DIR is missing: the session's folder (see sjasim view --help)"),
        (["xyz"], "error: no command named 'xyz' (see sjasim --help)"),
        ([], "error: no command given (see sjasim --help)"),
    ],
)
def test_a_command_line_that_is_not_understood_gives_one_line_and_2(capsys, arguments, says):
    assert main(arguments) == 2
    heard = capsys.readouterr()
    assert (heard.out, heard.err) == ("", f"{says}\n")


def test_messages_name_the_command_as_the_user_typed_it(capsys):
    assert main(["run", "--bogus", "1"]) == 2
    assert "(see sjasim run --help)" in capsys.readouterr().err


def test_help_of_a_command(capsys):
    with pytest.raises(SystemExit) as end:
        main(["export", "--help"])
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith("usage: sjasim export [-h] DIR")


def test_the_module_form_is_named_too_and_help_imports_no_command():
    code = "import sys; sys.argv[0] = '__main__.py'; from sjasim.__main__ import main; main(['--help']); "
    code += "print([name for name in ('tyro', 'rich', 'numba', 'mujoco') if name in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    lines = answer.stdout.splitlines()
    assert lines[0].startswith("usage: python -m sjasim ")
    assert lines[-1] == "[]"
