"""Pages of the documentation as the tests read them: their blocks of code and their links."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
EXAMPLES = DOCS / "examples"

SLOW = "<!-- test: slow -->"
"""Line before a block that takes more than a few seconds; it is run with the slow tests."""

PROGRAMS = ("python3 scripts/launch.py", "sjasim", "python -m sjasim.", ".venv/bin/python -m sjasim.")
"""Beginnings of lines that run a command of sjasim; the command's name follows."""


@dataclass(frozen=True)
class Block:
    """A fenced block of code.

    Attributes:
        page: path relative to the repository.
        line: line of its first line of code, from 1.
        language: language after the fence.
        text: the code.
        slow: whether `SLOW` stands before it.
    """

    page: str
    line: int
    language: str
    text: str
    slow: bool


def pages() -> list[str]:
    """All pages, relative to the repository."""
    written = [path for path in DOCS.rglob("*.md") if "_ext" not in path.parts]
    found = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted(written)]
    return [path.relative_to(ROOT).as_posix() for path in found]


def text_of(page: str) -> str:
    """A page's text."""
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(page: str, language: str) -> list[Block]:
    """All blocks of a language on a page, in order."""
    return [block for block in _all_blocks(page) if block.language == language]


def _all_blocks(page: str) -> Iterator[Block]:
    before = ""
    opened: tuple[int, str, bool] | None = None
    code: list[str] = []

    for number, line in enumerate(text_of(page).splitlines(), start=1):
        if not line.startswith("```"):
            code.append(line)
        elif opened is None:
            opened = number + 1, line.removeprefix("```").strip(), before == SLOW
            code = []
        else:
            first, language, slow = opened
            yield Block(page, first, language, "\n".join(code) + "\n", slow)
            opened = None
        before = line


def commands(page: str) -> Iterator[tuple[int, str, list[str]]]:
    """Line, name and arguments of every command of sjasim in the shell blocks of a page."""
    for block in blocks(page, "bash"):
        for offset, line in enumerate(block.text.splitlines()):
            call = re.sub(r"^\w+=\S+ ", "", line)
            program = next((name for name in PROGRAMS if call.startswith(name)), None)
            if program is None:
                continue
            words = shlex.split(call.removeprefix(program), comments=True)
            if ">" in words:
                words = words[: words.index(">")]
            yield block.line + offset, words[0], words[1:]


def links(page: str) -> list[str]:
    """Files that a page links to or shows, as they are written there, without anchors."""
    text = re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)
    targets = re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(
        r"^```\{(?:literal)?include\} (\S+)", text_of(page), re.M
    )
    files = (target.partition("#")[0] for target in targets if "://" not in target)
    return [file for file in files if file]


def table_rows(page: str, heading: str) -> dict[str, str]:
    """First column -> second column of the table below a line; a first cell with several names gives several rows."""
    _, found, rest = f"\n{text_of(page)}".partition(f"\n{heading}\n")
    assert found, f"{page} has no heading {heading}"

    rows: dict[str, str] = {}
    started = False
    for line in rest.splitlines():
        if line.startswith("|"):
            started = True
            cells = line.strip("|").split("|")
            rows |= dict.fromkeys(re.findall(r"`([^`]+)`", cells[0]), cells[1].strip())
        elif started:
            break
    return rows
