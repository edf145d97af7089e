"""Hidden hands are behind something: a depth picture of a screen with nothing, or a wall, beside it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton import free_space, hand_localization, posture_prior, segmentation
from sjasim.sensors.skeleton.segmentation import Foreground
from sjasim.sensors.skeleton.trained_model import default_model, runtime_model

MODEL = runtime_model(default_model())
PINHOLE, HEIGHT_M = Intrinsics.from_field_of_view(256, math.radians(70.6), math.radians(60.0)), 0.91
LENS = hand_localization.image_projection(PINHOLE, HEIGHT_M)
SCREEN_M, PLACE = 2.0, np.array([0.0, 3.0])


def image(beside_mm: int) -> np.ndarray:
    """A screen on the side of positive x, and something or nothing beside it."""
    depth = np.full((PINHOLE.height, PINHOLE.width), beside_mm, np.uint16)
    depth[:, PINHOLE.width // 2 :] = round(1000 * SCREEN_M)
    scene = Foreground.allocate(PINHOLE)
    segmentation.extract_foreground(depth, PINHOLE, HEIGHT_M, scene)
    return scene.image


@pytest.mark.parametrize("beside_mm", [0, 4200])
def test_a_hand_behind_the_screen_may_be_there_and_one_beside_it_may_not(beside_mm: int):
    picture = image(beside_mm)
    assert not free_space.is_free_space(picture, LENS, 0.3, 1.0, 3.0, 0.04)
    assert free_space.is_free_space(picture, LENS, -0.3, 1.0, 3.0, 0.04)
    assert free_space.is_free_space(picture, LENS, 0.3, 1.0, 1.5, 0.04)
    assert not free_space.is_free_space(picture, LENS, -9.0, 1.0, 3.0, 0.04)


def test_postures_whose_hand_would_hang_in_the_open_are_not_believed():
    picture, yaw_rad = image(0), 0.3
    counts = free_space.posture_likelihood(picture, LENS, PLACE, yaw_rad, 1.0, MODEL.memory, MODEL.mean)
    for n in range(0, len(MODEL.memory), 20):
        points = posture_prior.sensor_from_body(MODEL.memory[n].reshape(25, 3) + MODEL.mean, yaw_rad) + np.array(
            [PLACE[0], 0.0, PLACE[1]]
        )
        for side, (x, y, z) in enumerate(points[hand_localization.PALMS]):
            open_air = free_space.is_free_space(picture, LENS, x, y, z, free_space.HALF_HAND_M)
            assert counts[n, side] == (free_space.FREE_SPACE_WEIGHT if open_air else 1.0)
    assert set(np.unique(counts)) == {free_space.FREE_SPACE_WEIGHT, 1.0}
