"""Lock of a folder against two processes that write it. The operating system releases it when a process is killed."""

from __future__ import annotations

import contextlib
import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

from ..core.errors import RecordError

LOCK_FILE = ".lock"
"""Name of the lock's file. It stays after a kill, which means nothing: only a living process holds the lock."""


@contextlib.contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder within the block; the file of the lock is removed at its end.

    Raises:
        RecordError: another process holds the lock; the message names the process and its computer.
    """
    path = folder / LOCK_FILE
    with path.open("a+", encoding="utf-8") as file:
        # A holder that leaves removes the file: a lock on a removed file would exclude nobody.
        if not _acquired(file.fileno()) or not _is_present(file.fileno(), path):
            file.seek(0)
            raise RecordError(f"{folder} is being written by another process ({file.read().strip() or 'unknown'})")
        file.truncate(0)
        file.write(f"process {os.getpid()} on {socket.gethostname()}")
        file.flush()
        try:
            yield
        finally:
            # Windows does not remove a file that is open, and nothing depends on its absence.
            with contextlib.suppress(OSError):
                path.unlink()


def _is_present(descriptor: int, path: Path) -> bool:
    """Whether the open file still has its name."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False


if sys.platform == "win32":
    import msvcrt

    def _acquired(descriptor: int) -> bool:
        """Try to take the lock. It covers a byte behind the text, which others may read."""
        os.lseek(descriptor, 4096, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
else:
    import fcntl

    def _acquired(descriptor: int) -> bool:
        """Try to take the lock."""
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True
