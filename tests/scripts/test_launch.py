"""The launcher: what it runs, when and what it installs, and its messages when it cannot; the lock files."""

import importlib.util
import itertools
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PATH = Path(__file__).resolve().parents[2] / "scripts" / "launch.py"
PROJECT = PATH.parents[1]


@pytest.fixture
def launch(tmp_path, monkeypatch):
    """The launcher in an empty project with one command; its installation steps and commands are only recorded."""
    module = load()
    (tmp_path / "sjasim").mkdir()
    (tmp_path / "sjasim" / "run.py").write_text('if __name__ == "__main__": ...')
    (tmp_path / "sjasim" / "types.py").write_text("")
    (tmp_path / "pyproject.toml").write_text("[project]")
    (tmp_path / "sjasim" / "__main__.py").write_text('if __name__ == "__main__": ...')
    (tmp_path / "requirements").mkdir()
    (tmp_path / "requirements" / "run.txt").write_text("numpy==2")
    monkeypatch.setattr(module, "ROOT", tmp_path)
    monkeypatch.setattr(module, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(module, "STAMP", tmp_path / ".venv" / "stamp.json")
    monkeypatch.setattr(module, "PYTHON", tmp_path / ".venv" / "bin" / "python")
    module.calls = []
    monkeypatch.setattr(module, "call", lambda command, complaint: fake_call(module, command))
    monkeypatch.setattr(module, "start_compiling", lambda: module.calls.append(["compile"]) or [])
    monkeypatch.setattr(module, "run", lambda command, folder: module.calls.append(command) or 7)
    monkeypatch.setattr(module, "usable", lambda uv: module.PYTHON.exists())
    monkeypatch.setattr(module.shutil, "which", lambda name: None if name == "uv" else name)
    return module


def load():
    """The launcher as a module."""
    spec = importlib.util.spec_from_file_location("launch", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def installed(launch):
    """Lock files that the recorded steps installed, in order, with "sjasim" for the package itself."""
    steps = [command for command in launch.calls if "install" in command]
    return ["sjasim" if "-e" in step else Path(step[-1]).stem for step in steps]


def test_functions_are_compiled_while_the_last_stage_is_installed_and_once_only(launch):
    launch.main(["run"])
    assert launch.calls[-3] == ["compile"]
    assert "run.txt" in launch.calls[-2][-1]

    launch.calls.clear()
    launch.main(["test"])  # adds packages; the functions are compiled already
    assert installed(launch)
    assert ["compile"] not in launch.calls


def test_compiling_names_parts_that_exist_and_waits_with_a_line(monkeypatch, capsys):
    from sjasim.simulation.precompile import PARTS

    module = load()
    assert set(module.COMPILED_PARTS) == set(PARTS)
    monkeypatch.setattr(module, "PROGRESS_S", 0.1)
    module.wait_for([subprocess.Popen([sys.executable, "-c", "import time; time.sleep(0.5)"])])
    said = capsys.readouterr().err
    assert "compiling for this machine" in said
    assert "still compiling" in said
    assert "could be compiled ahead" not in said

    module.wait_for([subprocess.Popen([sys.executable, "-c", "raise SystemExit(1)"])])
    assert "could be compiled ahead" in capsys.readouterr().err


def fake_call(module, command):
    """Record a step of the installation; the step that makes .venv also makes its Python."""
    module.calls.append(command)
    if "venv" in command:
        module.PYTHON.parent.mkdir(parents=True, exist_ok=True)
        module.PYTHON.write_text("")


def test_first_use_installs_and_the_second_does_not(launch, tmp_path, capsys):
    assert launch.main(["run", "--method", "eca"]) == 7
    assert launch.calls[0] == [sys.executable, "-m", "venv", str(tmp_path / ".venv")]
    assert installed(launch) == ["simulation", "sjasim", "run"]
    assert launch.calls[-1] == [str(launch.PYTHON), "-m", "sjasim.run", "--method", "eca"]
    heard = capsys.readouterr()
    assert "Installing" in heard.err
    assert heard.out == ""

    launch.calls.clear()
    assert launch.main(["run"]) == 7
    assert len(launch.calls) == 1


def test_only_locked_files_are_fetched(launch, tmp_path):
    launch.main(["run"])
    simulation, package, rest = [command for command in launch.calls if "install" in command]
    for step, name in ((simulation, "simulation"), (rest, "run")):
        assert step[1:4] == ["-m", "pip", "install"]
        assert step[-3:] == ["--require-hashes", "-r", str(tmp_path / "requirements" / f"{name}.txt")]
    assert package[-5:] == ["--no-index", "--no-deps", "--no-build-isolation", "-e", str(tmp_path)]


def test_a_larger_set_is_added_when_a_command_needs_it_and_stays(launch, tmp_path):
    for arguments, added in (
        (["run"], ["simulation", "sjasim", "run"]),
        (["run", "--video=dance.mp4"], ["simulation", "sjasim", "optional"]),
        (["run", "--plots", "figures"], []),
        (["test"], ["simulation", "sjasim", "test"]),
        (["run"], []),
    ):
        launch.calls.clear()
        assert launch.main(arguments) == 7
        assert installed(launch) == added

    (tmp_path / "requirements" / "run.txt").write_text("numpy==3")
    launch.calls.clear()
    launch.main(["run"])
    assert installed(launch) == ["simulation", "sjasim", "test"]


def test_changed_dependencies_install_again_into_the_same_environment(launch, tmp_path):
    launch.main(["run"])
    for name in ("pyproject.toml", "requirements/run.txt"):
        launch.calls.clear()
        (tmp_path / name).write_text("changed")
        launch.main(["run"])
        assert installed(launch) == ["simulation", "sjasim", "run"]
        assert not any("venv" in command for command in launch.calls)


def test_an_interrupted_installation_is_continued(launch, monkeypatch):
    def interrupted(command, complaint):
        fake_call(launch, command)
        if "-e" in command:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(launch, "call", interrupted)
        with pytest.raises(KeyboardInterrupt):
            launch.main(["test"])

    launch.calls.clear()
    launch.main(["run"])
    assert installed(launch) == ["simulation", "sjasim", "run"]
    assert not any("venv" in command for command in launch.calls)


def test_another_python_makes_a_new_environment(launch):
    launch.main(["--python", sys.executable, "test"])
    launch.calls.clear()
    launch.main(["--python", sys.executable, "run"])
    assert len(launch.calls) == 1

    launch.write_stamp({**launch.read_stamp(), "python": "/usr/bin/another"})
    launch.calls.clear()
    launch.main(["--python", sys.executable, "run"])
    assert "venv" in launch.calls[0]
    assert installed(launch) == ["simulation", "sjasim", "run"]


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
    module = load()
    assert module.run([sys.executable, "-c", "raise SystemExit(2)"], PATH.parent) == 2
    if sys.platform != "win32":
        assert module.run([sys.executable, "-c", "import os; os.kill(os.getpid(), 2)"], PATH.parent) == 130


def test_a_long_step_reports_progress_and_a_failed_one_is_an_error(monkeypatch, capsys):
    module = load()
    monkeypatch.setattr(module, "PROGRESS_S", 0.1)
    module.call([sys.executable, "-c", "import time; time.sleep(0.3)"], "it failed")
    assert "so far" in capsys.readouterr().err
    with pytest.raises(module.ProblemError, match="it failed"):
        module.call([sys.executable, "-c", "raise SystemExit(1)"], "it failed")


def locked(name):
    """Requirement lines of a lock file: package -> its versions, one for each marker."""
    lines = re.findall(r"^(\S+)==(\S+)", (PROJECT / "requirements" / f"{name}.txt").read_text(), re.MULTILINE)
    versions = {}
    for package, version in lines:
        versions.setdefault(package, set()).add(version)
    return versions


def requirements(*, extras=(), groups=()):
    """What pyproject.toml asks for: the package's dependencies, extras and dependency groups."""
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))
    found = [line for group in groups for line in project["dependency-groups"][group]]
    found += [line for extra in extras for line in project["project"]["optional-dependencies"][extra]]
    return [Requirement(line) for line in [*project["project"]["dependencies"], *found]]


@pytest.mark.parametrize(
    ("name", "extras", "groups"),
    [
        ("run", (), ("build",)),
        ("optional", ("plots", "video", "ros"), ("build",)),
        ("test", ("plots", "video", "ros", "train"), ("build", "test", "style", "docs")),
    ],
)
def test_lock_files_satisfy_pyproject(name, extras, groups):
    versions = locked(name)
    for requirement in requirements(extras=extras, groups=groups):
        pinned = versions[canonicalize_name(requirement.name)]
        assert all(requirement.specifier.contains(version) for version in pinned), requirement


def test_each_lock_file_agrees_with_the_next_larger():
    names = ("simulation", "run", "optional", "test")
    for smaller, larger in itertools.pairwise(names):
        versions = locked(larger)
        assert {package: versions[package] for package in locked(smaller)} == locked(smaller)


def test_users_do_not_get_development_packages():
    assert not {"pytest", "ruff", "mypy", "scikit-learn", "sphinx", "matplotlib"} & set(locked("run"))


@pytest.mark.parametrize("name", ["simulation", "run", "optional", "test"])
def test_lock_files_have_hashes_and_name_no_host(name):
    text = (PROJECT / "requirements" / f"{name}.txt").read_text()
    assert "://" not in text
    assert not re.findall(r"^\S+==[^\\\n]*$", text, re.MULTILINE)  # each requirement continues with its hashes


@pytest.mark.slow
def test_the_first_stage_is_enough_to_compile():
    """Packages of later stages are hidden, as they are missing while the functions are compiled."""
    names = {"rerun-sdk": "rerun", "dm-control": "dm_control", "tomli-w": "tomli_w"}
    later = sorted(names.get(package, package) for package in set(locked("run")) - set(locked("simulation")))
    assert "pyarrow" in later
    probe = (
        f"import sys; sys.modules.update(dict.fromkeys({later!r}))\n"
        "from sjasim.simulation import precompile\n"
        "precompile.main(list(precompile.PARTS))\n"
        "print('compiled')"
    )
    answer = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, cwd=PROJECT, check=False)
    assert answer.stdout.strip() == "compiled", answer.stderr
