"""Folders that appear whole or not at all: written beside their target and renamed when finished."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import RecordError


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
            raise RecordError(f"{target} is not empty: name a new or an empty folder, or allow it with --overwrite")
        if held and not (target / holds).exists():
            raise RecordError(f"{target} holds something else than {holds}: name another folder")
        ground = next(place for place in target.parents if place.exists())
        with tempfile.TemporaryDirectory(prefix=".sjasim-", dir=ground):
            pass
    except OSError as error:
        raise RecordError(f"{target} cannot be written: {error.strerror or error}") from None
    return target


@contextmanager
def whole(target: Path) -> Iterator[Path]:
    """A draft folder to write into, which becomes ``target`` when all is written, and vanishes if something fails.

    Args:
        target: from `check_target`; what it holds is replaced.

    Raises:
        RecordError: the folder cannot be written.
    """
    draft = target.parent / f".{target.name}.partial-{secrets.token_hex(4)}"
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        draft.mkdir()
        yield draft
        _replace(draft, target)
    except OSError as error:
        raise RecordError(f"{target} cannot be written: {error.strerror or error}") from None
    finally:
        if draft.exists():
            shutil.rmtree(draft, ignore_errors=True)


def _replace(draft: Path, target: Path) -> None:
    """Put the draft in the target's place; an earlier outcome goes only once the new one stands."""
    if not (target.exists() and any(target.iterdir())):
        if target.exists():
            target.rmdir()
        os.replace(draft, target)
        return
    aside = target.with_name(f".{target.name}.old-{secrets.token_hex(4)}")
    os.replace(target, aside)
    os.replace(draft, target)
    shutil.rmtree(aside, ignore_errors=True)
