"""Management of Numba's cache of compiled functions: removal of outdated files, and a fallback folder.

Compilation takes up to 90 seconds, so Numba keeps the compiled functions in files: beside the sources, or in the user's
cache folder if the sources are read-only. This module chooses a temporary folder if neither can be written. It must run
before Numba is imported, which reads the folder at import. It therefore imports the standard library only.
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
"""Environment variable from which Numba reads the cache folder; child processes inherit it."""

DECORATORS = (b"@njit", b"@compiled_")
"""Beginnings of the decorators of compiled functions in source files; see `core.compiled`."""


def prepare(*sources: Path) -> None:
    """Remove outdated compiled functions, and set a temporary cache folder if no default folder can be written.

    Args:
        sources: folders of Python files, the package's own folder first; folders that do not exist are skipped.
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
    """Remove all compiled functions that are older than the newest source file with compiled functions.

    Numba recompiles a function if the file that defines it has changed, but not if the file of a function that it calls
    has changed. Without this removal, Numba would continue to use outdated code after an update of the sources.
    """
    compiled = [index for folder in folders for index in folder.rglob("*.nbi")]
    if not compiled:
        return

    sources = [path for folder in folders for path in folder.rglob("*.py")]
    newest_s = max((path.stat().st_mtime for path in sources if _is_compiled(path)), default=0.0)
    with contextlib.suppress(OSError):  # a read-only folder cannot be cleaned
        for index in compiled:
            if index.stat().st_mtime < newest_s:
                index.unlink(missing_ok=True)


def _is_compiled(path: Path) -> bool:
    """Whether a source file contains functions that Numba compiles."""
    text = path.read_bytes()
    return any(decorator in text for decorator in DECORATORS)


def fallback_folder(usual: Iterable[Path]) -> Path | None:
    """Return a private temporary folder if none of Numba's default folders can be written.

    Args:
        usual: folders that Numba tries, in this order.

    Returns:
        the folder; None if a default folder can be written, or if the user has set `VARIABLE`.
    """
    if os.environ.get(VARIABLE):
        return None
    if any(is_writable(folder) for folder in usual):
        return None

    try:
        return private_folder(Path(tempfile.gettempdir()) / f"sjasim-compiled-{_user()}")
    except OSError:  # no temporary folder can be written either: Numba raises its own error
        return None


def is_writable(folder: Path) -> bool:
    """Whether a file can be created in a folder; the folder is created if it does not exist.

    A test of the permission bits is not sufficient: the file system may be read-only, and root passes every such test.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def private_folder(folder: Path) -> Path:
    """Return the folder if only this user can access it, or else a new folder with a random name.

    The folder is created if it does not exist. Numba executes the files in its cache, and every user can create folders
    in the system's temporary folder. A folder that another user has created is therefore not used.

    Raises:
        OSError: no folder can be created.
    """
    # mkdir sets the mode itself: between mkdir and a later chmod, other users could write to the folder.
    with contextlib.suppress(FileExistsError):
        folder.mkdir(mode=0o700)

    status = folder.lstat()
    owned = not hasattr(os, "getuid") or status.st_uid == os.getuid()
    closed = os.name == "nt" or stat.S_IMODE(status.st_mode) & 0o077 == 0
    if stat.S_ISDIR(status.st_mode) and owned and closed:
        return folder
    return Path(tempfile.mkdtemp(prefix=f"{folder.name}-"))


def user_cache() -> Path:
    """Return the folder in the user's home that Numba uses if the folder of the sources cannot be written."""
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
    """Identifier of the user, which makes the folder's name unique."""
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")


def _tell_numba(folder: Path) -> None:
    """Set the folder in Numba's configuration if Numba is imported already, since it then ignores the environment."""
    numba = sys.modules.get("numba")
    if numba is not None:
        numba.config.CACHE_DIR = str(folder)
