"""Where numba keeps compiled functions: drops outdated ones, and finds a folder where no usual one can be written.

Compiling takes up to a minute and a half, so the functions are kept in files: beside the sources, or else in the user's
cache folder. This module is imported with the package, before numba, and needs the standard library only.
"""

from __future__ import annotations

import contextlib
import os
import stat
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"
"""Environment variable of numba's that names the folder; child processes inherit it."""

DECORATORS = (b"@njit", b"@compiled_")
"""What precedes a compiled function in a source file; see `core.compiled`."""


def prepare(*sources: Path) -> None:
    """Drop outdated compiled functions, and choose a temporary folder for them if no usual one can be written.

    Args:
        sources: folders of the Python files, the package's own first; absent ones are skipped.
    """
    folder = fallback_folder([sources[0] / "__pycache__", user_cache()])
    if folder is not None:
        os.environ[VARIABLE] = str(folder)
        _tell_numba(folder)
        sys.stderr.write(
            f"sjasim: compiled functions are kept in {folder}, as neither the installation nor {user_cache()} can be "
            f"written; {VARIABLE} names another folder\n"
        )
    remove_outdated(*sources, *([folder] if folder else []))


def remove_outdated(*folders: Path) -> None:
    """Remove compiled functions that are older than the newest source of any.

    Numba notices when a function's own file has changed, but not when a file has changed that holds what the function
    calls: after an update of the sources it would go on using the old code.
    """
    compiled = [index for folder in folders for index in folder.rglob("*.nbi")]
    if not compiled:
        return

    sources = [path for folder in folders for path in folder.rglob("*.py")]
    newest_s = max((path.stat().st_mtime for path in sources if _is_compiled(path)), default=0.0)
    with contextlib.suppress(OSError):  # in a folder that cannot be written, nothing of this user's is outdated
        for index in compiled:
            if index.stat().st_mtime < newest_s:
                index.unlink(missing_ok=True)


def _is_compiled(path: Path) -> bool:
    """Whether a source file holds functions that numba compiles."""
    text = path.read_bytes()
    return any(decorator in text for decorator in DECORATORS)


def fallback_folder(usual: Iterable[Path]) -> Path | None:
    """A private temporary folder if none of the usual ones can be written; None if one can, or if the user chose one.

    Args:
        usual: the folders that numba tries, in its order.
    """
    if os.environ.get(VARIABLE):
        return None
    if any(is_writable(folder) for folder in usual):
        return None

    try:
        return private_folder(Path(tempfile.gettempdir()) / f"sjasim-compiled-{_user()}")
    except OSError:  # not even a temporary folder can be written: numba says so itself
        return None


def is_writable(folder: Path) -> bool:
    """Whether a file can be made in a folder, which is made if it is absent.

    Asking for permissions is not enough: a file system may be read-only, and root is allowed everything.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def private_folder(folder: Path) -> Path:
    """The folder if it belongs to this user alone, made if absent; else a new one with a random name.

    Numba executes what it finds there, and others may write to the folder for temporary files: so a folder that
    somebody else has made under the expected name is not used.

    Raises:
        OSError: no folder can be made.
    """
    # The mode is given to mkdir itself: between a mkdir and a chmod others could write to the folder.
    with contextlib.suppress(FileExistsError):
        folder.mkdir(mode=0o700)

    status = folder.lstat()
    owned = not hasattr(os, "getuid") or status.st_uid == os.getuid()
    closed = os.name == "nt" or stat.S_IMODE(status.st_mode) & 0o077 == 0
    if stat.S_ISDIR(status.st_mode) and owned and closed:
        return folder
    return Path(tempfile.mkdtemp(prefix=f"{folder.name}-"))


def user_cache() -> Path:
    """The folder in the user's home where numba keeps what it cannot keep beside the sources."""
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return (Path(local) if local else _home() / "AppData" / "Local") / "numba" / "Cache"
    if sys.platform == "darwin":
        return _home() / "Library" / "Caches" / "numba"
    chosen = os.environ.get("XDG_CACHE_HOME")
    return (Path(chosen) if chosen else _home() / ".cache") / "numba"


def _home() -> Path:
    return Path(os.path.expanduser("~"))


def _user() -> str:
    """What tells this user's folder from another's."""
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")


def _tell_numba(folder: Path) -> None:
    """Set the folder in a numba that has been imported already, which reads the environment no more."""
    numba = sys.modules.get("numba")
    if numba is not None:
        numba.config.CACHE_DIR = str(folder)
