"""Folders that appear whole or not at all: written beside their target and renamed when finished."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..core.errors import RecordError

OTHERWISE = "name a new or an empty folder, or allow it with --overwrite"
"""What to do about a folder that holds something."""


def check_target(folder: str | Path, overwrite: bool = False, *, holds: str = "session.json") -> Path:
    """Make sure that a folder can be written, before the work whose outcome it is to hold.

    Args:
        folder: where to; it may be absent or empty, and so may its parents be absent.
        overwrite: whether it may hold an earlier outcome, which a new one replaces.
        holds: the file by which an earlier outcome is known.

    Returns:
        its full path; nothing is left on disk.

    Raises:
        RecordError: it is a file, it holds something already, or its place cannot be written to.
    """
    target = Path(folder).expanduser().absolute()
    try:
        if target.exists() and not target.is_dir():
            raise RecordError(f"{target} is a file: name a new or an empty folder")
        held = target.exists() and any(target.iterdir())
        if held and not overwrite:
            raise RecordError(f"{target} is not empty: {OTHERWISE}")
        if held and not (target / holds).exists():
            raise RecordError(f"{target} holds something else than {holds}: name another folder")
        ground = next(place for place in target.parents if place.exists())
        with tempfile.TemporaryDirectory(prefix=".sjasim-", dir=ground):
            pass
    except OSError as error:
        raise RecordError(f"{target} cannot be written: {error.strerror or error}") from None
    return target


def check_file(path: Path, overwrite: bool) -> None:
    """Make sure that a file can be written and nothing is lost by it.

    Raises:
        RecordError: it exists and may not be replaced, or its place does not take files.
    """
    if path.exists() and not overwrite:
        raise RecordError(f"{path} exists: name another file, or allow it with --overwrite")
    if not path.absolute().parent.is_dir() or path.is_dir():
        raise RecordError(f"{path} cannot be written: its folder does not exist")


@contextmanager
def atomic_folder(target: Path, overwrite: bool = False) -> Iterator[Path]:
    """A draft folder to write into, which becomes ``target`` when all is written, and vanishes if something fails.

    Args:
        target: from `check_target`.
        overwrite: whether what it holds is replaced.

    Raises:
        RecordError: the folder cannot be written, or somebody else has filled it meanwhile.
    """
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
    """Put the draft in the target's place; an earlier outcome goes only once the new one stands."""
    aside = target.with_name(f".{target.name}.old-{secrets.token_hex(4)}")
    if overwrite and target.exists():
        os.replace(target, aside)
    try:
        with suppress(FileNotFoundError):
            target.rmdir()
        os.replace(draft, target)
    except OSError:
        filled = target.is_dir() and any(target.iterdir())
        if aside.exists() and not filled:
            os.replace(aside, target)
        if filled:
            raise RecordError(f"{target} has been filled by another run meanwhile: {OTHERWISE}") from None
        raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)
