"""The page of a reproduction: every published value beside the interval of its simulated counterpart."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from .axes import Scale
from .page import Cell, Page, Question, Table
from .svg import Drawing
from .text import NAME_CHARACTERS, condition_text, counted, interval, number, shortened

STRIP_WIDTH = 130.0
"""Width of the drawing in a row [px]."""

STRIP_HEIGHT = 18.0
"""Height of the drawing in a row [px]."""

STRIP_REACH = 2.2
"""Farthest value that a drawing shows, in half widths of the interval from its middle."""

PAPER = "paper"
"""Name of the study of Iqbal, Rack and Riek."""

OPTIONS = ("studies", "groups", "fidelity", "seed")
"""Options of the command that the file holds under their own names."""

ROLES = {"fitted": "fitted", "held_out": "held out"}
"""Role of a row -> its text."""

SECTIONS = (("values", "The published values"), ("findings", "Findings"))


def reproduction_page(content: Mapping[str, Any]) -> Page:
    """The page.

    Args:
        content: content of reproduce.json.
    """
    rows = [_normalised(row) for row in content["rows"]]
    settings = {**content, **content.get("settings", {})}
    study = str(content.get("study", PAPER))
    people = shortened(str(settings.get("preset", study)), NAME_CHARACTERS)
    title = f"The published study, value by value, with the people of {people}"
    return Page(
        template="reproduction.html",
        kind="reproduction of a published study",
        title=title if study == PAPER else f"Published values of {study}, one by one",
        verdict=_verdict(rows, people, settings["studies"]),
        facts=_facts(rows, settings, people),
        sections=SECTIONS,
        questions=_questions(rows),
        commands=(_command_line(settings, study),),
        versions=content.get("versions", {}),
        content={
            "is_paper": study == PAPER,
            "value_table": _value_table(rows),
            "findings": [_finding(item) for item in content.get("findings", ())],
        },
    )


def _normalised(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row with the keys of the published study's; other studies name the condition and what people did."""
    name = str(row.get("meaning") or row["value"]).replace("_", " ")
    method = condition_text(str(row.get("method") or row.get("condition") or ""))
    return {
        **row,
        "name": shortened(f"{name}, {method}" if method else name, 2 * NAME_CHARACTERS),
        "paper": row["paper"] if "paper" in row else row["people"],
        "role": row["role"].replace(" ", "_"),
    }


def _verdict(rows: Sequence[Mapping[str, Any]], people: str, studies: int) -> list[str]:
    """How many of the published values lie inside, and which do not."""
    outside = [row["name"] for row in rows if not row["inside"]]
    held_out = [row for row in rows if row["role"] != "fitted"]
    inside = sum(bool(row["inside"]) for row in held_out)
    first = (
        f"{len(rows) - len(outside)} of {len(rows)} published values lie inside the 95 % interval of "
        f"{studies} simulated studies with the people of {people}."
    )
    second = f"Outside: {'; '.join(outside)}." if outside else "No value lies outside."
    if not held_out:
        return [first, f"{second} All values were used to fit the people."]
    return [first, f"{second} {inside} of {len(held_out)} values that were not used to fit the people lie inside."]


def _facts(rows: Sequence[Mapping[str, Any]], settings: Mapping[str, Any], people: str) -> list[tuple[str, str]]:
    facts = [("people", people), ("simulated studies", str(settings["studies"]))]
    facts += [(name, str(settings[name])) for name in ("fidelity", "groups", "seed") if settings.get(name) is not None]
    roles = [row["role"] for row in rows]
    return [*facts, *((text, counted(roles.count(role), "value")) for role, text in ROLES.items() if role in roles)]


def _command_line(settings: Mapping[str, Any], study: str) -> str:
    """The command line that makes the same file."""
    words = ["sjasim", "reproduce", *([] if study == PAPER else [study])]
    options = {"humans": settings.get("preset"), **{name: settings.get(name) for name in OPTIONS}}
    for name, value in options.items():
        if value is not None:
            words += [f"--{name}", str(value)]
    return shlex.join([*words, "--out", "DIR"])


def _value_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """One row for each published value."""
    cells = [
        [
            Cell(row["name"], "name"),
            Cell(_value(row["paper"])),
            Cell(_value(row["mean"])),
            Cell(interval(row["low"], row["high"], _digits(row))),
            Cell(_strip(row), "name"),
            Cell("inside", "name") if row["inside"] else Cell("outside", "bad"),
            Cell(ROLES.get(row["role"], row["role"]), "name"),
        ]
        for row in rows
    ]
    return Table(
        "Published and simulated values",
        ("value", "published", "simulated mean", "95 % interval", "place", "", "role"),
        cells,
        "Place: the bar is the simulated interval, the line its mean, and the diamond the published value; an arrow at "
        "an end means that it lies farther away. Fitted values were used to choose the parameters of the people; "
        "held-out values were not.",
    )


def _strip(row: Mapping[str, Any]) -> Markup:
    """A small drawing: interval as a bar, mean as a line, published value as a diamond."""
    low = row["low"]
    high = row["high"]
    if low is None or high is None or row["paper"] is None or not high > low:
        return Markup("")

    reach = STRIP_REACH * (high - low) / 2
    x = Scale((low + high) / 2 - reach, (low + high) / 2 + reach, 0.0, STRIP_WIDTH)
    where = "inside" if row["inside"] else "outside"
    drawing = Drawing(STRIP_WIDTH, STRIP_HEIGHT, f"place of {row['name']}", f"The published value lies {where}.")

    drawing.line((0, 9), (STRIP_WIDTH, 9), "grid")
    drawing.rectangle((x(low), 4), x(high) - x(low), 10, "band")
    if row["mean"] is not None:
        drawing.line((x(row["mean"]), 3), (x(row["mean"]), 15), "ink stroke")

    place = x(row["paper"])
    style = "c0 fill" if row["inside"] else "fault fill"
    if 6.0 <= place <= STRIP_WIDTH - 6.0:
        drawing.marker((place, 9), "diamond", style)
    else:
        # The value is beyond the drawing, so that an arrow stands at its end.
        drawing.marker((6.0, 9) if place < 6.0 else (STRIP_WIDTH - 6.0, 9), "left" if place < 6.0 else "right", style)
    return drawing.markup()


def _finding(item: object) -> tuple[str, str]:
    """Title and text of a finding, which is a sentence or a table with these keys and perhaps an interval."""
    if not isinstance(item, Mapping):
        return "", str(item)
    title = str(item.get("title") or item.get("finding") or "")
    text = str(item.get("text") or "")
    if item.get("low") is not None and item.get("high") is not None:
        text = f"{text} {_value(item.get('mean'))} {interval(item['low'], item['high'])}".strip()
    return title, text


def _questions(rows: Sequence[Mapping[str, Any]]) -> list[Question]:
    """Threats to validity of a reproduction."""
    fitted = sum(row["role"] == "fitted" for row in rows)
    return [
        Question(
            "Is agreement with fitted values evidence?",
            f"Little. {fitted} of the {len(rows)} values were used to choose the parameters of the people, and would "
            "agree with many models. The held-out values are the test.",
        ),
        Question(
            "Do wide intervals make everything fit?",
            "An interval covers 95 % of simulated studies of the published size, which are small. The negative control "
            "is the preset musicians, whose timing is far too steady: with it several values must lie outside.",
        ),
        Question(
            "Why not one simulated study beside the published one?",
            "Single studies of nine groups differ widely. Even a perfect model would miss a count such as 22 of 36 in "
            "most single studies.",
        ),
        Question(
            "Are the published values certain?",
            "Not all. The text and a table of the article's source exchange the standard deviations of timing "
            "appropriateness, printed values are rounded, and the article does not give every parameter of its "
            "methods.",
        ),
    ]


def _digits(row: Mapping[str, Any]) -> int:
    """Decimals for a row: fewer for large values."""
    largest = max((abs(row[key]) for key in ("paper", "low", "high") if row[key] is not None), default=0.0)
    return 1 if largest >= 10.0 else 2 if largest >= 3.0 else 3


def _value(value: float | None) -> str:
    """A value with three decimals; whole numbers and large ones with fewer."""
    if value is None:
        return number(None)
    if float(value).is_integer() and abs(value) >= 1.0:
        return number(value, 0)
    return number(value, 1 if abs(value) >= 10.0 else 3)
