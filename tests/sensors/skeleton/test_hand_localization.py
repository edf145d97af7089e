"""Hands by their own surface: depth pictures of two balls before a wall of a trunk."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton import hand_localization, segmentation
from sjasim.sensors.skeleton.person_tracking import HAND_JOINTS
from sjasim.sensors.skeleton.segmentation import Foreground

PINHOLE, HEIGHT_M = Intrinsics.from_field_of_view(256, math.radians(70.6), math.radians(60.0)), 0.91
LEFT, RIGHT = HAND_JOINTS[1]
TRUNK_M, BALL_M = 3.0, 0.045
FISTS = np.array([[0.10, 1.2, 2.6], [-0.10, 1.2, 2.6]])


def picture(fists: np.ndarray) -> Foreground:
    """Balls before a trunk of half a metre's width, seen with nothing around it."""
    v, u = np.mgrid[: PINHOLE.height, : PINHOLE.width]
    x, y = ((PINHOLE.width - 1) / 2 - u) / -PINHOLE.fx, ((PINHOLE.height - 1) / 2 - v) / PINHOLE.fy
    depth = np.where((abs(x * TRUNK_M) < 0.25) & (abs(y * TRUNK_M) < 0.6), TRUNK_M, 0.0)
    for place in fists:
        ball = np.hypot(x * place[2] - place[0], y * place[2] - (place[1] - HEIGHT_M)) < BALL_M
        depth[ball] = place[2] - 0.7 * BALL_M
    scene = Foreground.allocate(PINHOLE)
    segmentation.extract_foreground(np.rint(1000 * depth).astype(np.uint16), PINHOLE, HEIGHT_M, scene)
    scene.owner[:] = 0
    return scene


def settled(fists: np.ndarray, prior: np.ndarray, found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The hands' places and whether they are seen, of one person without a vote for a hand."""
    scene, seen = picture(fists), np.zeros((1, 25), dtype=bool)
    joints, before = np.full((1, 25, 3), np.nan), np.full((1, 25, 3), np.nan)
    joints[0, [LEFT, RIGHT]], before[0, [LEFT, RIGHT]] = found, prior
    lens = hand_localization.image_projection(PINHOLE, HEIGHT_M)
    hand_localization.localize_hands(scene, lens, np.array([TRUNK_M]), np.ones(1), before, joints, seen)
    return joints[0, [LEFT, RIGHT]], seen[0, [LEFT, RIGHT]]


def test_the_surface_of_a_ball_is_its_disc():
    scene = picture(FISTS)
    lens = hand_localization.image_projection(PINHOLE, HEIGHT_M)
    assert hand_localization.visible_surface_m2(scene.image, lens, FISTS[0], 0.06) == pytest.approx(
        math.pi * BALL_M**2, rel=0.2
    )
    assert hand_localization.visible_surface_m2(scene.image, lens, FISTS[0] + [0.3, 0.0, 0.0], 0.06) == 0.0
    assert hand_localization.visible_surface_m2(scene.image, lens, np.array([9.0, 1.0, 2.0]), 0.06) == 0.0
    assert hand_localization.visible_surface_m2(scene.image, lens, np.full(3, np.nan), 0.06) == 0.0


def test_a_hand_without_votes_is_seen_where_its_surface_is_and_only_there():
    far = np.array([[0.30, 1.2, 2.6], [-0.30, 1.2, 2.6]])
    _, seen = settled(far, far, far)
    assert seen.tolist() == [True, True]
    _, seen = settled(far[:1], far, far)
    assert seen.tolist() == [True, False]
    leapt = far + np.array([[0.3, 0.0, 0.0], [0.0, 0.0, 0.0]])
    _, seen = settled(far, leapt, far)
    assert seen.tolist() == [False, True]


def test_surface_of_the_trunk_shows_no_hand():
    chest = np.array([[0.1, 1.2, TRUNK_M], [-0.1, 1.2, TRUNK_M]])
    assert not settled(chest, chest, chest)[1].any()


def test_hands_that_come_together_are_told_apart_by_their_points():
    close = FISTS * [0.5, 1.0, 1.0]
    found, seen = settled(close, FISTS * [0.8, 1.0, 1.0], np.zeros((2, 3)) + close.mean(axis=0))
    assert found == pytest.approx(close, abs=0.02)
    assert seen.all()


def test_of_a_hand_that_is_hidden_nothing_is_made_up():
    votes = np.zeros((2, 3)) + FISTS[0]
    assert settled(FISTS[:1], FISTS, votes)[0] == pytest.approx(votes)
