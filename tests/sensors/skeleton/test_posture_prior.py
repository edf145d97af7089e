"""The posture prior: hidden limbs are inferred from remembered postures."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.sensors.skeleton import posture_prior
from sjasim.sensors.skeleton.trained_model import default_model, runtime_model

MODEL = runtime_model(default_model())
ARM = np.array([JOINT_INDEX[name] for name in ("ElbowLeft", "WristLeft", "HandLeft", "HandTipLeft", "ThumbLeft")])
ALL_BUT_ARM = np.ones(25, dtype=bool)
ALL_BUT_ARM[ARM] = False


def inferred(posture: np.ndarray, seen: np.ndarray, memory: np.ndarray) -> np.ndarray:
    """Return the joints (25, 3) that are written for a posture, zeros elsewhere."""
    row = np.concatenate([posture.ravel(), seen, np.zeros(4)])
    postures = memory.reshape(len(memory), 75)
    body = np.zeros(75)
    posture_prior.infer_hidden_limbs(row, seen, postures, np.ones((len(memory), 2)), body)
    return body.reshape(25, 3)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.8, -1.6, 3.0])
def test_body_and_sensor_frames_are_inverse_to_each_other(yaw_rad: float):
    points = np.random.default_rng(0).normal(size=(25, 3))
    there = posture_prior.body_from_sensor(points, yaw_rad)
    assert posture_prior.sensor_from_body(there, yaw_rad) == pytest.approx(points)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.8, -1.6, 3.0])
def test_the_yaw_is_that_of_the_mean_posture(yaw_rad: float):
    joints = posture_prior.sensor_from_body(MODEL.mean, yaw_rad) + np.array([0.3, 0.0, 3.0])
    assert posture_prior.estimate_yaw(joints, np.ones(25, dtype=bool)) == pytest.approx(yaw_rad, abs=0.1)
    assert np.isnan(posture_prior.estimate_yaw(joints, np.zeros(25, dtype=bool)))


def test_a_hidden_limb_is_the_kernel_weighted_mean_of_similar_postures():
    rng = np.random.default_rng(0)
    memory = rng.normal(0.0, 0.03, (20, 25, 3))
    posture = rng.normal(0.0, 0.03, (25, 3))
    square = ((memory - posture)[:, ALL_BUT_ARM] ** 2).sum(axis=(1, 2))
    weight = np.exp(-square / (2 * posture_prior.KERNEL_WIDTH_M**2))
    expected = (weight[:, None, None] * memory).sum(axis=0) / weight.sum()
    assert inferred(posture, ALL_BUT_ARM, memory)[ARM] == pytest.approx(expected[ARM])


def test_seen_joints_are_not_changed():
    memory = np.random.default_rng(0).normal(0.0, 0.1, (20, 25, 3))
    assert not inferred(np.zeros((25, 3)), np.ones(25, dtype=bool), memory).any()
    assert not inferred(np.zeros((25, 3)), ALL_BUT_ARM, memory)[ALL_BUT_ARM].any()


def test_nothing_is_inferred_from_too_few_joints():
    seen = np.zeros(25, dtype=bool)
    seen[[0, 1, 3]] = True
    assert not inferred(np.zeros((25, 3)), seen, np.ones((5, 25, 3))).any()


@pytest.mark.parametrize("yaw_rad", [0.0, 1.4, -2.0])
def test_a_hidden_arm_is_inferred_to_within_decimetres_in_postures_of_the_dance(yaw_rad: float):
    """Each posture is taken out of the memory in turn, and its left arm is hidden."""
    worst = []
    for index in range(0, len(MODEL.memory), 10):
        body = MODEL.memory[index].reshape(25, 3) + MODEL.mean
        joints = posture_prior.sensor_from_body(1.1 * body, yaw_rad) + np.array([0.4, 0.0, 3.0])
        others = np.delete(MODEL.memory, index, axis=0)
        out = np.empty((25, 3))
        assert posture_prior.estimate_posture(
            joints, ALL_BUT_ARM, MODEL.posture, others, MODEL.mean, yaw_rad, 1.1, 0.2, np.ones((len(others), 2)), out
        )  # fmt: skip
        worst.append(np.linalg.norm((out - joints)[ARM], axis=1).max())
    assert np.median(worst) < 0.09
    assert np.percentile(worst, 90) < 0.20
