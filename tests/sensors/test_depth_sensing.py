"""Depth sensing from end to end: from bodies in a scene to skeletons, with nothing of the truth in between."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.config import SensorConfig, SessionConfig
from sjasim.core import INFERRED, NOT_TRACKED, TRACKED, Skeletons
from sjasim.core.clock import stream
from sjasim.core.errors import SjasimError
from sjasim.core.registry import resolve
from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.depth_sensing import IMAGE_MARGIN_M, DepthSensing
from sjasim.sensors.skeleton.estimator import MIN_TRUNK_JOINTS, SkeletonEstimator, yaw_confidence
from sjasim.sensors.skeleton.joint_groups import TRUNK
from sjasim.skeleton_training import report
from sjasim.skeleton_training.trials import Trial, TrialResult, prepare_trial, record_trial, run_trial


@cache
def outcome_of(facing_deg: float, length_s: float = 4.0, **special: bool) -> TrialResult:
    return run_trial(Trial(77, length_s, math.radians(facing_deg), **special))


def test_is_registered_under_its_name():
    assert resolve("sensing", "depth").factory is DepthSensing


@pytest.mark.parametrize(
    ("facing_deg", "median_cm", "p95_cm"), [(0.0, 1.7, 5.0), (45.0, 2.2, 8.0), (-90.0, 2.5, 12.0), (180.0, 3.5, 12.0)]
)
def test_skeletons_are_near_the_truth_at_any_heading(facing_deg: float, median_cm: float, p95_cm: float):
    figures = report.joint_errors([outcome_of(facing_deg)])
    assert figures["median_cm"] < median_cm
    assert figures["p95_cm"] < p95_cm
    assert figures["swapped"] == 0.0
    assert figures["lost"] < 0.02
    assert figures["tracked"] > 0.97
    assert figures["astray"] < 0.015


def test_facing_dancers_are_tracked_each_with_one_identity():
    outcome = outcome_of(0.0)
    assert report.joint_errors([outcome])["tracked"] > 0.98
    assert report.identity_errors([outcome]) == {"changed": 0, "lost_share": 0.0, "ghost_frames": 0}
    base, upper = report.depth_noise_cm([outcome])
    assert base < 0.05
    assert upper < 0.1


def test_errors_by_joint_and_detected_moves_are_reported():
    outcome = outcome_of(0.0)
    rows = report.errors_by_joint([outcome])
    assert rows["SpineBase"][0] < 4.0
    tallies = report.event_counts([outcome])
    assert tallies["moves"].missed == 0


@cache
def frames(count: int = 12) -> tuple[list[np.ndarray], list[Skeletons]]:
    """Return depth frames of a trial and the skeletons that were estimated from them."""
    view, layout = prepare_trial(Trial(78, 4.0))
    mount = layout.mounts[0]
    sensing = DepthSensing(mount, SessionConfig(), stream(0, "sensor"))
    estimator = SkeletonEstimator(sensing.intrinsics, float(mount.position[2]))

    depths = []
    found = []
    for tick in range(count):
        view.set_tick(tick)
        depths.append(sensing.frame(view))
        found.append(estimator.update(view.time_s, depths[-1]))
    return depths, found


def test_joints_beyond_the_tracking_range_are_inferred_and_not_visible():
    view, layout = prepare_trial(Trial(78, 4.0))
    far_m = 3.0
    sensing = DepthSensing(
        layout.mounts[0], SessionConfig(sensors=replace(SensorConfig(), max_range_m=far_m)), stream(0, "sensor")
    )
    for tick in range(12):
        view.set_tick(tick)
        skeletons = sensing.sample(view)
    depth_m = ((view.joints_m - layout.mounts[0].position) @ layout.mounts[0].world_from_sensor)[..., 2]
    assert (depth_m > far_m).any()
    assert not sensing.visibility[depth_m > far_m].any()
    assert sensing.visibility[depth_m <= far_m].any()
    beyond = skeletons.joints[:, :, 2] > far_m
    assert beyond.any()
    assert (skeletons.state[beyond] == INFERRED).all()
    assert (skeletons.state == TRACKED).any()


def test_the_same_frames_give_the_same_skeletons_without_mujoco(tmp_path):
    depths, before = frames()
    np.savez(tmp_path / "frames.npz", depths=np.array(depths))
    program = f"""
import sys, math, numpy as np
from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton.estimator import SkeletonEstimator
estimator = SkeletonEstimator(Intrinsics.from_field_of_view(256, math.radians(70.6), math.radians(60.0)), 0.91)
for tick, depth in enumerate(np.load({str(tmp_path / "frames.npz")!r})["depths"]):
    found = estimator.update(tick / 30, depth)
    np.savez({str(tmp_path)!r} + f"/{{tick}}.npz", joints=found.joints, state=found.state, persons=found.persons)
assert "mujoco" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)
    for tick, one in enumerate(before):
        again = np.load(tmp_path / f"{tick}.npz")
        assert all(np.array_equal(again[name], getattr(one, name), equal_nan=True) for name in again.files)
    assert before[-1].joints.shape == (3, 25, 3)


def test_a_depth_image_reaches_beyond_the_tracking_range():
    view, layout = prepare_trial(Trial(78, 4.0))
    reach_m = 3.0
    sensing = DepthSensing(
        layout.mounts[0], SessionConfig(sensors=SensorConfig(max_range_m=reach_m)), stream(0, "sensor")
    )
    farthest_m = 0.001 * float(sensing.frame(view).max())
    assert reach_m + 0.9 * IMAGE_MARGIN_M < farthest_m <= reach_m + IMAGE_MARGIN_M


def estimator() -> SkeletonEstimator:
    """Return an estimator of half resolution that has seen no frame."""
    sensors = SensorConfig()
    intrinsics = Intrinsics.from_field_of_view(256, sensors.horizontal_fov_rad, sensors.vertical_fov_rad)
    return SkeletonEstimator(intrinsics, 0.91)


def test_an_empty_image_gives_no_skeleton():
    found = estimator().update(0.0, np.zeros((212, 256), np.uint16))
    assert found.joints.shape == (0, 25, 3)
    assert found.state.shape == (0, 25)


@pytest.mark.parametrize(
    "frame",
    [np.zeros((424, 512), np.uint16), np.full((212, 256), np.nan), np.zeros((212, 256), np.int32)],
    ids=["shape", "nan", "type"],
)
def test_a_frame_of_another_shape_or_type_is_refused(frame: np.ndarray):
    with pytest.raises(SjasimError, match="depth frame of shape"):
        estimator().update(0.0, frame)


def test_a_person_out_of_sight_is_inferred_then_not_tracked_then_forgotten():
    depths, _ = frames()
    tracking = estimator()
    for tick, depth in enumerate(depths):
        tracking.update(tick / 30, depth)
    states = []
    for tick in range(len(depths), len(depths) + 120):
        found = tracking.update(tick / 30, np.zeros((212, 256), np.uint16))
        states.append(found.state)
        assert (np.isnan(found.joints[..., 0]) == (found.state == NOT_TRACKED)).all()
    assert len(states[5]) == 3
    assert (states[5] == INFERRED).all()
    assert (states[30] == NOT_TRACKED).all()
    assert len(states[-1]) == 0


def test_of_a_person_with_an_occluded_trunk_only_visible_joints_are_tracked():
    depths, _ = frames()
    tracking = estimator()
    for tick, depth in enumerate(depths):
        before = tracking.update(tick / 30, depth)
    heads_only = depths[-1].copy()
    heads_only[70:] = 0
    for tick in range(len(depths), len(depths) + 45):
        found = tracking.update(tick / 30, heads_only)
    trunk = found.state[:, TRUNK] == TRACKED
    assert len(found.persons) == len(before.persons)
    trunk_lost = trunk.sum(axis=1) < MIN_TRUNK_JOINTS
    assert trunk_lost.any()
    assert np.isnan(found.joints[trunk_lost, 0]).all()
    assert not (found.state[trunk_lost] == INFERRED).any()


def test_at_most_six_persons_are_tracked():
    rng = np.random.default_rng(0)
    depth = np.zeros((212, 256), np.uint16)
    for index in range(9):
        depth[30:190, 8 + 27 * index : 24 + 27 * index] = 2600 + rng.integers(0, 5, (160, 16))
    tracking = estimator()
    for tick in range(5):
        found = tracking.update(tick / 30, depth)
    assert 1 <= len(found.persons) <= 6


def test_the_record_gets_the_dancer_behind_each_person_and_the_visible_joints():
    view, layout = prepare_trial(Trial(79, 3.5))
    sensing = DepthSensing(layout.mounts[0], SessionConfig(), stream(0, "sensor"))
    assert sensing.dancers.shape == (0,)
    assert sensing.visible.shape == (0, 25)
    for tick in range(4):
        view.set_tick(tick)
        found = sensing.sample(view)
    assert sorted(sensing.dancers.tolist()) == [0, 1, 2]
    assert sensing.visible.shape == (3, 25)
    assert sensing.visible[:, JOINT_INDEX["Head"]].all()
    mount = layout.mounts[0]
    true = (view.joints_m[sensing.dancers] - mount.position) @ mount.world_from_sensor
    assert np.linalg.norm(found.joints - true, axis=2)[:, JOINT_INDEX["SpineBase"]].max() < 0.08


def test_frame_loss_has_the_given_rate():
    view, layout = prepare_trial(Trial(79, 3.5))
    sensing = DepthSensing(layout.mounts[0], SessionConfig(sensors=SensorConfig(frame_loss=0.5)), stream(0, "sensor"))
    lost = sum(sensing.sample(view) is None for _ in range(60))
    assert 15 < lost < 45


def test_turning_dancers_keep_left_and_right():
    outcome = run_trial(Trial(81, 9.0, 0.0, turns=True))
    assert report.joint_errors([outcome])["swapped"] < 0.005


def test_a_person_who_leaves_the_image_moves_on_and_does_not_stop_at_its_border():
    view, layout = prepare_trial(Trial(77, 3.5))
    sensing = DepthSensing(layout.mounts[0], SessionConfig(), stream(0, "sensor"))
    estimator = SkeletonEstimator(sensing.intrinsics, float(layout.mounts[0].position[2]))
    still = sensing.frame(view)
    x_m = np.full((115, 3), np.nan)
    for tick in range(len(x_m)):
        shift = 2 * max(tick - 15, 0)
        moved = np.zeros_like(still)
        moved[:, : still.shape[1] - shift] = still[:, shift:]
        found = estimator.update(tick / 30, moved)
        for person, joints in zip(found.persons.tolist(), found.joints, strict=True):
            x_m[tick, person] = joints[JOINT_INDEX["SpineBase"], 0]
    assert np.nanmax(np.diff(x_m[20:], axis=0)) < 0.005
    assert (np.nanmin(x_m, axis=0) < [-2.5, -2.3, -1.7]).all()


@pytest.mark.slow
def test_crossings_and_occlusions_change_no_identity():
    from sjasim.skeleton_training.crossings import crossing_errors, occlusion_errors

    assert crossing_errors(7000, 8)["wrong"] == 0
    assert crossing_errors(8600, 2)["wrong"] == 0
    assert occlusion_errors(7000, 3)["wrong"] == 0


@pytest.mark.slow
def test_full_resolution_is_as_good():
    view, layout = prepare_trial(Trial(77, 4.0, width_px=512))
    outcome = record_trial(view, layout, Trial(77, 4.0, width_px=512), 90)
    assert report.joint_errors([outcome])["median_cm"] < 2.5


def test_yaw_votes_that_disagree_hardly_count():
    agreeing, disagreeing, none = yaw_confidence(np.array([[120.0, 60.0, 180.0], [3.0, -4.0, 180.0], [0.0, 0.0, 0.0]]))
    assert agreeing == 1.0
    assert disagreeing < 0.02
    assert none == 0.0
