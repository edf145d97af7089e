"""Charts of a study: histogram, cumulative curves, values by iteration, and intervals.

Each chart is drawn at a width at which its text can be read on a narrow screen, so that charts stand side by side on a
wide screen and below each other on a narrow one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from markupsafe import Markup

from .axes import Axes, Margins, padded, tick_texts, ticks
from .svg import Drawing, Point
from .text import shortened

WIDTH = 420.0
"""Width of a chart [px]."""

HEIGHT = 290.0
"""Height of a chart [px]."""

LABEL_CHARACTERS = 18
"""Longest label of a row in a chart of intervals."""

SHARES = (0.0, 20.0, 40.0, 60.0, 80.0, 100.0)
"""Ticks of a share [%]."""


@dataclass(frozen=True, slots=True)
class Curve:
    """A cumulative curve.

    Attributes:
        name: what it belongs to.
        style: class of its series.
        points: (value, share [%] of the events up to it) in ascending order.
        published: published points of the same curve.
        dashed: whether the line is dashed, so that it is told apart without its colour.
    """

    name: str
    style: str
    points: Sequence[Point]
    published: Sequence[Point] = ()
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Bars:
    """Bars of a histogram.

    Attributes:
        shares: share of the events in each bin of .1 s from 0 [%].
        overflow: share of the events beyond the last bin [%]; it has a bar of its own.
        top: end of the vertical axis [%], the same for histograms that are compared.
    """

    shares: Sequence[float]
    overflow: float
    top: float


class Band(NamedTuple):
    """A point of a curve with its interval."""

    x: float
    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Interval:
    """A row of a chart of intervals; what is not known is None.

    Attributes:
        label: text at the left.
        style: class of its series.
        value: the estimate.
        low: low end of its interval.
        high: high end of its interval.
        shape: marker of the estimate, as in `svg.MARKERS`.
        hollow: whether the marker is hollow, which stands for published values.
        band: (low, high) range to shade in the row.
    """

    label: str
    style: str
    value: float | None
    low: float | None = None
    high: float | None = None
    shape: str = "circle"
    hollow: bool = False
    band: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Line:
    """A line over categories; a category without a value is left out.

    Attributes:
        name: what it belongs to.
        style: class of its series.
        values: value of each category.
        intervals: (low, high) of each category, or None.
        shape: marker of the values.
        published: whether these are published values: hollow markers and a dashed line.
    """

    name: str
    style: str
    values: Sequence[float | None]
    intervals: Sequence[tuple[float, float] | None] = ()
    shape: str = "circle"
    published: bool = False


def histogram(title: str, description: str, bars: Bars, curve: Curve) -> Markup:
    """Histogram of timing appropriateness with its cumulative curve.

    Args:
        title: title of the drawing.
        description: description of the drawing.
        bars: shares of the events in the bins.
        curve: cumulative share of the same events.
    """
    drawing = Drawing(WIDTH, HEIGHT, title, description)
    last = 0.1 * len(bars.shares)
    axes = Axes(drawing, (0.0, last + 0.3), (0.0, bars.top), Margins(right=44))

    axes.left("robot's events [%]", ticks(0.0, bars.top))
    for index, share in enumerate(bars.shares):
        _bar(axes, 0.1 * index, share, curve.style)
    # The bar of the overflow stands apart, since its bin has no end.
    _bar(axes, last + 0.15, bars.overflow, curve.style)

    cumulative = Axes(drawing, (0.0, last + 0.3), (0.0, 100.0), Margins(right=44))
    for value, text in zip(SHARES, tick_texts(SHARES), strict=True):
        drawing.text((cumulative.x.end + 6, cumulative.y(value) + 4), text)
    drawing.text((WIDTH - 4, cumulative.y.end - 14), "cumulative [%]", "end", "label")
    _curve(cumulative, curve, "ink stroke")

    marks = ticks(0.0, last)
    axes.bottom("distance from the dancers' mean time [s]", marks[:-1], tick_texts(marks)[:-1])
    drawing.text((axes.x(last + 0.2), axes.y.start + 17), f">{last:.1f}", "middle")
    return drawing.markup()


def cumulative_curves(title: str, description: str, curves: Sequence[Curve], end: float) -> Markup:
    """Cumulative curves of several conditions in one chart.

    Args:
        title: title of the drawing.
        description: description of the drawing.
        curves: the curves.
        end: end of the horizontal axis.
    """
    drawing = Drawing(WIDTH, HEIGHT, title, description)
    axes = Axes(drawing, (0.0, end), (0.0, 100.0))
    axes.left("events up to here [%]", SHARES)
    axes.bottom("distance from the dancers' mean time [s]", ticks(0.0, end))
    for curve in curves:
        _curve(axes, curve, line_style(curve))
    return drawing.markup()


def by_category(
    title: str, description: str, label: str, categories: tuple[str, Sequence[str]], lines: Sequence[Line]
) -> Markup:
    """Lines over a few categories, such as the iterations of a dance.

    Args:
        title: title of the drawing.
        description: description of the drawing.
        label: what is drawn vertically, with its unit.
        categories: what is drawn horizontally, and its values.
        lines: the lines; they stand a little beside each other, so that intervals do not hide each other.
    """
    drawing = Drawing(WIDTH, HEIGHT, title, description)
    every = [value for line in lines for value in line.values if value is not None]
    every += [end for line in lines for pair in line.intervals if pair is not None for end in pair]
    low, high = padded(every or [0.0, 1.0])
    what, names = categories
    axes = Axes(drawing, (-0.5, len(names) - 0.5), (low, high))

    axes.left(label, ticks(low, high))
    axes.bottom(what, range(len(names)), names)
    for index, line in enumerate(lines):
        _category_line(axes, line, 0.07 * (index - (len(lines) - 1) / 2))
    return drawing.markup()


def band_curve(title: str, description: str, labels: tuple[str, str], points: Sequence[Band], target: float) -> Markup:
    """A curve of percentages with a band around it, and a level to reach.

    Args:
        title: title of the drawing.
        description: description of the drawing.
        labels: what is drawn horizontally and vertically.
        points: the curve from left to right.
        target: the level [%].
    """
    drawing = Drawing(WIDTH, HEIGHT, title, description)
    ends = (points[0].x, points[-1].x) if len(points) > 1 else (0.0, 1.0)
    axes = Axes(drawing, ends, (0.0, 100.0))
    axes.left(labels[1], SHARES)
    axes.bottom(labels[0], ticks(*ends))

    outline = [(item.x, item.low) for item in points] + [(item.x, item.high) for item in reversed(points)]
    drawing.path([axes.point(x, y) for x, y in outline], "c0 fill pale")
    drawing.path([axes.point(item.x, item.value) for item in points], "c0 stroke")
    drawing.line((axes.x.start, axes.y(target)), (axes.x.end, axes.y(target)), "ink thin dashed")
    return drawing.markup()


def intervals(title: str, description: str, label: str, rows: Sequence[Interval], zero: bool = False) -> Markup:
    """Estimates with their intervals, one row each.

    Args:
        title: title of the drawing.
        description: description of the drawing.
        label: what is drawn, with its unit.
        rows: the rows, from top to bottom.
        zero: whether the axis contains 0, with a line there.
    """
    numbers = [
        number for row in rows for number in (row.value, row.low, row.high, *(row.band or ())) if number is not None
    ]
    low, high = padded([*(numbers or [0.0, 1.0]), *([0.0] if zero else [])])
    drawing = Drawing(WIDTH, 58 + 26 * len(rows), title, description)
    axes = Axes(drawing, (low, high), (len(rows) - 0.5, -0.5), Margins(left=140, top=10))
    # Rows count downwards, so that the vertical scale is upside down.
    for value in ticks(low, high):
        axes.guide(value)
    if zero:
        drawing.line((axes.x(0.0), axes.y.start), (axes.x(0.0), axes.y.end), "axis")
    axes.bottom(label, ticks(low, high))

    for index, row in enumerate(rows):
        _interval(axes, index, row)
    return drawing.markup()


def line_style(curve: Curve) -> str:
    """Classes of the line of a curve."""
    return f"{curve.style} stroke dashed" if curve.dashed else f"{curve.style} stroke"


def _bar(axes: Axes, left: float, share: float, style: str) -> None:
    """A bar of a histogram, one bin wide, with a gap to the next one."""
    x = axes.x(left)
    width = axes.x(left + 0.1) - x
    y = axes.y(share)
    axes.drawing.rectangle((x + 0.6, y), width - 1.2, axes.y.start - y, f"{style} fill soft")


def _curve(axes: Axes, curve: Curve, style: str) -> None:
    axes.drawing.path([axes.point(x, y) for x, y in curve.points], style)
    for x, y in curve.published:
        axes.drawing.marker(axes.point(x, y), "diamond", f"{curve.style} hollow")


def _category_line(axes: Axes, line: Line, shift: float) -> None:
    """One line over categories: its intervals, the line, and markers on top."""
    style = line.style
    for index, pair in enumerate(line.intervals):
        if pair is not None:
            axes.drawing.line(axes.point(index + shift, pair[0]), axes.point(index + shift, pair[1]), f"{style} stroke")

    points = [axes.point(index + shift, value) for index, value in enumerate(line.values) if value is not None]
    axes.drawing.path(points, f"{style} stroke" + (" dashed" if line.published else ""))
    for point in points:
        axes.drawing.marker(point, line.shape, f"{style} {'hollow' if line.published else 'fill'}")


def _interval(axes: Axes, index: int, row: Interval) -> None:
    """One row of a chart of intervals."""
    y = axes.y(index)
    axes.drawing.text((axes.x.start - 10, y + 4), shortened(row.label, LABEL_CHARACTERS), "end", "label")
    if row.band is not None:
        low, high = row.band
        axes.drawing.rectangle((axes.x(low), y - 9), axes.x(high) - axes.x(low), 18, "band")
    if row.low is not None and row.high is not None:
        axes.drawing.line((axes.x(row.low), y), (axes.x(row.high), y), f"{row.style} stroke")
        for end in (row.low, row.high):
            axes.drawing.line((axes.x(end), y - 4), (axes.x(end), y + 4), f"{row.style} stroke")
    if row.value is not None:
        axes.drawing.marker((axes.x(row.value), y), row.shape, f"{row.style} {'hollow' if row.hollow else 'fill'}")
