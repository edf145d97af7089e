"""Where compiled functions are kept, and which are dropped."""

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from sjasim.core import compiled_cache

PACKAGE = Path(compiled_cache.__file__).parents[1]
ONLY_POSIX = pytest.mark.skipif(os.name == "nt", reason="Windows has no permission bits")


@pytest.fixture
def free_choice(monkeypatch):
    """An environment in which the user has chosen no folder."""
    monkeypatch.delenv(compiled_cache.VARIABLE, raising=False)


@pytest.fixture
def unwritable(tmp_path):
    """A folder that cannot be made, not even by root: a file is in its way."""
    (tmp_path / "file").write_text("")
    return tmp_path / "file" / "__pycache__"


@pytest.mark.parametrize("decorator", ["@njit(cache=True)", "@compiled_entry", "@compiled_inner"])
def test_functions_older_than_any_source_of_compiled_code_are_removed(tmp_path, decorator):
    def put(name, age_s, text=""):
        path = tmp_path / name
        path.write_text(text)
        os.utime(path, (1e9 - age_s, 1e9 - age_s))
        return path

    put("caller.py", 100, "@njit(cache=True)")
    put("callee.py", 50, decorator)
    put("plain.py", 10)
    old = put("caller.f-1.py311.nbi", 60)
    new = put("callee.g-1.py311.nbi", 40)
    compiled_cache.remove_outdated(tmp_path, tmp_path / "absent")
    assert (old.exists(), new.exists()) == (False, True)


def test_a_usual_folder_that_can_be_written_needs_no_other(tmp_path, unwritable, free_choice):
    assert compiled_cache.fallback_folder([unwritable, tmp_path / "new" / "numba"]) is None
    assert list((tmp_path / "new" / "numba").iterdir()) == []


def test_a_choice_of_the_users_stands(unwritable, monkeypatch):
    monkeypatch.setenv(compiled_cache.VARIABLE, "/somewhere")
    assert compiled_cache.fallback_folder([unwritable]) is None


@ONLY_POSIX
def test_without_a_usual_folder_a_private_temporary_one_is_used(tmp_path, unwritable, free_choice, monkeypatch):
    monkeypatch.setattr(compiled_cache.tempfile, "gettempdir", lambda: str(tmp_path))
    folder = compiled_cache.fallback_folder([unwritable, unwritable])
    assert folder == tmp_path / f"sjasim-compiled-{os.getuid()}"
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert compiled_cache.fallback_folder([unwritable]) == folder


@ONLY_POSIX
def test_a_folder_that_others_can_write_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled_cache.tempfile, "tempdir", str(tmp_path))
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o777)
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "private")
    for name in (shared, link):
        folder = compiled_cache.private_folder(name)
        assert folder != name
        assert folder.name.startswith(f"{name.name}-")
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_a_session_runs_from_a_read_only_installation_without_a_home(tmp_path):
    """The package is bound to itself read-only in a mount namespace of its own."""
    probe = [
        "unshare",
        "-m",
        "bash",
        "-c",
        'mount --bind "$1" "$1" && mount -o remount,ro,bind "$1"',
        "_",
        str(PACKAGE),
    ]
    try:
        possible = subprocess.run(probe, capture_output=True, timeout=60, check=False).returncode == 0
    except OSError:
        possible = False
    if not possible:
        pytest.skip("a read-only mount needs root on Linux")

    code = "import sjasim, numba; from sjasim.anticipation import synchrony; print(numba.config.CACHE_DIR)"
    script = f'{probe[4]} && cd "$2" && exec "$3" -c "$4"'
    environment = {name: value for name, value in os.environ.items() if name != compiled_cache.VARIABLE}
    environment |= {"HOME": "/proc/nohome", "XDG_CACHE_HOME": "/proc/nohome", "TMPDIR": str(tmp_path)}
    environment["PYTHONPATH"] = os.pathsep.join([str(PACKAGE.parent), str(PACKAGE.parent / "envs")])
    answer = subprocess.run(
        ["unshare", "-m", "bash", "-c", script, "_", str(PACKAGE), str(tmp_path), sys.executable, code],
        capture_output=True, text=True, timeout=300, check=False, env=environment,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    folder = tmp_path / f"sjasim-compiled-{os.getuid()}"
    assert answer.stdout.strip() == str(folder)
    lines = [line for line in answer.stderr.splitlines() if line.startswith("sjasim: ")]
    assert len(lines) == 1
    assert str(folder) in lines[0]
