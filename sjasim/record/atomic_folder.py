"""Folders that appear complete or not at all: they are written as a draft and renamed when finished."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..core.errors import RecordError

ADVICE = "name a new or an empty folder, or allow it with --overwrite"
"""Ends the error message about a folder that is not empty."""


def check_target(folder: str | Path, overwrite: bool = False, *, holds: str = "session.json") -> Path:
    """Check that a folder can be written, before the computation whose result it is to hold.

    Args:
        folder: the folder to write; it may be absent or empty, and its parents may be absent.
        overwrite: whether an earlier result in the folder may be replaced.
        holds: name of the file that identifies an earlier result; a folder without it is never replaced.

    Returns:
        The absolute path of the folder. The check leaves nothing on disk.

    Raises:
        RecordError: the path is a file, the folder is not empty, or the location is not writable.
    """
    target = Path(folder).expanduser().absolute()

    try:
        if target.exists() and not target.is_dir():
            raise RecordError(f"{target} is a file: name a new or an empty folder")

        occupied = target.exists() and any(target.iterdir())
        if occupied and not overwrite:
            raise RecordError(f"{target} is not empty: {ADVICE}")
        if occupied and not (target / holds).exists():
            raise RecordError(f"{target} holds something else than {holds}: name another folder")

        # A trial folder is the only reliable test: permission bits say nothing about read-only or full file systems.
        existing_parent = next(parent for parent in target.parents if parent.exists())
        with tempfile.TemporaryDirectory(prefix=".sjasim-", dir=existing_parent):
            pass
    except OSError as error:
        raise RecordError(f"{target} cannot be written: {error.strerror or error}") from None

    return target


def check_file(path: Path, overwrite: bool) -> None:
    """Check that a file can be written without losing an existing one.

    Args:
        path: the file to write.
        overwrite: whether an existing file may be replaced.

    Raises:
        RecordError: the file exists and may not be replaced, or its folder does not exist.
    """
    if path.exists() and not overwrite:
        raise RecordError(f"{path} exists: name another file, or allow it with --overwrite")
    if not path.absolute().parent.is_dir() or path.is_dir():
        raise RecordError(f"{path} cannot be written: its folder does not exist")


@contextmanager
def atomic_folder(target: Path, overwrite: bool = False) -> Iterator[Path]:
    """Context manager that yields a draft folder, which replaces ``target`` on success and is deleted on failure.

    Args:
        target: the folder to write, from `check_target`.
        overwrite: whether the content of an existing folder is replaced.

    Raises:
        RecordError: the folder cannot be written, or another process has filled it since the check.
    """
    # The draft lies beside its target, so that renaming stays within one file system and is atomic.
    draft = target.parent / f".{target.name}.partial-{secrets.token_hex(4)}"

    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        draft.mkdir()
        yield draft
        _replace(draft, target, overwrite)
    except OSError as error:
        raise RecordError(f"{target} cannot be written: {error.strerror or error}") from None
    finally:
        if draft.exists():
            shutil.rmtree(draft, ignore_errors=True)


def _replace(draft: Path, target: Path, overwrite: bool) -> None:
    """Rename the draft to the target; an earlier folder is deleted only after that has succeeded."""
    backup = target.with_name(f".{target.name}.old-{secrets.token_hex(4)}")
    if overwrite and target.exists():
        os.replace(target, backup)

    try:
        # Not every system renames a folder onto an existing one, even if it is empty.
        with suppress(FileNotFoundError):
            target.rmdir()
        os.replace(draft, target)
    except OSError:
        filled_by_another = target.is_dir() and any(target.iterdir())
        if backup.exists() and not filled_by_another:
            os.replace(backup, target)
        if filled_by_another:
            raise RecordError(f"{target} has been filled by another run meanwhile: {ADVICE}") from None
        raise
    finally:
        shutil.rmtree(backup, ignore_errors=True)
