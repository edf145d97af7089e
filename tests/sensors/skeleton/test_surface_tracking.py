"""The trunk's surface as a witness of its motion along the view."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton import surface_tracking
from sjasim.sensors.skeleton.segmentation import Foreground
from sjasim.sensors.skeleton.surface_tracking import (
    CELLS,
    PATCH_JOINTS,
    correct_depth_from_surface,
    initial_patches,
    measure_patches,
)

BASE = PATCH_JOINTS[0]
AT_ONCE = np.array([1.0, 0.02, 1.0])
DT_S, DEPTH_M, FLESH_M = 1 / 30, 3.0, 0.12
SIDE = np.linspace(-0.119, 0.119, 2 * CELLS)


def surface(depth_m: float, hidden_below: float = -1.0) -> Foreground:
    """A round belly before SpineBase at x = 0 and 1 m above the floor, as points of person 0; what is left of
    ``hidden_below`` is somebody else's."""
    x, y = (grid.ravel() for grid in np.meshgrid(SIDE, SIDE))
    scene = Foreground.allocate(Intrinsics.from_field_of_view(256, 1.2, 1.0))
    scene.count = len(x)
    scene.point[: len(x)] = np.stack([x, 1.0 + y, depth_m - FLESH_M + 2.0 * x**2], axis=1)
    scene.owner[: len(x)] = np.where(x < hidden_below, -1, 0)
    return scene


def joints(depth_m: float) -> np.ndarray:
    out = np.full((25, 3), np.nan)
    out[BASE] = 0.0, 1.0, depth_m
    return out


def follow(
    known: np.ndarray, scene: Foreground, predicted_m: float, voted_m: float, share: np.ndarray = AT_ONCE
) -> float:  # fmt: skip
    """SpineBase's depth after a frame in which votes alone would have put it at ``voted_m``."""
    found = joints(voted_m)
    cells = measure_patches(scene, joints(predicted_m)[None], np.ones(1))[0]
    correct_depth_from_surface(cells, known, joints(predicted_m), joints(voted_m), 30.0, share, DT_S, found)
    return float(found[BASE, 2])


@pytest.fixture
def known() -> np.ndarray:
    out = initial_patches()
    follow(out, surface(DEPTH_M), DEPTH_M, DEPTH_M)
    return out


def test_somebody_new_is_where_votes_say():
    assert follow(initial_patches(), surface(DEPTH_M), DEPTH_M, DEPTH_M + 0.02) == DEPTH_M + 0.02


def test_a_joint_goes_as_far_as_its_surface_whatever_votes_say(known):
    assert follow(known, surface(DEPTH_M - 0.01), DEPTH_M, DEPTH_M - 0.02) == pytest.approx(DEPTH_M - 0.01, abs=1e-5)


def test_it_does_so_when_half_of_the_surface_is_hidden(known):
    scene = surface(DEPTH_M - 0.01, hidden_below=0.0)
    assert follow(known, scene, DEPTH_M, DEPTH_M - 0.03) == pytest.approx(DEPTH_M - 0.01, abs=1e-5)


def test_with_too_little_surface_votes_decide(known):
    scene = surface(DEPTH_M - 0.01, hidden_below=0.11)
    assert follow(known, scene, DEPTH_M, DEPTH_M - 0.03) == DEPTH_M - 0.03


def test_an_arm_before_the_surface_moves_nothing(known):
    scene = surface(DEPTH_M)
    scene.point[: scene.count // 3, 2] -= 0.15
    assert follow(known, scene, DEPTH_M, DEPTH_M) == pytest.approx(DEPTH_M, abs=1e-5)


def test_the_outline_of_a_hand_that_passes_moves_nothing(known):
    scene = surface(DEPTH_M + 0.01)
    mixed = scene.point[: scene.count, 0] > 0.05  # cells there hold some points of the hand, some of the trunk
    scene.point[: scene.count, 2][mixed] -= 0.04
    assert follow(known, scene, DEPTH_M, DEPTH_M) == pytest.approx(DEPTH_M + 0.01, abs=1e-4)


def test_what_stays_before_the_surface_is_learnt_anew(known):
    near = surface(DEPTH_M - surface_tracking.GATE_M - 0.05)
    for _ in range(round(surface_tracking.RELEARN_S / DT_S) + 2):
        follow(known, near, DEPTH_M, DEPTH_M)
    assert follow(known, near, DEPTH_M - 0.01, DEPTH_M) == pytest.approx(DEPTH_M, abs=1e-3)


def test_votes_are_right_in_the_long_run(known):
    depth_m = DEPTH_M
    for _ in range(300):
        depth_m = follow(known, surface(DEPTH_M), depth_m, DEPTH_M + 0.02)
    assert depth_m == pytest.approx(DEPTH_M + 0.02, abs=1e-3)
