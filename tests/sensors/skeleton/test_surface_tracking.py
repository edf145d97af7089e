"""Depth correction of SpineBase from the surface in front of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton import surface_tracking
from sjasim.sensors.skeleton.foreground import Foreground
from sjasim.sensors.skeleton.joint_groups import SPINE_BASE
from sjasim.sensors.skeleton.surface_tracking import (
    CELLS,
    PatchGains,
    _weighted_median,
    correct_depth_from_surface,
    initial_patches,
    measure_patches,
)

AT_ONCE = PatchGains(motion=1.0, learning=0.02, correction=1.0)
DT_S = 1 / 30
DEPTH_M = 3.0
BODY_DEPTH_M = 0.12
GRID_M = np.linspace(-0.119, 0.119, 2 * CELLS)


def surface(depth_m: float, hidden_below: float = -1.0) -> Foreground:
    """Return the points of a curved surface in front of SpineBase, 1 m above the floor, of person 0.

    Args:
        depth_m: depth of the joint.
        hidden_below: points with a smaller x belong to somebody else.
    """
    x, y = (grid.ravel() for grid in np.meshgrid(GRID_M, GRID_M))
    foreground = Foreground.allocate(Intrinsics.from_field_of_view(256, 1.2, 1.0))
    foreground.count = len(x)
    foreground.point[: len(x)] = np.stack([x, 1.0 + y, depth_m - BODY_DEPTH_M + 2.0 * x**2], axis=1)
    foreground.owner[: len(x)] = np.where(x < hidden_below, -1, 0)
    return foreground


def skeleton(depth_m: float) -> np.ndarray:
    """Return joints of which only SpineBase is known."""
    out = np.full((25, 3), np.nan)
    out[SPINE_BASE] = 0.0, 1.0, depth_m
    return out


def corrected_m(
    patches: np.ndarray, foreground: Foreground, predicted_m: float, voted_m: float, gains: PatchGains = AT_ONCE
) -> float:
    """Return SpineBase's depth after a frame in which the votes alone would have put it at ``voted_m``."""
    joints = skeleton(voted_m)
    cells = measure_patches(foreground, skeleton(predicted_m)[None], np.ones(1))[0]
    correct_depth_from_surface(
        cells, patches, skeleton(predicted_m), skeleton(voted_m), 30.0, gains, DT_S, joints
    )  # fmt: skip
    return float(joints[SPINE_BASE, 2])


@pytest.fixture
def patches() -> np.ndarray:
    """The patches after one frame in which the votes were right."""
    out = initial_patches()
    corrected_m(out, surface(DEPTH_M), DEPTH_M, DEPTH_M)
    return out


def test_a_new_person_is_where_the_votes_say():
    assert corrected_m(initial_patches(), surface(DEPTH_M), DEPTH_M, DEPTH_M + 0.02) == DEPTH_M + 0.02


def test_a_joint_moves_as_far_as_its_surface_whatever_the_votes_say(patches):
    moved = surface(DEPTH_M - 0.01)
    assert corrected_m(patches, moved, DEPTH_M, DEPTH_M - 0.02) == pytest.approx(DEPTH_M - 0.01, abs=1e-5)


def test_half_of_the_surface_suffices(patches):
    half = surface(DEPTH_M - 0.01, hidden_below=0.0)
    assert corrected_m(patches, half, DEPTH_M, DEPTH_M - 0.03) == pytest.approx(DEPTH_M - 0.01, abs=1e-5)


def test_with_too_little_surface_the_votes_decide(patches):
    little = surface(DEPTH_M - 0.01, hidden_below=0.11)
    assert corrected_m(patches, little, DEPTH_M, DEPTH_M - 0.03) == DEPTH_M - 0.03


def test_an_arm_in_front_of_the_surface_does_not_move_the_joint(patches):
    foreground = surface(DEPTH_M)
    foreground.point[: foreground.count // 3, 2] -= 0.15
    assert corrected_m(patches, foreground, DEPTH_M, DEPTH_M) == pytest.approx(DEPTH_M, abs=1e-5)


def test_the_outline_of_a_passing_hand_does_not_move_the_joint(patches):
    foreground = surface(DEPTH_M + 0.01)
    # The cells there hold some points of the hand and some of the trunk.
    mixed = foreground.point[: foreground.count, 0] > 0.05
    foreground.point[: foreground.count, 2][mixed] -= 0.04
    assert corrected_m(patches, foreground, DEPTH_M, DEPTH_M) == pytest.approx(DEPTH_M + 0.01, abs=1e-4)


def test_a_surface_that_stays_in_front_is_learnt_anew(patches):
    near = surface(DEPTH_M - surface_tracking.GATE_M - 0.05)
    for _ in range(round(surface_tracking.RELEARN_S / DT_S) + 2):
        corrected_m(patches, near, DEPTH_M, DEPTH_M)
    assert corrected_m(patches, near, DEPTH_M - 0.01, DEPTH_M) == pytest.approx(DEPTH_M, abs=1e-3)


def test_in_the_long_run_the_votes_decide(patches):
    depth_m = DEPTH_M
    for _ in range(300):
        depth_m = corrected_m(patches, surface(DEPTH_M), depth_m, DEPTH_M + 0.02)
    assert depth_m == pytest.approx(DEPTH_M + 0.02, abs=1e-3)


def test_the_weighted_median_is_that_of_repeated_values():
    rng = np.random.default_rng(0)
    for _ in range(50):
        values = rng.integers(-4, 5, 9).astype(float)
        weights = rng.integers(0, 4, 9).astype(float)
        weights[0] += 1.0
        repeated = np.sort(np.repeat(values, weights.astype(int)))
        assert _weighted_median(values, weights) == repeated[(len(repeated) - 1) // 2]
    assert _weighted_median(np.zeros(3), np.zeros(3)) == math.inf
