"""What a recording of several sessions shows of all of them: a table of differences, and curves on common axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from statistics import fmean

import rerun as rr

from .curves import PALETTE
from .entity_stream import EntityStream
from .explanation import TIMING_CLASSES, DelayReport, as_markdown, classify_step

COLOURS = (PALETTE[1], PALETTE[2], PALETTE[3])
"""Colours of the sessions' curves, in their order."""

CAUTION = "One session is one sample: these differences say nothing about the methods."
"""Stands below the table of differences."""

MEANS: Mapping[str, Callable[[DelayReport], list[float]]] = {
    "GSI, full edges": lambda report: [graph.gsi_full_edges for graph in report.graphs],
    "GSI, paper's edges": lambda report: [graph.gsi for graph in report.graphs],
    "GSI, true onsets, full edges": lambda report: [graph.gsi_truth for graph in report.graphs],
    "timing appropriateness [s]": lambda report: [value for _, value in report.ta],
    "robot behind the dancers, true onsets [s]": lambda report: [step.late_s for step in report.steps],
}
"""Row of the table -> values of a session whose mean it shows."""


def comparison_as_markdown(reports: Mapping[str, DelayReport]) -> str:
    """Table of the sessions' means and steps with the difference of the last from the first, then each one's summary.

    Args:
        reports: label of each session -> its report.
    """
    labels = list(reports)
    header = ["mean over the session", *labels, f"{labels[-1]} - {labels[0]}"]
    lines = [_row(header), _row(["---", *("--:" for _ in header[1:])])]

    for name, values in MEANS.items():
        means = [_finite_mean(values(report)) for report in reports.values()]
        lines.append(_row([name, *map(_number, means), _number(means[-1] - means[0], sign="+")]))
    counts = [
        [sum(classify_step(step) == name for step in report.steps) for name in TIMING_CLASSES]
        for report in reports.values()
    ]
    differences = [last - first for first, last in zip(counts[0], counts[-1], strict=True)]
    cells = [" / ".join(map(str, session)) for session in counts]
    lines.append(_row([f"steps {' / '.join(TIMING_CLASSES)}", *cells, " / ".join(f"{n:+d}" for n in differences)]))

    lines += ["", CAUTION]
    for label, report in reports.items():
        lines += ["", f"**{label}**", "", as_markdown(report)]
    return "\n".join(lines)


def send_comparison(stream: EntityStream, reports: Mapping[str, DelayReport]) -> None:
    """Send the table, and each session's GSI and lateness as curves of common plots.

    Args:
        stream: without a prefix, since the values belong to no single session.
        reports: label of each session -> its report.
    """
    text = rr.TextDocument(comparison_as_markdown(reports), media_type=rr.MediaType.MARKDOWN)
    stream.log_static("comparison/table", text)

    for index, (label, report) in enumerate(reports.items()):
        curves = {
            "gsi": [(graph.t_s, graph.gsi_full_edges) for graph in report.graphs],
            "late": [(step.t_s, step.late_s) for step in report.steps],
        }
        for name, points in curves.items():
            finite = [(t_s, value) for t_s, value in points if math.isfinite(value)]
            style = rr.SeriesLines(names=label, colors=[COLOURS[index % len(COLOURS)]], widths=[2.5])
            stream.log_static(f"comparison/{name}/{label}", style)
            columns = rr.Scalars.columns(scalars=[value for _, value in finite])
            stream.send_columns(f"comparison/{name}/{label}", [t_s for t_s, _ in finite], columns)


def _row(cells: list[str]) -> str:
    """One line of a Markdown table."""
    return f"| {' | '.join(cells)} |"


def _finite_mean(values: list[float]) -> float:
    """Mean of the finite values; NaN without any."""
    finite = [value for value in values if math.isfinite(value)]
    return fmean(finite) if finite else math.nan


def _number(value: float, sign: str = "") -> str:
    """A number with two decimals; ``-`` for NaN."""
    return "-" if math.isnan(value) else f"{value:{sign}.2f}"
