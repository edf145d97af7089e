"""Free space in a depth image of a screen with a wall, or nothing, beside it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton import free_space, hand_localization, posture_prior
from sjasim.sensors.skeleton.foreground import Foreground, extract_foreground
from sjasim.sensors.skeleton.joint_groups import PALMS
from sjasim.sensors.skeleton.trained_model import default_model, runtime_model

MODEL = runtime_model(default_model())
INTRINSICS = Intrinsics.from_field_of_view(256, math.radians(70.6), math.radians(60.0))
HEIGHT_M = 0.91
PROJECTION = hand_localization.image_projection(INTRINSICS, HEIGHT_M)
SCREEN_M = 2.0
POSITION = np.array([0.0, 3.0])


def image_of_screen(beside_mm: int) -> np.ndarray:
    """Return the image of a screen at positive x, with a surface, or nothing (0), beside it."""
    depth = np.full((INTRINSICS.height, INTRINSICS.width), beside_mm, np.uint16)
    depth[:, INTRINSICS.width // 2 :] = round(1000 * SCREEN_M)
    foreground = Foreground.allocate(INTRINSICS)
    extract_foreground(depth, INTRINSICS, HEIGHT_M, foreground)
    return foreground.image


@pytest.mark.parametrize("beside_mm", [0, 4200])
def test_space_is_free_beside_and_in_front_of_the_screen_but_not_behind_it(beside_mm: int):
    image = image_of_screen(beside_mm)
    assert not free_space.is_free_space(image, PROJECTION, 0.3, 1.0, 3.0, 0.04)
    assert free_space.is_free_space(image, PROJECTION, -0.3, 1.0, 3.0, 0.04)
    assert free_space.is_free_space(image, PROJECTION, 0.3, 1.0, 1.5, 0.04)

    outside_of_the_image_x_m = -9.0
    assert not free_space.is_free_space(image, PROJECTION, outside_of_the_image_x_m, 1.0, 3.0, 0.04)


def test_a_posture_with_a_hand_in_free_space_gets_a_low_weight():
    image = image_of_screen(0)
    yaw_rad = 0.3
    weights = free_space.posture_likelihood(image, PROJECTION, POSITION, yaw_rad, 1.0, MODEL.memory, MODEL.mean)
    assert set(np.unique(weights)) == {free_space.FREE_SPACE_WEIGHT, 1.0}

    for n in range(0, len(MODEL.memory), 20):
        body = MODEL.memory[n].reshape(25, 3) + MODEL.mean
        points = posture_prior.sensor_from_body(body, yaw_rad) + np.array([POSITION[0], 0.0, POSITION[1]])
        for side, (x, y, z) in enumerate(points[PALMS]):
            free = free_space.is_free_space(image, PROJECTION, x, y, z, free_space.HALF_HAND_M)
            assert weights[n, side] == (free_space.FREE_SPACE_WEIGHT if free else 1.0)
