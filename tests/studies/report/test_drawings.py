"""Scales, ticks and shapes of drawings."""

import itertools
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sjasim.studies.report.axes import Scale, axis_top, padded, tick_texts, ticks
from sjasim.studies.report.charts import Bars, Curve, Interval, Line, by_category, histogram, intervals
from sjasim.studies.report.svg import MARKERS, Drawing, swatch
from sjasim.studies.report.text import counted, interval, listed, number, p_value, percent, shortened, signed

NUMBERS = st.floats(-1e6, 1e6)


@given(NUMBERS, st.floats(1e-3, 1e6))
def test_ticks_are_round_inside_and_evenly_spaced(low, width):
    values = ticks(low, low + width)
    assert 2 <= len(values) <= 7
    assert all(low - 1e-6 * width <= value <= low + width * (1 + 1e-6) for value in values)
    gaps = {round(b - a, 6) for a, b in itertools.pairwise(values)}
    assert max(gaps) == pytest.approx(min(gaps), rel=1e-3)


@given(st.floats(0.01, 1e5))
def test_an_axis_ends_just_above_what_it_holds(highest):
    top = axis_top(highest)
    assert highest <= top * (1 + 1e-6)
    assert top <= 1.5 * highest
    assert ticks(0.0, top)[-1] == pytest.approx(top, rel=1e-6)


def test_ticks_have_as_many_decimals_as_one_of_them_needs():
    assert tick_texts([0.0, 0.25, 0.5]) == ["0.00", "0.25", "0.50"]
    assert tick_texts([-1.0, 0.0, 1.0]) == ["−1", "0", "1"]


def test_a_scale_maps_its_ends_and_clips_what_lies_outside():
    scale = Scale(0.0, 2.0, 100.0, 300.0)
    assert (scale(0.0), scale(1.0), scale(2.0)) == (100.0, 200.0, 300.0)
    assert (scale.clipped(-5.0), scale.clipped(9.0)) == (100.0, 300.0)


def test_a_range_without_width_gets_one():
    low, high = padded([0.0, 0.0])
    assert low < 0.0 < high


def test_a_drawing_has_a_name_a_description_and_escaped_text():
    drawing = Drawing(100, 50, "A < B & C", "what <it> shows")
    drawing.text((1, 2), "</svg><script>")
    for marker in MARKERS:
        drawing.marker((10.0, 20.0), marker, "c0 fill")
    root = ElementTree.fromstring(str(drawing.markup()))
    assert root.find("title").text == "A < B & C"
    assert root.attrib["aria-labelledby"] == f"{root.find('title').attrib['id']} {root.find('desc').attrib['id']}"
    assert root.find("text").text == "</svg><script>"
    assert len(root) == 3 + len(MARKERS)
    assert all(ElementTree.fromstring(str(swatch([(name, "ink")]))) is not None for name in ("line", "block", "circle"))


def test_bars_have_the_heights_of_their_shares_and_the_curve_passes_through_its_points():
    curve = Curve("a", "c0", [(0.0, 0.0), (0.1, 60.0), (0.2, 90.0)], published=[(0.1, 50.0)])
    root = ElementTree.fromstring(str(histogram("t", "d", Bars([60.0, 30.0], 10.0, 100.0), curve)))
    heights = [float(bar.attrib["height"]) for bar in root.iter("rect")]
    assert heights == pytest.approx([60 * 2.18, 30 * 2.18, 10 * 2.18], abs=0.02)
    (line,) = [
        item for item in root.iter("path") if "stroke" in item.attrib["class"] and "hollow" not in item.attrib["class"]
    ]
    y = [float(pair.split(",")[1]) for pair in line.attrib["d"][1:].split("L")]
    assert y == pytest.approx([248.0, 248 - 60 * 2.18, 248 - 90 * 2.18], abs=0.02)
    # The published point stands apart from the curve, below it.
    (diamond,) = [item for item in root.iter("path") if "hollow" in item.attrib["class"]]
    assert float(diamond.attrib["transform"][:-1].split(",")[1]) == pytest.approx(248 - 50 * 2.18, abs=0.02)


def test_charts_without_values_are_empty_and_not_wrong():
    assert "svg" in intervals("t", "d", "x", [Interval("a", "c0", None)])
    assert "svg" in by_category("t", "d", "y", ("iteration", ["1", "2"]), [Line("a", "c0", [None, None])])


def test_a_value_lies_between_the_ends_of_its_interval():
    root = ElementTree.fromstring(str(intervals("t", "d", "x", [Interval("a", "c0", 0.5, 0.25, 1.0)])))
    (circle,) = root.iter("circle")
    ends = [line.attrib for line in root.iter("line") if line.attrib["class"] == "c0 stroke"]
    across = next(end for end in ends if end["y1"] == end["y2"])
    low, high = float(across["x1"]), float(across["x2"])
    assert (float(circle.attrib["cx"]) - low) / (high - low) == pytest.approx(1 / 3, abs=0.01)


def test_numbers_are_written_as_readers_expect():
    assert number(-0.0001, 2) == "0.00"
    assert (number(None), number(-0.5, 1), signed(0.25, 2), percent(0.5)) == ("–", "−0.5", "+0.25", "50.0 %")
    assert (p_value(0.0004), p_value(0.031), p_value(0.4), p_value(None)) == (
        "p < 0.001",
        "p = 0.031",
        "p = 0.40",
        "p unknown",
    )
    assert interval(0.1, None) == "–"
    assert (listed(["a"]), listed(["a", "b", "c"])) == ("a", "a, b and c")
    assert (counted(1, "group"), counted(2, "group")) == ("1 group", "2 groups")


@given(st.text(min_size=1, max_size=80), st.integers(4, 40))
def test_shortened_names_fit_and_keep_their_ends(name, characters):
    short = shortened(name, characters)
    assert len(short) <= characters
    assert (short[0], short[-1]) == (name[0], name[-1])
