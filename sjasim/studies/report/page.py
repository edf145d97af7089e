"""What pages consist of, and how a page is made of a template.

The templates lie in ``templates/``. They hold the prose that is the same in every report; figures, tables and sentences
that depend on data come from the modules beside this one.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from markupsafe import Markup

from .text import NAME_CHARACTERS, agent, counted, interval, number, p_value, percent, shortened, signed

if TYPE_CHECKING:
    from jinja2 import Environment

TEMPLATES = Path(__file__).parent / "templates"


class Cell(NamedTuple):
    """A cell of a table.

    Attributes:
        text: what it says, or a drawing.
        style: class: ``name`` for text at the left, ``best`` for the highest of a pair, ``bad`` for what fails.
    """

    text: str | Markup
    style: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a caption.

    Attributes:
        caption: what it holds.
        head: texts of the columns.
        rows: the cells.
        note: explanation below the table.
        above: texts that each stand above several columns, with the number of these columns; empty without such a line.
    """

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    note: str = ""
    above: Sequence[tuple[str, int]] = ()


@dataclass(frozen=True, slots=True)
class Figure:
    """A drawing with its caption.

    Attributes:
        drawing: the drawing.
        caption: what it shows and how it is read.
        legend: (swatch, text) of each entry.
        wide: whether it takes the width of the page, and scrolls on narrow screens.
    """

    drawing: Markup
    caption: str
    legend: Sequence[tuple[Markup, str]] = ()
    wide: bool = False


@dataclass(frozen=True, slots=True)
class Question:
    """A threat to validity as a reviewer would ask it, with the answer that the data give."""

    asked: str
    answer: str


@dataclass(frozen=True, slots=True)
class Page:
    """Content of a page.

    Attributes:
        template: name of its template.
        kind: what is reported, for the line above the title.
        title: title of the page.
        verdict: sentences of the verdict; the first one answers the question.
        facts: (name, value) of what a reader needs to place the page.
        sections: (identifier, title) of the template's own sections, for the list of contents.
        questions: threats to validity.
        commands: command lines that repeat it.
        versions: package -> version.
        content: further values that the template uses.
    """

    template: str
    kind: str
    title: str
    verdict: Sequence[str]
    facts: Sequence[tuple[str, str]]
    sections: Sequence[tuple[str, str]]
    questions: Sequence[Question] = ()
    commands: Sequence[str] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    content: Mapping[str, object] = field(default_factory=dict)


def html(page: Page) -> str:
    """The page as one HTML document without links to other files."""
    from ... import __version__

    template = _environment().get_template(page.template)
    return template.render(page=page, version=__version__, **page.content)


def names(values: Iterable[str]) -> list[Cell]:
    """Cells with names at the left of a row; long names are shortened."""
    return [Cell(shortened(value, NAME_CHARACTERS), "name") for value in values]


def numbers(values: Iterable[float | None], digits: int = 3) -> list[Cell]:
    """Cells with numbers."""
    return [Cell(number(value, digits)) for value in values]


@functools.cache
def _environment() -> Environment:
    """The templates. Everything that is put into them is escaped, and a value that is not there is an error."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update({
        "number": number, "signed": signed, "percent": percent, "interval": interval, "p_value": p_value,
        "counted": counted, "agent": agent, "shortened": shortened,
    })  # fmt: skip
    return environment
