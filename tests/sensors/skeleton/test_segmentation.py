"""Segmentation: points are assigned to near persons, and new persons and low objects are found."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.sensors.skeleton import segmentation
from sjasim.sensors.skeleton.foreground import LOW_OBJECT, UNASSIGNED

from .panels import INTRINSICS, NO_OBJECT, assign, foreground_of


def test_points_are_assigned_to_the_person_near_them():
    foreground = foreground_of((-0.5, 3.0, 0.4, 1.7), (0.5, 2.5, 0.4, 1.7))
    owner = assign(foreground, [(-0.5, 3.1), (0.5, 2.6)])
    left = foreground.point[: foreground.count, 0] < 0
    assert set(owner[left]) == {0}
    assert set(owner[~left]) == {1}


def test_two_persons_who_pass_each_other_keep_their_points():
    foreground = foreground_of((0.0, 3.2, 0.4, 1.8), (0.3, 2.7, 0.4, 1.6))
    owner = assign(foreground, [(0.0, 3.3), (0.3, 2.8)])
    far = foreground.point[: foreground.count, 2] > 3.0
    assert (owner[far] == 0).all()
    assert (owner[~far] == 1).mean() > 0.98


def test_a_new_person_beside_a_known_one_is_found():
    foreground = foreground_of((0.0, 2.5, 0.4, 1.7), (0.5, 3.1, 0.4, 1.7))
    owner = assign(foreground, [(0.0, 2.6)])
    other = foreground.point[: foreground.count, 2] > 3.0
    assert (owner[other] == UNASSIGNED).mean() > 0.9

    places = segmentation.find_new_persons(foreground, INTRINSICS, 0.04, 0.5)
    assert len(places) == 1
    assert places[0] == pytest.approx((0.5, 3.1), abs=0.1)


def test_a_robot_is_no_person_and_keeps_its_points_beside_a_leg():
    foreground = foreground_of((1.0, 3.0, 0.35, 0.42))
    assert (assign(foreground, []) == UNASSIGNED).all()
    assert segmentation.find_new_persons(foreground, INTRINSICS, 0.04, 0.5) == []

    low = segmentation.locate_low_object(foreground, NO_OBJECT, INTRINSICS, 0.01)
    assert low == pytest.approx([1.0, 3.0], abs=0.05)
    owner = assign(foreground, [(0.55, 3.0)], low)
    assert (owner == LOW_OBJECT).mean() > 0.8


def test_an_empty_scene_has_no_person_and_no_object():
    foreground = foreground_of()
    assert segmentation.find_new_persons(foreground, INTRINSICS, 0.04, 0.5) == []
    assert np.isnan(segmentation.locate_low_object(foreground, NO_OBJECT, INTRINSICS, 0.01)).all()
