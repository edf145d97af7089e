"""Postures as a whole: hidden limbs are where postures of a dance have them."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.sensors.skeleton import posture_prior
from sjasim.sensors.skeleton.trained_model import default_model, runtime_model

MODEL = runtime_model(default_model())
ARM = np.array([JOINT_INDEX[name] for name in ("ElbowLeft", "WristLeft", "HandLeft", "HandTipLeft", "ThumbLeft")])
OTHER_ARM = np.ones(25, dtype=bool)
OTHER_ARM[ARM] = False


def recalled(row: np.ndarray, seen: np.ndarray, memory: np.ndarray) -> np.ndarray:
    body = np.zeros(75)
    posture_prior.infer_hidden_limbs(
        np.concatenate([row.ravel(), seen, np.zeros(4)]),
        seen,
        memory.reshape(len(memory), 75),
        np.ones((len(memory), 2)),
        body,
    )
    return body.reshape(25, 3)


def test_recall_is_the_kernel_mean_of_like_postures():
    rng = np.random.default_rng(0)
    memory, row = rng.normal(0.0, 0.03, (20, 25, 3)), rng.normal(0.0, 0.03, (25, 3))
    unlike = ((memory - row)[:, OTHER_ARM] ** 2).sum(axis=(1, 2))
    weight = np.exp(-unlike / (2 * posture_prior.KERNEL_WIDTH_M**2))
    expected = (weight[:, None, None] * memory).sum(axis=0) / weight.sum()
    assert recalled(row, OTHER_ARM, memory)[ARM] == pytest.approx(expected[ARM])


def test_what_is_seen_is_not_recalled():
    memory = np.random.default_rng(0).normal(0.0, 0.1, (20, 25, 3))
    assert not recalled(np.zeros((25, 3)), np.ones(25, dtype=bool), memory).any()
    assert not recalled(np.zeros((25, 3)), OTHER_ARM, memory)[OTHER_ARM].any()


def test_of_too_few_joints_nothing_is_recalled():
    seen = np.zeros(25, dtype=bool)
    seen[[0, 1, 3]] = True
    assert not recalled(np.zeros((25, 3)), seen, np.ones((5, 25, 3))).any()


@pytest.mark.parametrize("yaw_rad", [0.0, 1.4, -2.0])
def test_a_hidden_arm_is_where_the_dance_has_it_when_the_other_one_claps_or_hangs(yaw_rad: float):
    """The posture of the memory itself, taken out of it, with the left arm hidden."""
    worst = []
    for index in range(0, len(MODEL.memory), 10):
        body = MODEL.memory[index].reshape(25, 3) + MODEL.mean
        joints = posture_prior.sensor_from_body(1.1 * body, yaw_rad) + np.array([0.4, 0.0, 3.0])
        out, others = np.empty((25, 3)), np.delete(MODEL.memory, index, axis=0)
        assert posture_prior.estimate_posture(
            joints, OTHER_ARM, MODEL.posture, others, MODEL.mean, yaw_rad, 1.1, 0.2, np.ones((len(others), 2)), out
        )  # fmt: skip
        worst.append(np.linalg.norm((out - joints)[ARM], axis=1).max())
    assert np.median(worst) < 0.09
    assert np.percentile(worst, 90) < 0.20
