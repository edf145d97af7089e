"""The page of a power analysis, and its part in the page of a study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .charts import Band, band_curve
from .page import Cell, Figure, Page, Question, Table
from .svg import swatch
from .text import condition_text, counted, number, percent, signed

MEASURES = {
    "gsi": "group synchronisation index (published rule)",
    "gsi_full_edges": "group synchronisation index (all edges)",
    "gsi_humans": "group synchronisation index of the dancers alone",
    "ta_mean_s": "mean timing appropriateness [s]",
}
"""Measure -> what it is."""

SOURCES = {"simulated": "as simulated", "paper": "as published", "given": "as given"}
"""Source of the difference -> its text."""

SECTIONS = (("curve", "Power by number of groups"),)


def power_page(content: Mapping[str, Any]) -> Page:
    """The page.

    Args:
        content: content of power.json.
    """
    design = content["design"]
    first, second = map(condition_text, design["methods"])

    return Page(
        template="power.html",
        kind="power analysis",
        title=f"How many groups show a difference between {first} and {second}",
        verdict=[power_sentence(content), _effect_sentence(content)],
        facts=[
            ("measure", MEASURES.get(design["measure"], design["measure"])),
            ("test", str(content["test"])),
            ("level of the test", str(design["alpha"])),
            ("simulated groups", str(content["pool"])),
            ("people", str(design["humans"]) if content["study"] is None else "those of the study"),
            ("seed", str(design["seed"])),
        ],
        sections=SECTIONS,
        questions=_questions(),
        commands=(_command_line(content),),
        versions=content["versions"],
        content={"figure": power_figure(content), "table": _table(content)},
    )


def power_figure(content: Mapping[str, Any]) -> Figure:
    """Power by number of groups, with its interval.

    Args:
        content: content of power.json.
    """
    target = 100.0 * content["design"]["target"]
    points = [
        Band(row["groups"], *(100.0 * row[key] for key in ("power", "low", "high")))
        for row in content["rows"]
        if row["power"] is not None
    ]
    described = "; ".join(f"{counted(round(item.x), 'group')}: {number(item.value, 0)} %" for item in points)
    return Figure(
        band_curve("Power by number of groups", described, ("number of groups", "power [%]"), points, target),
        f"Share of simulated studies in which the test shows the difference. The dashed line is the power that was "
        f"asked for, {number(target, 0)} %.",
        [
            (swatch([("line", "c0 stroke")]), "power"),
            (swatch([("block", "c0 fill pale")]), "95 % interval"),
            (swatch([("line", "ink thin dashed")]), "asked for"),
        ],
    )


def power_sentence(content: Mapping[str, Any]) -> str:
    """How many groups are needed, in words.

    Args:
        content: content of power.json.
    """
    design = content["design"]
    first, second = map(condition_text, design["methods"])
    what = f"to find the difference between {first} and {second} with a power of {percent(design['target'], 0)}"
    needed = content["groups_needed"]
    if needed is None:
        return f"{design['max_groups']} groups are not enough {what}."
    low = content["groups_needed_low"]
    high = content["groups_needed_high"]
    ends = f" (95 % interval {low} to {high})" if low is not None and high is not None else ""
    return f"{counted(needed, 'group')} are needed{ends} {what}."


def _effect_sentence(content: Mapping[str, Any]) -> str:
    """The difference that is to be found, and how much groups differ."""
    effect = content["effect"]
    measure = content["design"]["measure"]
    return (
        f"That difference is {signed(effect['difference'])} in the {MEASURES.get(measure, measure)} "
        f"({SOURCES.get(effect['source'], effect['source'])}); between groups it varies by {number(effect['sd'])} "
        "(s.d.)."
    )


def _table(content: Mapping[str, Any]) -> Table:
    rows = [
        [
            Cell(str(row["groups"])),
            Cell(percent(row["power"])),
            Cell(f"{percent(row['low'])} to {percent(row['high'])}"),
        ]
        for row in content["rows"]
    ]
    return Table("Power by number of groups", ("groups", "power", "95 % interval"), rows)


def _questions() -> list[Question]:
    """Threats to validity of a power analysis."""
    return [
        Question(
            "Is the effect that of people?",
            "It is that of simulated people, or a given one. People may differ more between groups than the simulated "
            "ones do, and more groups are needed then. Take the number as a lower bound.",
        ),
        Question(
            "Which groups are counted?",
            "Groups that danced under both methods. Add those who may drop out.",
        ),
    ]


def _command_line(content: Mapping[str, Any]) -> str:
    design = content["design"]
    words = ["sjasim power --methods", *design["methods"]]
    if content["study"] is not None:
        words += ["--study", content["study"]]
    for name in ("measure", "effect", "target", "alpha", "max_groups", "pool", "humans", "fidelity", "seed"):
        words += [f"--{name.replace('_', '-')}", str(design[name])]
    return " ".join([*words, "--out DIR"])
