"""Training of the skeleton model: determinism, samples, leaves, and the error of a small model."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.sensors.skeleton.forest import point_features
from sjasim.skeleton_training.forests import Growth, draw_probes, mean_offsets
from sjasim.skeleton_training.samples import TrainingSensor, in_person_frame
from sjasim.skeleton_training.scenes import random_scenes
from sjasim.skeleton_training.train import SMALL, Recipe, train
from sjasim.skeleton_training.tuning import estimate_joints

TINY = Recipe(6, 4, 30, 4, 40, 20, 0, Growth(1, 40, 1, 20))


@pytest.mark.slow
def test_the_same_seed_trains_the_same_model():
    first = train(TINY)
    assert train(TINY).digest() == first.digest()
    assert train(dataclasses.replace(TINY, seed=1)).digest() != first.digest()


def test_scenes_have_dancers_within_the_ranges_at_the_headings_they_state():
    for mount, scene in random_scenes(5, 3, "test"):
        points = (scene.joints_m - mount.position) @ mount.world_from_sensor
        assert ((points[:, 0, 2] > 1.5) & (points[:, 0, 2] < 4.5)).all()
        assert ((scene.stature_m >= 1.5) & (scene.stature_m <= 1.95)).all()
        assert (np.abs(scene.yaw_rad) <= np.pi).all()

        shoulders = points[:, JOINT_INDEX["ShoulderLeft"]] - points[:, JOINT_INDEX["ShoulderRight"]]
        error_rad = np.arctan2(shoulders[:, 2], -shoulders[:, 0]) - scene.yaw_rad
        assert np.abs(np.angle(np.exp(1j * error_rad))).max() < 0.3


def test_features_do_not_depend_on_the_order_of_the_points():
    mount, scene = next(iter(random_scenes(1, 3, "test")))
    sensor = TrainingSensor(0, "test")
    observed = sensor.observe_scene(mount, scene)
    foreground = observed.foreground
    rows = np.flatnonzero(foreground.owner[: foreground.count] == 0)[:40]
    assert len(rows) == 40

    def features(order: np.ndarray) -> np.ndarray:
        return point_features(foreground, order, draw_probes(20, 0), sensor.intrinsics.fx, observed.persons[0])

    assert np.array_equal(features(rows[::-1].copy())[::-1], features(rows))


def test_the_frame_of_a_person_turns_with_the_heading():
    facing = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0])
    towards_sensor = np.array([0.0, 0.2, -1.0])
    assert in_person_frame(towards_sensor, facing) == pytest.approx([1.0, 0.2, 0.0])
    quarter = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 1.0])
    assert in_person_frame(towards_sensor, quarter) == pytest.approx([0.0, 0.2, -1.0])


def leaf_means(yaw_rad: np.ndarray, turning: np.ndarray, fixed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and spread of one joint's offsets at some headings: a part that turns, a part that does not, and noise."""
    cos = np.cos(yaw_rad)
    sin = np.sin(yaw_rad)
    offsets = np.tile(turning, (len(yaw_rad), 1))
    offsets[:, 0] += -sin * fixed[0] - cos * fixed[1]
    offsets[:, 2] += -cos * fixed[0] + sin * fixed[1]
    offsets += np.random.default_rng(0).normal(0.0, 0.01, offsets.shape)
    return mean_offsets(offsets[:, None].astype(np.float32), np.stack([cos, sin], axis=1).astype(np.float32))


def test_a_leaf_with_all_headings_separates_the_part_that_turns_from_the_part_that_does_not():
    turning = np.array([0.05, 0.30, -0.10])
    fixed = np.array([0.02, 0.12])
    mean, spread = leaf_means(np.random.default_rng(1).uniform(-np.pi, np.pi, 400), turning, fixed)
    assert mean[0] == pytest.approx([*turning, *fixed], abs=0.01)
    assert spread[0] == pytest.approx(0.01 * np.sqrt(3), rel=0.2)


def test_a_leaf_with_one_heading_has_the_right_sum_of_both_parts_at_that_heading():
    turning = np.array([0.05, 0.30, -0.10])
    mean, _ = leaf_means(np.random.default_rng(1).normal(0.0, 0.05, 400), turning, np.array([0.0, 0.12]))
    forward, up, left, to_sensors_left, away = mean[0]
    assert [forward - away, up, left - to_sensors_left] == pytest.approx([0.05 - 0.12, 0.30, -0.10], abs=0.01)


def test_a_few_pixels_of_another_person_do_not_change_the_mean_of_a_leaf():
    yaws = np.random.default_rng(1).uniform(-np.pi, np.pi, 400)
    offsets = np.zeros((400, 1, 3), np.float32)
    offsets[:20] = 3.0
    mean, spread = mean_offsets(offsets, np.stack([np.cos(yaws), np.sin(yaws)], axis=1).astype(np.float32))
    assert np.abs(mean).max() < 0.01
    assert spread[0] < 0.15


@pytest.mark.slow
def test_the_small_model_has_a_median_error_below_35_mm():
    model = train(SMALL)
    found = estimate_joints(random_scenes(60, 99, "band"), model, 99, "band")
    facing = np.abs(found.yaw_rad) < np.radians(30)
    error = found.error_m[facing][found.support[facing] > model.support]
    assert np.median(error) < 0.035
    assert (found.support[facing] > model.support).mean() > 0.75
