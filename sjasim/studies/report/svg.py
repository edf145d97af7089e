"""Drawings in SVG, to be put into a page of HTML.

A shape has a style, which is one or several classes of the page's style sheet, so that a drawing has no colours of its
own and follows the page from light to dark. The class of a series (`series`) sets the colour, and the class of a shape
(``fill``, ``stroke``, ``hollow``) says where it is used.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree

from markupsafe import Markup

Point = tuple[float, float]

SERIES_COUNT = 6
"""Number of colours that the style sheet has for series."""

MARKERS = {
    "circle": "",
    "square": "M-3.5,-3.5h7v7h-7z",
    "diamond": "M0,-5L5,0L0,5L-5,0z",
    "right": "M-3.5,-5L5,0L-3.5,5z",
    "left": "M3.5,-5L-5,0L3.5,5z",
    "bar": "M-1.3,-6h2.6v12h-2.6z",
    "thin bar": "M-0.6,-6h1.2v12h-1.2z",
    "star": "M0,-6.5L1.6,-2.2L6.2,-2L2.6,0.9L3.8,5.3L0,2.8L-3.8,5.3L-2.6,0.9L-6.2,-2L-1.6,-2.2z",
    "cross": "M-4.5,-4.5L4.5,4.5M-4.5,4.5L4.5,-4.5",
}
"""Name -> outline of a marker about its centre, in units of the drawing; a circle is an element of its own."""


def series(index: int) -> str:
    """Class of the series with this index, counted from 0; the colours repeat."""
    return f"c{index % SERIES_COUNT}"


class Drawing:
    """An SVG drawing that is built shape by shape.

    Args:
        width: width in pixels at the drawing's natural size.
        height: height in pixels.
        title: what the drawing shows, in a few words; screen readers read it.
        description: what can be seen in it, with the main figures.
    """

    def __init__(self, width: float, height: float, title: str, description: str) -> None:
        self.width = width
        self.height = height
        # Identifiers are made of the title, so that a page is the same each time it is made.
        name = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")
        self._root = ElementTree.Element(
            "svg",
            {
                "viewBox": f"0 0 {_number(width)} {_number(height)}",
                "role": "img",
                "aria-labelledby": f"{name}-title {name}-description",
                "style": f"max-width:{_number(width)}px",
            },
        )
        self._add("title", {"id": f"{name}-title"}, title)
        self._add("desc", {"id": f"{name}-description"}, description)

    def line(self, start: Point, end: Point, style: str) -> None:
        """Draw a straight line."""
        ends = {"x1": start[0], "y1": start[1], "x2": end[0], "y2": end[1]}
        self._add("line", {"class": style, **_numbers(ends)})

    def rectangle(self, corner: Point, width: float, height: float, style: str) -> None:
        """Draw a rectangle.

        Args:
            corner: upper left corner.
            width: width.
            height: height.
            style: classes.
        """
        sides = {"x": corner[0], "y": corner[1], "width": width, "height": height}
        self._add("rect", {"class": style, **_numbers(sides)})

    def path(self, points: Sequence[Point], style: str) -> None:
        """Draw a line through points; nothing for fewer than two points."""
        if len(points) >= 2:
            outline = "L".join(f"{_number(x)},{_number(y)}" for x, y in points)
            self._add("path", {"class": style, "d": f"M{outline}"})

    def marker(self, centre: Point, shape: str, style: str) -> None:
        """Draw one of `MARKERS`."""
        x, y = map(_number, centre)
        if shape == "circle":
            self._add("circle", {"class": style, "cx": x, "cy": y, "r": "4"})
        else:
            self._add("path", {"class": style, "d": MARKERS[shape], "transform": f"translate({x},{y})"})

    def text(self, position: Point, text: str, anchor: str = "start", style: str = "tick") -> None:
        """Write text.

        Args:
            position: point on the base line.
            text: the text; it is escaped.
            anchor: which part of the text stands at the point: start, middle or end.
            style: classes.
        """
        place = _numbers({"x": position[0], "y": position[1]})
        self._add("text", {"class": style, **place, "text-anchor": anchor}, text)

    def markup(self) -> Markup:
        """The drawing as an element for a page."""
        return Markup(ElementTree.tostring(self._root, encoding="unicode"))

    def _add(self, name: str, attributes: dict[str, str], text: str = "") -> None:
        element = ElementTree.SubElement(self._root, name, attributes)
        element.text = text or None


def swatch(shapes: Sequence[tuple[str, str]]) -> Markup:
    """A small drawing for a legend: markers of some styles, one over the other.

    Args:
        shapes: (marker, style); the marker may also be ``line`` or ``block``.
    """
    root = ElementTree.Element("svg", {"viewBox": "0 0 24 14", "class": "swatch", "aria-hidden": "true"})
    for shape, style in shapes:
        if shape == "line":
            ElementTree.SubElement(root, "line", {"class": style, "x1": "1", "y1": "7", "x2": "23", "y2": "7"})
        elif shape == "block":
            ElementTree.SubElement(root, "rect", {"class": style, "x": "4", "y": "2", "width": "16", "height": "10"})
        elif shape == "circle":
            ElementTree.SubElement(root, "circle", {"class": style, "cx": "12", "cy": "7", "r": "4"})
        else:
            ElementTree.SubElement(root, "path", {"class": style, "d": MARKERS[shape], "transform": "translate(12,7)"})
    return Markup(ElementTree.tostring(root, encoding="unicode"))


def _number(value: float) -> str:
    """A coordinate with at most two decimals."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


def _numbers(values: dict[str, float]) -> dict[str, str]:
    return {name: _number(value) for name, value in values.items()}
