"""The training: repeatable, quick in its small form, and good enough in it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from sjasim.sensors.skeleton.forest import point_features
from sjasim.skeleton_training.forests import Growth, draw_probes, settle
from sjasim.skeleton_training.samples import TrainingSensor, in_body
from sjasim.skeleton_training.scenes import scenes
from sjasim.skeleton_training.train import SMALL, Recipe, train
from sjasim.skeleton_training.tuning import estimate

TINY = Recipe(6, 4, 30, 4, 40, 20, 0, Growth(1, 40, 1, 20))


@pytest.mark.slow
def test_the_same_seed_trains_the_same_model():
    first, second = train(TINY), train(TINY)
    assert first.digest() == second.digest()
    assert train(dataclasses.replace(TINY, seed=1)).digest() != first.digest()


def test_scenes_show_everybody_somewhere_within_their_ranges():
    for mount, scene in scenes(5, 3, "test"):
        points = (scene.joints_m - mount.position) @ mount.world_from_sensor
        assert ((points[:, 0, 2] > 1.5) & (points[:, 0, 2] < 4.5)).all()
        assert ((scene.stature_m >= 1.5) & (scene.stature_m <= 1.95)).all()
        assert (np.abs(scene.yaw_rad) <= np.pi).all()
        left, right = points[:, 4], points[:, 8]
        across = left - right
        assert np.abs(np.angle(np.exp(1j * (np.arctan2(across[:, 2], -across[:, 0]) - scene.yaw_rad)))).max() < 0.3


def test_features_do_not_depend_on_where_a_point_stands_in_the_list():
    mount, scene = next(iter(scenes(1, 3, "test")))
    watcher = TrainingSensor(0, "test")
    seen = watcher.see(mount, scene)
    probes = draw_probes(20, 0)
    rows = np.flatnonzero(seen.scene.owner[: seen.scene.count] == 0)[:40]
    both = point_features(seen.scene, rows, probes, watcher.intrinsics.fx, seen.persons[0])
    assert (
        point_features(seen.scene, rows[::-1].copy(), probes, watcher.intrinsics.fx, seen.persons[0])[::-1] == both
    ).all()


def test_the_persons_frame_turns_with_the_yaw():
    facing = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0])
    towards_sensor = np.array([0.0, 0.2, -1.0])
    assert in_body(towards_sensor, facing) == pytest.approx([1.0, 0.2, 0.0])
    quarter = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 1.0])
    assert in_body(towards_sensor, quarter) == pytest.approx([0.0, 0.2, -1.0])


def settled(turn: np.ndarray, turning: np.ndarray, still: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One joint's offset from a leaf's pixels at some yaws, made of a part that turns and one that does not."""
    cos, sin = np.cos(turn), np.sin(turn)
    away = np.tile(turning, (len(turn), 1))
    away[:, 0] += -sin * still[0] - cos * still[1]
    away[:, 2] += -cos * still[0] + sin * still[1]
    away += np.random.default_rng(0).normal(0.0, 0.01, away.shape)
    return settle(away[:, None].astype(np.float32), np.stack([cos, sin], axis=1).astype(np.float32))


def test_a_leaf_that_sees_people_from_all_sides_tells_what_turns_with_them_from_what_does_not():
    turning, still = np.array([0.05, 0.30, -0.10]), np.array([0.02, 0.12])
    middle, wide = settled(np.random.default_rng(1).uniform(-np.pi, np.pi, 400), turning, still)
    assert middle[0] == pytest.approx([*turning, *still], abs=0.01)
    assert wide[0] == pytest.approx(0.01 * np.sqrt(3), rel=0.2)


def test_a_leaf_that_sees_one_side_only_is_right_on_that_side():
    turning, still = np.array([0.05, 0.30, -0.10]), np.array([0.0, 0.12])
    middle, _ = settled(np.random.default_rng(1).normal(0.0, 0.05, 400), turning, still)
    forward, up, left, aside, beyond = middle[0]
    assert [forward - beyond, up, left - aside] == pytest.approx([0.05 - 0.12, 0.30, -0.10], abs=0.01)


def test_pixels_of_somebody_else_in_a_leaf_do_not_move_its_offsets():
    yaws = np.random.default_rng(1).uniform(-np.pi, np.pi, 400)
    away = np.zeros((400, 1, 3), np.float32)
    away[:20] = 3.0
    middle, wide = settle(away, np.stack([np.cos(yaws), np.sin(yaws)], axis=1).astype(np.float32))
    assert np.abs(middle).max() < 0.01
    assert wide[0] < 0.15


@pytest.mark.slow
def test_the_small_model_reaches_its_band():
    model = train(SMALL)
    found = estimate(scenes(60, 99, "band"), model, 99, "band")
    facing = np.abs(found.yaw_rad) < np.radians(30)
    error = found.error_m[facing][found.support[facing] > model.support]
    assert np.median(error) < 0.035
    assert (found.support[facing] > model.support).mean() > 0.75
