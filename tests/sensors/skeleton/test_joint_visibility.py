"""Verdicts on joints by the surface that a depth image shows around them."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.config import SensorConfig
from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton.foreground import MAX_DEPTH_MM
from sjasim.sensors.skeleton.joint_groups import IS_LIMB, LIMBS
from sjasim.sensors.skeleton.joint_visibility import OCCLUDED, UNDECIDED, VISIBLE, joint_visibility

INTRINSICS = Intrinsics.from_field_of_view(256, SensorConfig().horizontal_fov_rad, SensorConfig().vertical_fov_rad)
HEIGHT_M = 1.1
HAND_DEPTH_M = 3.0
HAND = JOINT_INDEX["HandLeft"]
BASE = JOINT_INDEX["SpineBase"]


def verdict(
    surfaces: list[tuple[float, float]], hand_m: tuple[float, float, float] = (0.0, HEIGHT_M, HAND_DEPTH_M)
) -> int:
    """Return the verdict on a hand; each surface reaches from an x to the image's border at a depth [m]."""
    image = np.full((INTRINSICS.height + 2, INTRINSICS.width + 2), MAX_DEPTH_MM, np.int16)
    for from_x_m, depth_m in surfaces:
        column = round((INTRINSICS.width - 1) / 2 + INTRINSICS.fx * from_x_m / depth_m) + 1
        image[:, max(column, 0) :] = 1000 * depth_m

    joints = np.full((1, 25, 3), np.nan)
    joints[0, HAND] = hand_m
    verdicts = joint_visibility(image, INTRINSICS, HEIGHT_M, joints, np.ones(1))[0]
    assert (np.delete(verdicts, HAND) == UNDECIDED).all()
    return int(verdicts[HAND])


def test_a_joint_just_behind_a_surface_is_visible():
    assert verdict([(-1.0, HAND_DEPTH_M - 0.05)]) == VISIBLE


def test_a_little_surface_beside_the_joint_suffices():
    assert verdict([(0.03, HAND_DEPTH_M - 0.05)]) == VISIBLE


def test_a_surface_far_in_front_of_a_joint_occludes_it():
    assert verdict([(-1.0, HAND_DEPTH_M - 0.5)]) == OCCLUDED


def test_a_surface_that_covers_the_joint_occludes_it_whatever_lies_beside():
    assert verdict([(-1.0, HAND_DEPTH_M - 0.5), (0.04, HAND_DEPTH_M - 0.05)]) == OCCLUDED


@pytest.mark.parametrize("surfaces", [[], [(-1.0, HAND_DEPTH_M + 0.3)]], ids=["nothing", "a farther surface"])
def test_a_limb_in_free_space_is_not_there(surfaces: list[tuple[float, float]]):
    assert verdict(surfaces) == OCCLUDED


@pytest.mark.parametrize("hand_m", [(9.0, HEIGHT_M, HAND_DEPTH_M), (0.0, HEIGHT_M, -1.0)])
def test_no_joint_outside_of_the_image_is_visible(hand_m: tuple[float, float, float]):
    assert verdict([(-1.0, HAND_DEPTH_M)], hand_m) != VISIBLE


@pytest.mark.parametrize(
    ("before_m", "expected"),
    [(0.1, UNDECIDED), (0.3, UNDECIDED), (0.8, OCCLUDED)],
    ids=["own trunk", "own arm", "somebody else"],
)
def test_only_somebody_else_occludes_a_joint_of_the_trunk(before_m: float, expected: int):
    depth_mm = round(1000 * (HAND_DEPTH_M - before_m))
    image = np.full((INTRINSICS.height + 2, INTRINSICS.width + 2), depth_mm, np.int16)
    joints = np.full((1, 25, 3), np.nan)
    joints[0, BASE] = 0.1, HEIGHT_M, HAND_DEPTH_M
    assert joint_visibility(image, INTRINSICS, HEIGHT_M, joints, np.ones(1))[0, BASE] == expected


def test_limbs_are_arms_and_legs():
    assert len(LIMBS) == 16
    assert not IS_LIMB[[JOINT_INDEX[name] for name in ("Head", "SpineBase", "ShoulderLeft", "HipRight")]].any()
