"""The folder of a study while it is computed: design, lock, parts; and its tables when it is complete.

An unfinished study has ``design.toml`` and ``parts/``, with one file for each finished chunk. A complete one has
``study.json``, which is written last. A process may be killed at any moment: files appear under their names only when
they are whole, and parts are deleted only after ``study.json`` stands.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from .. import __version__
from ..core.errors import PluginError, RecordError
from ..record.atomic_folder import check_target
from .design_file import design_from_toml, design_to_plain, design_to_toml
from .folder_lock import LOCK_FILE, folder_lock
from .study_design import StudyDesign
from .study_parts import Part, failures_in, part_key, unpack

STUDY_FILE = "study.json"
DESIGN_FILE = "design.toml"
PARTS = "parts"
DRAFT = ".draft"
"""Ending of files that are not whole yet."""


class StudyFolder:
    """The folder of a study, from `open_study`.

    Args:
        path: the folder.
        design: design of the study.

    Attributes:
        path: as given.
        design: as given.
        text: the design as TOML.
    """

    def __init__(self, path: Path, design: StudyDesign) -> None:
        self.path = path
        self.design = design
        self.text = design_to_toml(design)
        self._key = part_key(self.text)

    @property
    def is_complete(self) -> bool:
        """Whether the study is finished."""
        return (self.path / STUDY_FILE).exists()

    def missing_chunks(self, count: int) -> list[int]:
        """Numbers of the chunks, of ``count``, that have no readable part."""
        return [chunk for chunk in range(count) if not self._is_readable(chunk)]

    def keep(self, chunk: int, data: bytes) -> None:
        """Keep the bytes of a part; after this call they survive a crash of the computer.

        Raises:
            PluginError: a session failed, and the study stops after errors.
            RecordError: the part was computed by another version of sjasim.
        """
        try:
            failures = failures_in(data, self._key, chunk)
        except ValueError as error:
            raise RecordError(f"chunk {chunk}: {error}; all workers must have sjasim {__version__}") from None

        if failures and self.design.on_error == "stop":
            sys.stderr.write(failures[0].details)
            raise PluginError(f"{failures[0].what} (go on after errors with --on-error continue)")
        write_whole(self._part(chunk), data)

    def read_part(self, chunk: int) -> Part:
        """Read a part.

        Raises:
            RecordError: the part is missing or damaged.
        """
        path = self._part(chunk)
        try:
            return unpack(path.read_bytes(), self._key, chunk)
        except (OSError, ValueError, KeyError) as error:
            raise RecordError(f"{path} cannot be read ({error}): compute it again with --resume") from None

    def write(self, name: str, text: str) -> None:
        """Write a file of the folder."""
        write_whole(self.path / name, text.encode())

    def remove_parts(self) -> None:
        """Delete the parts of a complete study."""
        shutil.rmtree(self.path / PARTS, ignore_errors=True)

    def _part(self, chunk: int) -> Path:
        return self.path / PARTS / f"chunk_{chunk:06d}.part"

    def _is_readable(self, chunk: int) -> bool:
        try:
            failures_in(self._part(chunk).read_bytes(), self._key, chunk)
        except (OSError, ValueError, KeyError):
            return False
        return True


@contextlib.contextmanager
def open_study(path: Path, design: StudyDesign, resume: bool, overwrite: bool) -> Iterator[StudyFolder]:
    """Open the folder of a study for writing, and hold its lock within the block.

    Args:
        path: the folder; it may be absent or empty.
        design: design of the study.
        resume: whether an unfinished study in the folder is continued.
        overwrite: whether an earlier study in the folder is replaced.

    Raises:
        RecordError: the folder holds something else, another study, or one that is being written.
    """
    target = check_study_folder(path, design, resume, overwrite)
    try:
        target.mkdir(parents=True, exist_ok=True)
        with folder_lock(target):
            if overwrite and not resume:
                _remove_study(target)
            folder = StudyFolder(target, design)
            (target / PARTS).mkdir(exist_ok=True)
            # The design comes first, so that parts never stand without it.
            if not (target / DESIGN_FILE).exists():
                folder.write(DESIGN_FILE, folder.text)
            yield folder
    except OSError as error:
        raise RecordError(f"{target} cannot be written: {error.strerror or error}") from None


def check_study_folder(path: Path, design: StudyDesign, resume: bool, overwrite: bool) -> Path:
    """Return the absolute path of a folder that a study may be written to; see `open_study`."""
    target = path.expanduser().absolute()
    if not target.is_dir() or not any(entry.name != LOCK_FILE for entry in target.iterdir()):
        return check_target(target, overwrite=True, holds=LOCK_FILE)

    if not (target / DESIGN_FILE).exists():
        raise RecordError(f"{target} is not empty and holds no study: name a new or an empty folder")
    if resume:
        _check_same(target, design)
    elif not overwrite:
        state = "a study" if (target / STUDY_FILE).exists() else "an unfinished study"
        raise RecordError(f"{target} holds {state}: continue it with --resume, or replace it with --overwrite")
    return target


def stored_design(path: Path) -> StudyDesign | None:
    """Return the design of the study in a folder; None without one.

    Raises:
        RecordError: the design cannot be read.
        ConfigError: it has a field or a value that is not allowed.
    """
    file = path.expanduser() / DESIGN_FILE
    try:
        return design_from_toml(file.read_text(encoding="utf-8")) if file.exists() else None
    except (OSError, ValueError) as error:
        raise RecordError(f"{file} cannot be read: {error}") from None


def write_whole(path: Path, data: bytes) -> None:
    """Write a file that appears under its name only when it is whole and on disk."""
    draft = path.with_name(path.name + DRAFT)
    with draft.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    publish(draft, path)


def publish(draft: Path, path: Path) -> None:
    """Rename a whole file to its name, and make the renaming survive a crash of the computer."""
    os.replace(draft, path)
    # Windows has no descriptors of folders; its file system keeps the order of renamings itself.
    if hasattr(os, "O_DIRECTORY"):
        descriptor = os.open(path.parent, os.O_DIRECTORY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _check_same(target: Path, design: StudyDesign) -> None:
    """Refuse to continue a study with another design."""
    stored = stored_design(target)
    difference = _difference(design_to_plain(stored), design_to_plain(design)) if stored is not None else None
    if difference is not None:
        raise RecordError(
            f"{target} holds a study of another design, with {difference}: "
            "resume it without options of the design, or name another folder"
        )


def _difference(stored: Mapping[str, object], given: Mapping[str, object], path: str = "") -> str | None:
    """The first value in which two designs differ, in words; None if they are equal."""
    for name in {**stored, **given}:
        before = stored.get(name)
        now = given.get(name)
        if isinstance(before, Mapping) and isinstance(now, Mapping):
            difference = _difference(before, now, f"{path}{name}.")
            if difference is not None:
                return difference
        elif before != now:
            return f"{path}{name} = {before!r} instead of {now!r}"
    return None


def _remove_study(target: Path) -> None:
    """Delete an earlier study, its mark of completeness first."""
    for name in (STUDY_FILE, *sorted(entry.name for entry in target.iterdir())):
        path = target / name
        if path.name == LOCK_FILE:
            continue
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
