"""Position and size of persons, measured on panels of known size."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.sensors.skeleton.person_measures import measure_persons

from .panels import PER_PIXEL, assign, foreground_of


def test_position_height_and_width_are_measured():
    foreground = foreground_of((0.2, 3.0, 0.4, 1.7))
    assign(foreground, [(0.1, 3.1)])
    count, x, z, crown, width = measure_persons(foreground, np.array([[0.1, 3.1]]), np.ones(1), PER_PIXEL)[0]
    assert count == foreground.count
    assert (x, z) == pytest.approx((0.2, 3.0), abs=0.03)
    assert crown == pytest.approx(1.7, abs=0.04)
    assert width == pytest.approx(0.8 * 0.4, abs=0.04)


def test_the_crown_does_not_depend_on_how_much_of_the_body_is_visible():
    crowns = []
    for width, height in ((0.2, 1.6), (0.7, 1.6)):
        foreground = foreground_of((0.0, 3.0, width, height), (0.0, 2.99, 0.16, 1.7))
        assign(foreground, [(0.0, 3.0)])
        crowns.append(measure_persons(foreground, np.array([[0.0, 3.0]]), np.ones(1), PER_PIXEL)[0, 3])
    assert crowns[0] == pytest.approx(crowns[1], abs=0.005)


def test_a_person_without_a_visible_trunk_is_measured_by_all_points():
    foreground = foreground_of((0.0, 3.0, 0.3, 0.6))
    assign(foreground, [(0.0, 3.0)])
    count, x, z, _, _ = measure_persons(foreground, np.array([[0.0, 3.0]]), np.ones(1), PER_PIXEL)[0]
    assert count > 0
    assert (x, z) == pytest.approx((0.0, 3.0), abs=0.03)


def test_a_person_without_points_has_no_measures():
    foreground = foreground_of()
    assert len(assign(foreground, [(0.0, 3.0)])) == 0
    assert not measure_persons(foreground, np.array([[0.0, 3.0]]), np.ones(1), PER_PIXEL).any()
