"""Accuracy of joints, on observations whose errors are known."""

import numpy as np
import pytest

from sjasim.analysis.accuracy.skeleton_accuracy import GROUPS, OUTLIER_M, JointObservation, joint_figures, joint_rows
from sjasim.assets.names import JOINT_INDEX
from sjasim.core import INFERRED, NOT_TRACKED, TRACKED

FRAMES = 4000


def observation(bias_m=0.02, drift_m=0.01, correlation=0.95, row=0, trunk=0):
    """All joints tracked, with a constant error and an autoregressive one; the hands are hidden."""
    rng = np.random.default_rng(7)
    drift = np.zeros((FRAMES, 25, 3))
    drift[0] = rng.standard_normal((25, 3))
    for frame in range(1, FRAMES):
        drift[frame] = correlation * drift[frame - 1] + np.sqrt(1 - correlation**2) * rng.standard_normal((25, 3))
    error = bias_m * rng.choice([-1.0, 1.0], (25, 3)) + drift_m * drift
    everywhere = np.zeros(FRAMES, dtype=np.int64)
    state = np.full((FRAMES, 25), TRACKED)
    return JointObservation(
        "depth", error.astype(np.float32), state, everywhere + row, everywhere + trunk, everywhere + 2
    )


def test_every_joint_belongs_to_one_group():
    assert sum(group.astype(int) for group in GROUPS.values()).tolist() == [1] * 25


def test_constant_and_slow_errors_are_separated():
    found = joint_figures([observation()])
    assert found["bias_m"] == pytest.approx(0.02, rel=0.1)
    assert found["drift_m"] == pytest.approx(0.01, rel=0.1)
    assert found["correlation"] == pytest.approx(0.95, abs=0.005)
    assert (found["n"], found["tracked"], found["inferred"], found["inferred_m"]) == (25 * FRAMES, 1.0, 0.0, None)


def test_the_share_of_outliers_is_that_of_tracked_joints():
    one = observation(0.0, 0.0)
    head = JOINT_INDEX["Head"]
    one.error_m[:, head] = [2.0 * OUTLIER_M, 0.0, 0.0]
    one.state[: FRAMES // 2, head] = INFERRED
    one.state[FRAMES // 2 : FRAMES * 3 // 4, JOINT_INDEX["Neck"]] = NOT_TRACKED
    found = joint_figures([one], "head")
    assert found["tracked"] == pytest.approx(0.625)
    assert found["inferred"] == pytest.approx(0.25)
    assert found["astray"] == pytest.approx(0.4)
    assert found["inferred_m"] == pytest.approx(2.0 * OUTLIER_M / np.sqrt(3.0))


def test_rows_and_bands_add_up_and_arms_use_the_visibility_of_the_hands():
    rows = joint_rows([observation(), observation(row=1, trunk=1)])
    n = {(row["joints"], row["row"], row["occlusion"]): row["n"] for row in rows}
    assert n["all", "all", "all"] == 2 * 25 * FRAMES
    assert n["legs", "front", "visible"] == n["legs", "back", "partly"] == n["legs", "back", "all"]
    assert n["arms", "all", "hidden"] == n["arms", "all", "all"]
    assert n["legs", "front", "partly"] == 0
    (empty,) = [row for row in rows if (row["joints"], row["row"], row["occlusion"]) == ("legs", "front", "partly")]
    assert empty["astray"] is empty["bias_m"] is empty["tracked"] is None
