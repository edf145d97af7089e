"""Finds out what a folder holds, and writes the page about it."""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ...core.errors import ConfigError, RecordError
from ...record.atomic_folder import check_file
from .characterisation_page import characterisation_page
from .page import Page, html
from .power_page import power_page
from .reproduction_page import reproduction_page
from .session_page import session_page
from .study_page import study_page

REPORT = "report.html"
"""Name of the page in a folder."""

SCHEMAS = (1, 2)
"""Versions of the files that can be read."""


PAGES: Mapping[str, Callable[[Path, Mapping[str, Any]], Page]] = {
    "study.json": study_page,
    "reproduce.json": lambda folder, content: reproduction_page(content),
    "characterise.json": lambda folder, content: characterisation_page(content),
    "power.json": lambda folder, content: power_page(content),
    "session.json": lambda folder, content: session_page(folder),
}
"""File by which a folder is recognised -> function of the folder and of the file's content that gives the page."""


def write_report(folder: Path, out: Path | None = None, overwrite: bool = False) -> Path:
    """Write the page about a folder; it appears whole or not at all.

    Args:
        folder: folder of a study, a session or another result, see `PAGES`.
        out: the file to write; by default ``report.html`` in the folder.
        overwrite: whether an existing page may be replaced.

    Returns:
        The file.

    Raises:
        ConfigError: the file's name does not end in .html.
        RecordError: the folder is none of these, a file in it is missing or damaged, or the page cannot be written.
    """
    target = folder / REPORT if out is None else out
    # A mistyped path must not replace a table or a figure of the study.
    if target.suffix != ".html":
        raise ConfigError("out", str(target), "a file whose name ends in .html")
    if out is not None or folder.is_dir():
        check_file(target, overwrite)
    text = html(_read(folder))

    draft = target.with_name(f".{target.name}.partial-{secrets.token_hex(4)}")
    try:
        draft.write_text(text, encoding="utf-8")
        os.replace(draft, target)
    except OSError as error:
        raise RecordError(f"{target} cannot be written: {error.strerror or error}") from None
    finally:
        draft.unlink(missing_ok=True)
    return target


def _read(folder: Path) -> Page:
    """The page about a folder."""
    name = next((name for name in PAGES if (folder / name).is_file()), None)
    if name is None:
        reason = f"it has none of {', '.join(PAGES)}" if folder.is_dir() else "there is no such folder"
        raise RecordError(f"{folder} cannot be reported on: {reason}")

    content = _content(folder / name)
    try:
        return PAGES[name](folder, content)
    except (KeyError, TypeError, ValueError) as error:
        # The file is JSON of the right version, and yet not what the command writes.
        raise RecordError(f"{folder / name} is damaged: {type(error).__name__}: {error}") from error


def _content(path: Path) -> Mapping[str, Any]:
    """Content of a JSON file of a known version."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RecordError(f"{path} cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise RecordError(f"{path} is damaged: {error}") from None

    if not isinstance(content, dict) or content.get("schema") not in SCHEMAS:
        raise RecordError(f"{path} is not of version {' or '.join(map(str, SCHEMAS))}")
    return content
