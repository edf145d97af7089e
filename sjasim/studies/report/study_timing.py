"""Timing of the robot in the page of a study: the published figures redrawn, and tests of differences."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ...assets import published_study as published
from .axes import axis_top
from .charts import Bars, Curve, Interval, cumulative_curves, histogram, intervals, line_style
from .page import Cell, Figure, Table, numbers
from .study_synchrony import charted_conditions, legend, robot_conditions
from .svg import Point, swatch
from .text import condition_text, interval, number, p_value, percent, signed

LIMITS = ("0.8", "1.2", "1.6")
"""Distances at which the published study reads off the cumulative share [s]."""

MEASURES = {
    "gsi": ("GSI, published edge rule", 3),
    "gsi_full_edges": ("GSI, all edges", 3),
    "gsi_humans": ("GSI, dancers alone", 3),
    "ta_mean_s": ("TA [s]", 3),
}
"""Measure -> its name and number of decimals."""

SURE = 0.05
"""Probability below which a difference is called shown."""

MOST_COMPARISONS = 60
"""Largest number of rows in the table of comparisons of a page."""


def timing_figures(content: Mapping[str, Any], styles: Mapping[str, tuple[str, str]]) -> list[Figure]:
    """Histograms of all conditions, their cumulative curves together, and means with intervals.

    Args:
        content: content of study.json.
        styles: from `study_synchrony.condition_series`.
    """
    conditions = [name for name in charted_conditions(content) if content["ta"][name]["n"]]
    curves = {name: _curve(content["ta"][name], name, styles[name][0], index) for index, name in enumerate(conditions)}
    if not conditions:
        return []
    # Histograms that stand side by side have the same scale.
    top = axis_top(max(share for name in conditions for share in _shares(content["ta"][name])))
    return [
        *(_histogram_figure(content["ta"][name], curves[name], top) for name in conditions),
        _cumulative_figure(content, list(curves.values())),
        _mean_figure(content, conditions, styles),
    ]


def timing_table(content: Mapping[str, Any]) -> Table:
    """Timing appropriateness of every condition beside the published values.

    Args:
        content: content of study.json.
    """
    rows = []
    for name in robot_conditions(content):
        own = content["ta"][name]
        rows.append([
            Cell(condition_text(name), "name"),
            *numbers([own["mean_s"]], 2), Cell(interval(own["low_s"], own["high_s"], 2)), *numbers([own["sd_s"]], 2),
            *(Cell(percent(own["cdf"].get(limit))) for limit in LIMITS),
            Cell(str(own["n"])), Cell(str(own["missed"])),
        ])  # fmt: skip
        if name in published.TA_MEAN_S:
            within = {f"{limit:g}": share for limit, share in published.TA_SHARE_WITHIN[name].items()}
            rows.append([
                Cell(f"{condition_text(name)}, published", "name"),
                *numbers([published.TA_MEAN_S[name]], 2), Cell(number(None)), *numbers([published.TA_SD_S[name]], 2),
                *(Cell(percent(within.get(limit))) for limit in LIMITS),
                Cell(number(None)), Cell(number(None)),
            ])  # fmt: skip
    return Table(
        "Timing appropriateness: distance of the robot's events from the dancers' mean",
        (
            "condition", "mean [s]", "95 % interval [s]", "s.d. [s]", *(f"within {limit} s" for limit in LIMITS),
            "steps", "missed",
        ),
        rows,
        "Mean and s.d. are those of all steps, as published. The interval is that of the mean over groups.",
    )  # fmt: skip


def comparison_table(content: Mapping[str, Any]) -> Table:
    """Differences between conditions with intervals and tests at group level.

    Args:
        content: content of study.json.
    """
    every = content["comparisons"]
    rows = []
    for item in every[:MOST_COMPARISONS]:
        text, digits = MEASURES.get(item["measure"], (item["measure"], 3))
        rows.append([
            *(Cell(words, "name") for words in (text, condition_text(item["second"]), condition_text(item["first"]))),
            Cell(str(item["groups"])),
            Cell(signed(item["difference"], digits)),
            Cell(interval(item["low"], item["high"], digits)),
            Cell(number(item["p"])), Cell(number(item["p_adjusted"]), "best" if is_shown(item) else ""),
            *numbers([item["d_z"]["value"], item["rank_biserial"]["value"]], 2),
        ])  # fmt: skip
    return Table(
        "Differences between conditions, with the group as unit",
        (
            "measure", "condition", "minus", "groups", "difference", "95 % interval", "p", "p adjusted", "d_z",
            "rank-biserial",
        ),
        rows,
        _comparison_note(every),
    )  # fmt: skip


def event_test_sentence(content: Mapping[str, Any]) -> str:
    """The published test over steps, beside the published result; "" without it.

    Args:
        content: content of study.json.
    """
    test = content["wilcoxon"]
    if not test:
        return ""
    first, second = map(condition_text, test["pair"])
    sentence = (
        f"The published test compares single steps: signed ranks of the timing appropriateness of {second} and {first} "
        f"give z = {number(test['z'], 2)}, {p_value(test['p'])} and r = {number(test['r'], 2)} ({test['n']} "
        f"observations)."
    )
    if set(test["pair"]) == {"eca", "sia"}:
        sentence += f" Published are z = {number(published.WILCOXON_Z, 2)} and r = {number(published.WILCOXON_R, 2)}."
    return (
        f"{sentence} Steps of a session depend on each other, so that this test finds differences too often. The tests "
        "above take the group as the unit."
    )


def is_shown(item: Mapping[str, Any]) -> bool:
    """Whether a comparison shows a difference after adjustment for several comparisons."""
    return item["p_adjusted"] is not None and item["p_adjusted"] < SURE


def _histogram_figure(figures: Mapping[str, Any], curve: Curve, top: float) -> Figure:
    """The published histogram of one condition."""
    own = figures["histogram"]
    *shares, overflow = _shares(figures)
    title = f"Timing appropriateness under {condition_text(curve.name)}"
    entries = [
        (swatch([("block", f"{curve.style} fill soft")]), "events"),
        (swatch([("line", "ink stroke")]), "cumulative share"),
    ]
    if curve.published:
        entries.append((swatch([("diamond", f"{curve.style} hollow")]), "published cumulative share"))
    return Figure(
        histogram(title, f"{own['n']} events; {_within(figures)}.", Bars(shares, overflow, top), curve),
        f"{title}: bins of 0.1 s as published. {own['n']} events, {own['overflow']} of them beyond "
        f"{number(own['edges_s'][-1], 1)} s.",
        entries,
    )


def _cumulative_figure(content: Mapping[str, Any], curves: Sequence[Curve]) -> Figure:
    """Cumulative curves of all conditions in one chart."""
    described = "; ".join(f"{curve.name}: {_within(content['ta'][curve.name])}" for curve in curves)
    entries = [(swatch([("line", line_style(curve))]), condition_text(curve.name)) for curve in curves]
    if any(curve.published for curve in curves):
        entries.append((swatch([("diamond", "ink hollow")]), "published"))
    return Figure(
        cumulative_curves("Cumulative share of the robot's events", described, curves, published.TA_LAST_EDGE_S),
        "Cumulative share of all conditions. The farther left a curve rises, the better the timing.",
        entries,
    )


def _mean_figure(
    content: Mapping[str, Any], conditions: Sequence[str], styles: Mapping[str, tuple[str, str]]
) -> Figure:
    """Mean timing appropriateness with intervals, beside the published ones."""
    rows = []
    for name in conditions:
        own = content["ta"][name]
        style, shape = styles[name]
        rows.append(Interval(condition_text(name), style, own["group_mean_s"], own["low_s"], own["high_s"], shape))
        if name in published.TA_MEAN_S:
            mean = published.TA_MEAN_S[name]
            half = 1.96 * published.TA_SD_S[name] / math.sqrt(published_events())
            rows.append(Interval("published", style, mean, mean - half, mean + half, "diamond", hollow=True))
    described = "; ".join(f"{row.label} {number(row.value, 2)} s {interval(row.low, row.high, 2)}" for row in rows)
    return Figure(
        intervals("Mean timing appropriateness", described, "timing appropriateness [s]", rows),
        "Mean with its 95 % interval. Ours takes groups as the unit. The published one is computed here from the "
        f"published standard deviation and {published_events()} events, which it takes as independent; it is therefore "
        "too narrow.",
        legend(conditions, styles),
    )


def published_events() -> int:
    """Number of events per method that the published test implies: half of (z / r) squared.

    Source: iqbal2016, section VI-B.
    """
    return round((published.WILCOXON_Z / published.WILCOXON_R) ** 2 / 2)


def _curve(figures: Mapping[str, Any], name: str, style: str, index: int) -> Curve:
    """The cumulative curve of a condition, with published points if there are some."""
    own = figures["histogram"]
    points: list[Point] = [(edge, 100.0 * share) for edge, share in zip(own["edges_s"], own["cumulative"], strict=True)]
    known = published.TA_SHARE_WITHIN.get(name, {})
    return Curve(name, style, points, [(limit, 100.0 * share) for limit, share in known.items()], dashed=index % 2 == 1)


def _shares(figures: Mapping[str, Any]) -> list[float]:
    """Share of the events in each bin, and beyond the last one [%]."""
    own = figures["histogram"]
    return [100.0 * count / max(1, own["n"]) for count in (*own["counts"], own["overflow"])]


def _within(figures: Mapping[str, Any]) -> str:
    """Shares of events within each of `LIMITS`, in words."""
    return ", ".join(f"{percent(figures['cdf'].get(limit))} within {limit} s" for limit in LIMITS)


def _comparison_note(comparisons: Sequence[Mapping[str, Any]]) -> str:
    if not comparisons:
        return "There is only one condition, or no group danced two of them."
    first = comparisons[0]
    left_out = max(item["left_out"] for item in comparisons)
    note = (
        f"Test: {first['test']}; with {first['groups']} groups no p is below {first['smallest_p']:.2g}. Adjusted for "
        f"several comparisons of a measure ({first['adjustment']}). d_z is the mean difference over its standard "
        "deviation; the rank-biserial correlation is 1 if every group differs in the same direction."
    )
    if left_out:
        note += f" Up to {left_out} groups lack one of the conditions and are left out."
    if len(comparisons) > MOST_COMPARISONS:
        note += f" {len(comparisons) - MOST_COMPARISONS} further comparisons are in study.json."
    return note
