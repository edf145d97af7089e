"""Every block of Python on every page runs, and every command line is understood."""

from __future__ import annotations

import importlib
import re

import pytest
import tyro

from sjasim.commands.command_list import COMMANDS
from sjasim.commands.main import main

from .pages import EXAMPLES, ROOT, blocks, commands, pages

PYTHON_PAGES = [page for page in pages() if blocks(page, "python")]
COMMAND_PAGES = [page for page in pages() if list(commands(page))]


def run_blocks(page, slow):
    """Run a page's blocks in order in one namespace: all of them, or those that are not slow."""
    namespace = {"__name__": "__page__"}
    ran = 0
    for block in blocks(page, "python"):
        if block.slow and not slow:
            continue
        # Empty lines before the code, so that a traceback names the line of the page.
        code = "\n" * (block.line - 1) + block.text
        exec(compile(code, page, "exec"), namespace)
        ran += 1
    return ran


@pytest.fixture
def empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(EXAMPLES))


@pytest.mark.parametrize("page", PYTHON_PAGES)
def test_python_runs(page, empty_folder):
    quick = [block for block in blocks(page, "python") if not block.slow]
    assert run_blocks(page, slow=False) == len(quick)


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PYTHON_PAGES if any(b.slow for b in blocks(page, "python"))])
def test_slow_python_runs(page, empty_folder):
    assert run_blocks(page, slow=True) == len(blocks(page, "python"))


class UnderstoodError(Exception):
    """A command line has been parsed."""


@pytest.mark.parametrize("page", COMMAND_PAGES)
def test_command_lines_are_understood(page, empty_folder, monkeypatch, capsys):
    """Each line is read by the command's own parser; what the command would do then is left out."""
    parse = tyro.cli

    def parse_only(*arguments, **keywords):
        parse(*arguments, **keywords)
        raise UnderstoodError

    monkeypatch.setattr(tyro, "cli", parse_only)
    for line, name, arguments in commands(page):
        # The configuration file of an example does not exist; test_pages.py reads its text.
        known = [word for word in arguments if word not in ("--config", "--design", "my.toml")]
        if name == "test":
            continue
        assert name in COMMANDS, f"{page}, line {line}"
        assert outcome(name, known) in ("understood", "help"), f"{page}, line {line}: {capsys.readouterr().err}"
        # No line uses a former name of an option, of which a warning tells.
        assert capsys.readouterr().err == "", f"{page}, line {line}"


def outcome(name, arguments):
    """How a command ends whose parser raises `UnderstoodError`."""
    face = importlib.import_module(f"sjasim.{name}")
    try:
        return main(face.command, arguments)
    except UnderstoodError:
        return "understood"
    except SystemExit as ended:
        return "help" if ended.code == 0 else ended.code


@pytest.mark.parametrize("page", pages())
def test_scripts_have_the_options_that_pages_name(page):
    lines = [line for block in blocks(page, "bash") for line in block.text.splitlines()]
    for line in lines:
        script, *options = re.findall(r"scripts/\w+\.py|(?<= )--[\w-]+", line.partition(" # ")[0]) or [""]
        if not script.startswith("scripts/") or script == "scripts/launch.py":
            continue
        source = (ROOT / script).read_text(encoding="utf-8")
        fields = {option.removeprefix("--").replace("-", "_") for option in options}
        assert not [field for field in fields if f"    {field}: " not in source], line


def test_the_pages_have_code_to_test():
    assert sum(len(blocks(page, "python")) for page in PYTHON_PAGES) >= 10
    assert sum(len(list(commands(page))) for page in COMMAND_PAGES) >= 50
