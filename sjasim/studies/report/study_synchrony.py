"""Synchrony in the page of a study: charts of the group synchronisation index, and its tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...assets import published_study as published
from .charts import Interval, Line, by_category, intervals
from .page import Cell, Figure, Table, numbers
from .svg import series, swatch
from .text import condition_text, counted, interval, number, percent

FIXED_SERIES = {"eca": 0, "sia": 1}
"""Condition -> index of its series, so that these two look the same in every report."""

SHAPES = ("circle", "square", "right", "star", "left", "bar")
"""Markers of the conditions, so that they are told apart without their colours."""

INDICES = {"gsi": "published rule", "gsi_full_edges": "all", "gsi_humans": "dancers only"}
"""Key of an index -> which pairs of agents it counts."""

SURROGATES = {
    "pseudo_groups": "people who never met",
    "interval_shuffle": "shuffled intervals",
    "uniform_shift": "shifted events",
}
"""Kind of surrogates -> its text."""

MOST_GROUPS = 40
"""Largest number of groups in the table of a page."""

MOST_CHARTED = 6
"""Largest number of conditions in a chart; with more of them the lines cannot be told apart."""

PUBLISHED_LEGEND = "as published"


def condition_series(conditions: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Condition -> class and marker of its series.

    Args:
        conditions: names of all conditions.
    """
    free = iter(range(len(FIXED_SERIES), len(FIXED_SERIES) + len(conditions)))
    indices = {name: FIXED_SERIES[name] if name in FIXED_SERIES else next(free) for name in conditions}
    return {name: (series(index), SHAPES[index % len(SHAPES)]) for name, index in indices.items()}


def robot_conditions(content: Mapping[str, Any]) -> list[str]:
    """Names of the conditions with a robot, in order.

    Args:
        content: content of study.json.
    """
    return [name for name in content["conditions"] if name in content["ta"]]


def charted_conditions(content: Mapping[str, Any]) -> list[str]:
    """Names of the conditions that charts show: the first `MOST_CHARTED` ones with a robot."""
    return robot_conditions(content)[:MOST_CHARTED]


def legend(conditions: Sequence[str], styles: Mapping[str, tuple[str, str]]) -> list[tuple[Any, str]]:
    """Legend of conditions, with the published values if there are some.

    Args:
        conditions: those that a chart shows.
        styles: from `condition_series`.
    """
    entries = [(swatch([(styles[name][1], f"{styles[name][0]} fill")]), condition_text(name)) for name in conditions]
    if any(name in published.GSI for name in conditions):
        entries.append((swatch([("diamond", "ink hollow")]), PUBLISHED_LEGEND))
    return entries


def synchrony_figures(content: Mapping[str, Any], styles: Mapping[str, tuple[str, str]]) -> list[Figure]:
    """Charts of the index: means with chance levels, and means by iteration.

    Args:
        content: content of study.json.
        styles: from `condition_series`.
    """
    conditions = charted_conditions(content)
    return [_index_figure(content, conditions, styles), _iteration_figure(content, conditions, styles)]


def synchrony_table(content: Mapping[str, Any]) -> Table:
    """The indices of every condition, each with its interval, chance level and published value.

    Args:
        content: content of study.json.
    """
    rows = []
    for name in content["conditions"]:
        # Without a robot there is only the index of the dancers.
        shown = INDICES if name in content["ta"] else ("gsi_humans",)
        for index in shown:
            own = content[index][name]
            chance = chance_of(content, name, index)
            known = name in published.GSI and index == "gsi"
            rows.append([
                Cell(condition_text(name), "name"), Cell(INDICES[index], "name"),
                *numbers([own["mean"]]), Cell(interval(own["low"], own["high"])), *numbers([own["sd"]]),
                *numbers([chance.get("mean"), chance.get("p95")]), Cell(percent(chance.get("above_p95"), 0)),
                *numbers([float(np.mean(published.GSI[name])), _sd(published.GSI[name])] if known else [None, None]),
            ])  # fmt: skip
    return Table(
        "Group synchronisation index: means over groups",
        (
            "condition", "edges", "mean", "95 % interval", "s.d.", "mean", "95 % below", "iterations above", "mean",
            "s.d.",
        ),
        rows,
        f"s.d.: of the iterations, as published. {_chance_note(content)}",
        above=(("", 2), ("this study", 3), ("by chance", 3), ("published", 2)),
    )  # fmt: skip


def surrogate_table(content: Mapping[str, Any]) -> Table | None:
    """Chance levels of the index with all edges by every kind of surrogate; None without one.

    Args:
        content: content of study.json.
    """
    rows = []
    for name in robot_conditions(content):
        chance = (content.get("chance") or {}).get(name)
        levels = chance["surrogates"] if chance else {}
        pairs = [(levels.get(kind) or {}).get("gsi_full_edges") or {} for kind in SURROGATES]
        if any(pairs):
            found = [value for level in pairs for value in (level.get("mean"), level.get("p95"))]
            rows.append([
                Cell(condition_text(name), "name"), *numbers([content["gsi_full_edges"][name]["mean"], *found])
            ])  # fmt: skip
    if not rows:
        return None
    return Table(
        "What would be found by chance: index with all edges of three kinds of surrogates",
        ("condition", "this study", *(["mean", "95 % below"] * len(SURROGATES))),
        rows,
        "People who never met share music and dance, but not the room; this is the level to compare with. Shuffled "
        "intervals keep how long moves last, and lose when they come. Shifted events keep the intervals, and lose "
        "their time in the music.",
        above=(("", 2), *((text, 2) for text in SURROGATES.values())),
    )


def group_table(content: Mapping[str, Any]) -> Table:
    """The index of every group in every iteration, as in the published table.

    Args:
        content: content of study.json.
    """
    conditions = robot_conditions(content)
    groups = content["table"]
    shown = groups[:MOST_GROUPS]
    iterations = [entry["iteration"] for entry in groups[0]["iterations"]] if groups else []

    rows = []
    for group in shown:
        entries = {entry["iteration"]: entry for entry in group["iterations"]}
        cells = [
            [
                *(_best_cell(entries.get(number), name, 2) for number in iterations),
                Cell(number(group["mean"][name], 2), "best" if name in group["best"] else ""),
            ]
            for name in conditions
        ]
        rows.append([Cell(str(group["group"])), *(cell for own in cells for cell in own)])

    left_out = len(groups) - len(shown)
    note = "Bold: the higher value of the same group and iteration, or of the means."
    if left_out:
        note += f" {counted(left_out, 'further group')} are in iterations.parquet."
    return Table(
        "This study: index of each group (published edge rule)",
        ("group", *([*map(str, iterations), "mean"] * len(conditions))),
        rows,
        note,
        above=_above(conditions, len(iterations)),
    )


def published_table() -> Table:
    """The published table in the same layout."""
    conditions = list(published.GSI)
    rows = []
    for index in range(len(published.GSI["eca"])):
        row = [Cell(str(index + 1))]
        for name in conditions:
            values = published.GSI[name][index]
            others = [published.GSI[other][index] for other in conditions if other != name]
            best = [all(value > other[i] for other in others) for i, value in enumerate(values)]
            row += [Cell(number(value, 2), "best" if high else "") for value, high in zip(values, best, strict=True)]
            # Means are compared before they are rounded, as in the article.
            highest = max(published.GSI, key=lambda other: sum(published.GSI[other][index]))
            row.append(Cell(number(published.GSI_GROUP_MEANS[name][index], 2), "best" if name == highest else ""))
        rows.append(row)
    return Table(
        "The published study: index of each group",
        ("group", *(["1", "2", "3", "4", "mean"] * len(conditions))),
        rows,
        "From Iqbal, Rack and Riek 2016, table I. Group 1 there and group 1 here are different people.",
        above=_above(conditions, 4),
    )


def chance_of(content: Mapping[str, Any], condition: str, index: str = "gsi") -> Mapping[str, Any]:
    """Chance level of an index under a condition, from people who never met; empty where none was computed.

    Args:
        content: content of study.json.
        condition: name of the condition.
        index: one of `INDICES`.
    """
    chance = (content.get("chance") or {}).get(condition)
    levels = chance["surrogates"].get("pseudo_groups") if chance else None
    return levels[index] if levels else {}


def _index_figure(
    content: Mapping[str, Any], conditions: Sequence[str], styles: Mapping[str, tuple[str, str]]
) -> Figure:
    """Mean index of every condition, with the chance level as a band and the published mean below."""
    rows = []
    for name in conditions:
        own = content["gsi"][name]
        chance = chance_of(content, name)
        known = chance.get("mean") is not None and chance.get("p95") is not None
        band = (chance["mean"], chance["p95"]) if known else None
        style, shape = styles[name]
        rows.append(Interval(condition_text(name), style, own["mean"], own["low"], own["high"], shape, band=band))
        if name in published.GSI:
            mean, low, high = published_interval(published.GSI_GROUP_MEANS[name])
            rows.append(Interval("published", style, mean, low, high, "diamond", hollow=True))

    described = "; ".join(f"{row.label} {number(row.value)} {interval(row.low, row.high)}" for row in rows)
    entries = legend(conditions, styles)
    if any(row.band for row in rows):
        entries.append(
            (swatch([("block", "band")]), "chance: from its mean to the value that 95 % of iterations stay below")
        )
    return Figure(
        intervals("Synchrony of the group", described, "group synchronisation index", rows),
        "Mean over groups with its 95 % interval. The published interval is computed here from the nine group means by "
        "Student's t.",
        entries,
    )


def _iteration_figure(
    content: Mapping[str, Any], conditions: Sequence[str], styles: Mapping[str, tuple[str, str]]
) -> Figure:
    """Mean index by iteration, with the published means dashed."""
    numbers_of = sorted({entry["iteration"] for name in conditions for entry in content["gsi"][name]["by_iteration"]})
    lines = []
    for name in conditions:
        style, shape = styles[name]
        entries = {entry["iteration"]: entry for entry in content["gsi"][name]["by_iteration"]}
        values = [entries[index]["mean"] if index in entries else None for index in numbers_of]
        ends = [_ends(entries.get(index)) for index in numbers_of]
        lines.append(Line(name, style, values, ends, shape))
        if name in published.GSI:
            means = np.mean(published.GSI[name], axis=0).tolist()
            shown = [means[index - 1] if 1 <= index <= len(means) else None for index in numbers_of]
            lines.append(Line(f"{name}, published", style, shown, shape="diamond", published=True))

    described = "; ".join(f"{line.name}: {', '.join(number(value, 2) for value in line.values)}" for line in lines)
    return Figure(
        by_category(
            "Synchrony by iteration", described, "group synchronisation index",
            ("iteration", [str(index) for index in numbers_of]), lines,
        ),
        "Mean over groups in each iteration with its 95 % interval. Published means are dashed.",
        legend(conditions, styles),
    )  # fmt: skip


def published_interval(values: Sequence[float]) -> tuple[float, float, float]:
    """Mean of a few published values with its 95 % interval by Student's t.

    Args:
        values: one value for each group.
    """
    from scipy import stats

    mean = float(np.mean(values))
    half = float(stats.t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values)))
    return mean, mean - half, mean + half


def _best_cell(entry: Mapping[str, Any] | None, name: str, digits: int) -> Cell:
    if entry is None:
        return Cell(number(None))
    return Cell(number(entry["gsi"][name], digits), "best" if name in entry["best"] else "")


def _above(conditions: Sequence[str], iterations: int) -> list[tuple[str, int]]:
    """Line above the heads of a table of groups: the condition over its iterations and its mean."""
    return [("", 1), *((f"{condition_text(name)}: iterations", iterations + 1) for name in conditions)]


def _ends(entry: Mapping[str, Any] | None) -> tuple[float, float] | None:
    if entry is None or entry["low"] is None or entry["high"] is None:
        return None
    return entry["low"], entry["high"]


def _sd(values: Sequence[Sequence[float]]) -> float:
    """Sample standard deviation of published values."""
    return float(np.std(values, ddof=1))


def _chance_note(content: Mapping[str, Any]) -> str:
    if not any(chance_of(content, name) for name in content["conditions"]):
        return (
            "No chance level could be computed: the study kept no events, or has too few groups. Without it, an index "
            "cannot be called high or low."
        )
    return (
        "By chance: the index of people who never met, mixed from different groups. 5 % of their iterations are above "
        "the second value; the third is the share of the iterations of this study that are."
    )
