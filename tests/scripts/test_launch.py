"""The launcher: what it runs, when it installs, and what it says when it cannot."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

PATH = Path(__file__).resolve().parents[2] / "scripts" / "launch.py"


@pytest.fixture
def launch(tmp_path, monkeypatch):
    """The launcher as a module, at home in an empty project of two commands, with a .venv that only exists."""
    spec = importlib.util.spec_from_file_location("launch", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (tmp_path / "sjasim").mkdir()
    (tmp_path / "sjasim" / "run.py").write_text('if __name__ == "__main__": ...')
    (tmp_path / "sjasim" / "types.py").write_text("")
    (tmp_path / "pyproject.toml").write_text("[project]")
    (tmp_path / "constraints.txt").write_text("numpy==2")
    monkeypatch.setattr(module, "ROOT", tmp_path)
    monkeypatch.setattr(module, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(module, "STAMP", tmp_path / ".venv" / "stamp.json")
    monkeypatch.setattr(module, "PYTHON", tmp_path / ".venv" / "bin" / "python")
    module.calls = []
    monkeypatch.setattr(module, "call", lambda command, complaint: fake_call(module, command))
    monkeypatch.setattr(module, "run", lambda command, folder: module.calls.append(command) or 7)
    monkeypatch.setattr(module, "usable", lambda uv: module.PYTHON.exists())
    monkeypatch.setattr(module.shutil, "which", lambda name: None if name == "uv" else name)
    return module


def fake_call(module, command):
    """Note a step of the installation; making the environment makes its Python."""
    module.calls.append(command)
    if "venv" in command:
        module.PYTHON.parent.mkdir(parents=True, exist_ok=True)
        module.PYTHON.write_text("")


def test_first_use_installs_and_the_second_does_not(launch, tmp_path, capsys):
    assert launch.main(["run", "--method", "eca"]) == 7
    venv, install, command = launch.calls
    assert venv == [sys.executable, "-m", "venv", str(tmp_path / ".venv")]
    assert install[1:4] == ["-m", "pip", "install"]
    assert install[-4:] == ["-e", f"{tmp_path}[test,dev,plots,video,train]", "-c", str(tmp_path / "constraints.txt")]
    assert command == [str(launch.PYTHON), "-m", "sjasim.run", "--method", "eca"]
    heard = capsys.readouterr()
    assert "installing" in heard.err
    assert heard.out == ""
    launch.calls.clear()
    assert launch.main(["run"]) == 7
    assert len(launch.calls) == 1


def test_changed_dependencies_install_again_into_the_same_environment(launch, tmp_path):
    launch.main(["run"])
    launch.calls.clear()
    (tmp_path / "constraints.txt").write_text("numpy==3")
    launch.main(["run"])
    assert [("pip" in command, "venv" in command) for command in launch.calls] == [(True, False), (False, False)]


def test_an_interrupted_installation_is_done_again(launch, monkeypatch):
    def interrupted(command, complaint):
        if "pip" in command:
            raise KeyboardInterrupt
        fake_call(launch, command)

    with monkeypatch.context() as patch:
        patch.setattr(launch, "call", interrupted)
        with pytest.raises(KeyboardInterrupt):
            launch.main(["run"])
    assert not launch.STAMP.exists()
    launch.main(["run"])
    assert launch.STAMP.exists()


def test_uv_is_used_where_it_is(launch, monkeypatch):
    monkeypatch.setattr(launch.shutil, "which", lambda name: f"/bin/{name}" if name == "uv" else name)
    launch.main(["run"])
    assert launch.calls[0][:2] == ["/bin/uv", "venv"]
    assert launch.calls[1][:5] == ["/bin/uv", "pip", "install", "--python", str(launch.PYTHON)]


def test_tests_have_defaults_that_arguments_replace(launch):
    launch.main(["test"])
    launch.main(["test", "-k", "link"])
    assert launch.calls[-2][3:] == ["-n", "2", "-m", "not slow"]
    assert launch.calls[-1][3:] == ["-k", "link"]


def test_unknown_commands_and_none_at_all_exit_with_2(launch, capsys):
    assert launch.main(["types"]) == 2
    assert launch.main([]) == 2
    assert launch.main(["--python"]) == 2
    assert launch.calls == []
    assert "known are run, test" in capsys.readouterr().err


@pytest.mark.parametrize(("answer", "says"), [([[3, 9], 64], "3.11 or newer"), ([[3, 12], 32], "32-bit")])
def test_unsupported_pythons_are_named(launch, monkeypatch, capsys, answer, says):
    probed = subprocess.CompletedProcess([], 0, stdout=json.dumps(answer).encode())
    monkeypatch.setattr(launch.subprocess, "run", lambda *_, **__: probed)
    assert launch.main(["--python", "python3.9", "run"]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert "python3.9" in error


def test_a_missing_venv_module_names_the_package(launch, monkeypatch, capsys):
    monkeypatch.setattr(launch.subprocess, "call", lambda *_, **__: 1)
    assert launch.main(["run"]) == 2
    assert "python3-venv" in capsys.readouterr().err


def test_a_python_that_does_not_exist(launch, monkeypatch, capsys):
    monkeypatch.setattr(launch.shutil, "which", lambda name: None)
    assert launch.main(["--python=/no/such", "run"]) == 2
    assert "no such program" in capsys.readouterr().err


def test_exit_codes_pass_and_a_killed_command_shows_its_signal():
    spec = importlib.util.spec_from_file_location("launch", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.run([sys.executable, "-c", "raise SystemExit(2)"], PATH.parent) == 2
    if sys.platform != "win32":
        assert module.run([sys.executable, "-c", "import os; os.kill(os.getpid(), 2)"], PATH.parent) == 130


def test_a_long_step_gives_signs_of_life_and_a_failing_one_says_so(monkeypatch, capsys):
    spec = importlib.util.spec_from_file_location("launch", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "SIGN_OF_LIFE_S", 0.1)
    module.call([sys.executable, "-c", "import time; time.sleep(0.3)"], "it failed")
    assert "still at it" in capsys.readouterr().err
    with pytest.raises(module.ProblemError, match="it failed"):
        module.call([sys.executable, "-c", "raise SystemExit(1)"], "it failed")
