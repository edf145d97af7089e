"""Localization of hands by their surface, in depth images of two balls in front of a flat trunk."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton import hand_localization
from sjasim.sensors.skeleton.foreground import Foreground, extract_foreground
from sjasim.sensors.skeleton.joint_groups import PALMS

INTRINSICS = Intrinsics.from_field_of_view(256, math.radians(70.6), math.radians(60.0))
HEIGHT_M = 0.91
PROJECTION = hand_localization.image_projection(INTRINSICS, HEIGHT_M)
TRUNK_M = 3.0
BALL_M = 0.045
HANDS = np.array([[0.10, 1.2, 2.6], [-0.10, 1.2, 2.6]])


def foreground_of(hands: np.ndarray) -> Foreground:
    """Return the points of balls at the hands, in front of a trunk half a metre wide, with nothing around it."""
    v, u = np.mgrid[: INTRINSICS.height, : INTRINSICS.width]
    x = ((INTRINSICS.width - 1) / 2 - u) / -INTRINSICS.fx
    y = ((INTRINSICS.height - 1) / 2 - v) / INTRINSICS.fy
    depth = np.where((abs(x * TRUNK_M) < 0.25) & (abs(y * TRUNK_M) < 0.6), TRUNK_M, 0.0)
    for hand in hands:
        ball = np.hypot(x * hand[2] - hand[0], y * hand[2] - (hand[1] - HEIGHT_M)) < BALL_M
        depth[ball] = hand[2] - 0.7 * BALL_M

    foreground = Foreground.allocate(INTRINSICS)
    extract_foreground(np.rint(1000 * depth).astype(np.uint16), INTRINSICS, HEIGHT_M, foreground)
    foreground.owner[:] = 0
    return foreground


def localized(hands: np.ndarray, prior: np.ndarray, voted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the hands' positions, and whether they are seen, for one person without enough votes for a hand."""
    foreground = foreground_of(hands)
    seen = np.zeros((1, 25), dtype=bool)
    joints = np.full((1, 25, 3), np.nan)
    before = np.full((1, 25, 3), np.nan)
    joints[0, PALMS] = voted
    before[0, PALMS] = prior
    hand_localization.localize_hands(
        foreground, PROJECTION, np.array([TRUNK_M]), np.ones(1), before, joints, seen
    )  # fmt: skip
    return joints[0, PALMS], seen[0, PALMS]


def test_the_visible_surface_of_a_ball_is_its_disc():
    image = foreground_of(HANDS).image
    disc_m2 = math.pi * BALL_M**2
    assert hand_localization.visible_surface_m2(image, PROJECTION, HANDS[0], 0.06) == pytest.approx(disc_m2, rel=0.2)
    for elsewhere in (HANDS[0] + [0.3, 0.0, 0.0], np.array([9.0, 1.0, 2.0]), np.full(3, np.nan)):
        assert hand_localization.visible_surface_m2(image, PROJECTION, elsewhere, 0.06) == 0.0


def test_a_hand_without_votes_is_seen_where_its_surface_is_and_only_there():
    apart = np.array([[0.30, 1.2, 2.6], [-0.30, 1.2, 2.6]])
    _, seen = localized(apart, apart, apart)
    assert seen.tolist() == [True, True]

    _, seen = localized(apart[:1], apart, apart)
    assert seen.tolist() == [True, False]

    far_from_prediction = apart + np.array([[0.3, 0.0, 0.0], [0.0, 0.0, 0.0]])
    _, seen = localized(apart, far_from_prediction, apart)
    assert seen.tolist() == [False, True]


def test_the_surface_of_the_trunk_does_not_count_as_a_hand():
    on_chest = np.array([[0.1, 1.2, TRUNK_M], [-0.1, 1.2, TRUNK_M]])
    assert not localized(on_chest, on_chest, on_chest)[1].any()


def test_hands_that_approach_are_separated_by_their_points():
    close = HANDS * [0.5, 1.0, 1.0]
    voted = np.zeros((2, 3)) + close.mean(axis=0)
    joints, seen = localized(close, HANDS * [0.8, 1.0, 1.0], voted)
    assert joints == pytest.approx(close, abs=0.02)
    assert seen.all()


def test_hands_are_not_moved_if_one_of_them_is_hidden():
    voted = np.zeros((2, 3)) + HANDS[0]
    assert localized(HANDS[:1], HANDS, voted)[0] == pytest.approx(voted)
