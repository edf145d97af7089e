"""Axes of a drawing: scales from values to pixels, ticks at round values, and a grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from .svg import Drawing, Point


@dataclass(frozen=True, slots=True)
class Scale:
    """Linear map from values to pixels.

    Attributes:
        low: value at ``start``.
        high: value at ``end``.
        start: pixel of the low end.
        end: pixel of the high end; below ``start`` for an axis that points up.
    """

    low: float
    high: float
    start: float
    end: float

    def __call__(self, value: float) -> float:
        """The pixel of a value."""
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)

    def clipped(self, value: float) -> float:
        """The pixel of a value, or that of the nearer end for a value outside."""
        return self(min(max(value, self.low), self.high))


@dataclass(frozen=True, slots=True)
class Margins:
    """Space around the area of a plot [px]."""

    left: float = 46.0
    right: float = 14.0
    top: float = 30.0
    bottom: float = 42.0


class Axes:
    """The area of a plot inside a drawing, with a horizontal and a vertical axis.

    Args:
        drawing: the drawing.
        x: (low, high) values of the horizontal axis.
        y: (low, high) values of the vertical axis.
        margins: space around the area.
    """

    def __init__(
        self, drawing: Drawing, x: tuple[float, float], y: tuple[float, float], margins: Margins | None = None
    ) -> None:
        own = margins or Margins()
        self.drawing = drawing
        self.x = Scale(*x, own.left, drawing.width - own.right)
        self.y = Scale(*y, drawing.height - own.bottom, own.top)

    def point(self, x: float, y: float) -> Point:
        """The position of two values in the drawing."""
        return self.x(x), self.y(y)

    def bottom(self, label: str, values: Sequence[float], texts: Sequence[str] | None = None) -> None:
        """Draw the horizontal axis below the area.

        Args:
            label: what is drawn, with its unit.
            values: where the ticks are.
            texts: their texts; by default the values.
        """
        draw = self.drawing
        draw.line((self.x.start, self.y.start), (self.x.end, self.y.start), "axis")
        for value, text in zip(values, texts or tick_texts(values), strict=True):
            draw.line((self.x(value), self.y.start), (self.x(value), self.y.start + 4), "axis")
            draw.text((self.x(value), self.y.start + 17), text, "middle")
        draw.text(((self.x.start + self.x.end) / 2, self.y.start + 35), label, "middle", "label")

    def left(self, label: str, values: Sequence[float]) -> None:
        """Draw the vertical axis: a grid with its values at the left, and the label above it."""
        for value, text in zip(values, tick_texts(values), strict=True):
            self.drawing.line((self.x.start, self.y(value)), (self.x.end, self.y(value)), "grid")
            self.drawing.text((self.x.start - 7, self.y(value) + 4), text, "end")
        # Text that stands upright needs no turned head.
        self.drawing.text((4, self.y.end - 14), label, "start", "label")

    def guide(self, x: float) -> None:
        """Draw a thin vertical line over the height of the area."""
        self.drawing.line((self.x(x), self.y.start), (self.x(x), self.y.end), "grid")


def ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Round values from ``low`` to ``high``, at most about ``count`` of them: multiples of 1, 2 or 5 times 10^n."""
    raw = (high - low) / max(1, count)
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= raw * 0.999)
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    return [round(index * step, 10) for index in range(first, last + 1)]


def axis_top(highest: float, count: int = 5) -> float:
    """End of an axis from 0 that holds a value: the next round value above it.

    Args:
        highest: largest value that is drawn, above 0.
        count: about how many ticks the axis has.
    """
    marks = ticks(0.0, highest, count)
    step = marks[1] - marks[0]
    return step * math.ceil(highest / step - 1e-9)


def tick_texts(values: Sequence[float]) -> list[str]:
    """The values as texts, all with as many decimals as one of them needs."""
    decimals = max((len(f"{value:.3f}".rstrip("0").partition(".")[2]) for value in values), default=0)
    return [f"{value:.{decimals}f}".replace("-", "−") for value in values]


def padded(values: Sequence[float], share: float = 0.06) -> tuple[float, float]:
    """Range of some values with space at both ends; a range of no width gets one.

    Args:
        values: finite values, at least one.
        share: space at each end as a share of the range.
    """
    low = min(values)
    high = max(values)
    space = share * (high - low) or 0.1 * abs(high) or 1.0
    return low - space, high + space
