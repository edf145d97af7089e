"""What a depth image says of limbs: there, hidden, or gone."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.config import SensorConfig
from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton.joint_visibility import LIMBS, OCCLUDED, VISIBLE, joint_visibility
from sjasim.sensors.skeleton.segmentation import MAX_DEPTH_MM

INTRINSICS = Intrinsics.from_field_of_view(256, SensorConfig().horizontal_fov_rad, SensorConfig().vertical_fov_rad)
HEIGHT_M, AWAY_M = 1.1, 3.0
HAND = JOINT_INDEX["HandLeft"]


def verdict(surfaces: list[tuple[float, float]], hand_m: tuple[float, float, float] = (0.0, HEIGHT_M, AWAY_M)) -> int:
    """What is said of a hand before surfaces, each a strip from an x to the image's edge at a depth [m]."""
    image = np.full((INTRINSICS.height + 2, INTRINSICS.width + 2), MAX_DEPTH_MM, np.int16)
    for from_x_m, depth_m in surfaces:
        column = round((INTRINSICS.width - 1) / 2 + INTRINSICS.fx * from_x_m / depth_m) + 1
        image[:, max(column, 0) :] = 1000 * depth_m
    joints = np.full((1, 25, 3), np.nan)
    joints[0, HAND] = hand_m
    said = joint_visibility(image, INTRINSICS, HEIGHT_M, joints, np.ones(1))
    assert (np.delete(said[0], HAND) == 0).all()
    return int(said[0, HAND])


def test_flesh_just_before_a_joint_shows_it():
    assert verdict([(-1.0, AWAY_M - 0.05)]) == VISIBLE


def test_a_little_of_it_beside_the_joint_is_enough():
    assert verdict([(0.03, AWAY_M - 0.05)]) == VISIBLE


def test_somebody_before_a_joint_hides_it():
    assert verdict([(-1.0, AWAY_M - 0.5)]) == OCCLUDED


def test_what_covers_the_joint_itself_hides_it_whatever_lies_beside():
    assert verdict([(-1.0, AWAY_M - 0.5), (0.04, AWAY_M - 0.05)]) == OCCLUDED


def test_a_limb_that_the_sensor_looks_through_is_not_there():
    assert verdict([]) == OCCLUDED
    assert verdict([(-1.0, AWAY_M + 0.3)]) == OCCLUDED


@pytest.mark.parametrize("hand_m", [(9.0, HEIGHT_M, AWAY_M), (0.0, HEIGHT_M, -1.0)])
def test_nothing_is_shown_outside_of_the_picture(hand_m: tuple[float, float, float]):
    assert verdict([(-1.0, AWAY_M)], hand_m) != VISIBLE


@pytest.mark.parametrize(
    ("before_m", "said"), [(0.1, 0), (0.3, 0), (0.8, OCCLUDED)], ids=["flesh", "own arm", "somebody"]
)
def test_only_somebody_else_hides_a_joint_of_the_trunk(before_m: float, said: int):
    image = np.full((INTRINSICS.height + 2, INTRINSICS.width + 2), round(1000 * (AWAY_M - before_m)), np.int16)
    joints = np.full((1, 25, 3), np.nan)
    joints[0, JOINT_INDEX["SpineBase"]] = 0.1, HEIGHT_M, AWAY_M
    assert joint_visibility(image, INTRINSICS, HEIGHT_M, joints, np.ones(1))[0, JOINT_INDEX["SpineBase"]] == said


def test_limbs_are_arms_and_legs():
    assert LIMBS.sum() == 16
    assert not LIMBS[[JOINT_INDEX[name] for name in ("Head", "SpineBase", "ShoulderLeft", "HipRight")]].any()
