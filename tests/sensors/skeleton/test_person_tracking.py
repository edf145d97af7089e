"""Persons over time: coasting, coming back, growing, turning."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.core import INFERRED, NOT_TRACKED, TRACKED
from sjasim.sensors.skeleton import person_tracking, posture_prior
from sjasim.sensors.skeleton.person_tracking import Person, recover_lost, remove_duplicates
from sjasim.sensors.skeleton.trained_model import default_model, runtime_model

MODEL = runtime_model(default_model())
DT_S = 1 / 30
ALL = np.ones(25, dtype=bool)


def standing(x: float, z: float, yaw_rad: float = 0.0) -> np.ndarray:
    return posture_prior.sensor_from_body(MODEL.mean, yaw_rad) + np.array([x, 0.0, z])


def person(x: float = 0.0, z: float = 3.0, yaw_rad: float = 0.0, frames: int = 5) -> Person:
    one = Person(0, np.array([x, z]), yaw_rad=yaw_rad, scale=1.0)
    for _ in range(frames):
        step(one, standing(x, z, yaw_rad))
    return one


def step(one: Person, joints: np.ndarray, seen: np.ndarray = ALL) -> None:
    one.predict(DT_S)
    one.update(joints, seen, MODEL, DT_S)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.8, -1.6, 3.0])
def test_the_persons_frame_and_back(yaw_rad: float):
    points = np.random.default_rng(0).normal(size=(25, 3))
    assert posture_prior.sensor_from_body(posture_prior.body_from_sensor(points, yaw_rad), yaw_rad) == pytest.approx(
        points
    )
    assert posture_prior.estimate_yaw(standing(0.3, 3.0, yaw_rad), ALL) == pytest.approx(yaw_rad, abs=0.1)


def test_somebody_who_stands_is_tracked_where_seen():
    one = person()
    assert (one.state == TRACKED).all()
    assert one.joints == pytest.approx(standing(0.0, 3.0), abs=1e-6)
    assert one.confirmed


def test_a_walk_at_constant_speed_is_followed_without_delay():
    one = person()
    for tick in range(1, 46):
        step(one, standing(0.0, 3.0 - 0.4 * tick * DT_S))
    assert one.joints == pytest.approx(standing(0.0, 3.0 - 0.4 * 45 * DT_S), abs=0.004)
    assert one.velocity == pytest.approx([0.0, -0.4], abs=0.02)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.8, -1.6])
def test_a_trunk_that_stands_shakes_far_less_than_its_votes(yaw_rad: float):
    one, rng, depths_m = person(yaw_rad=yaw_rad), np.random.default_rng(0), []
    for _ in range(90):
        step(one, standing(0.0, 3.0, yaw_rad) + rng.normal(0.0, 0.005, (25, 3)))
        depths_m.append(one.joints[0, 2])
    assert np.std(np.diff(depths_m)) < 0.001


@pytest.mark.parametrize("yaw_rad", [0.0, 0.8])
def test_a_start_is_followed_within_a_frame(yaw_rad: float):
    one = person(yaw_rad=yaw_rad)
    ways_m = 0.5 * 1.5 * (np.arange(1, 13) * DT_S) ** 2
    for way_m in ways_m:
        step(one, standing(0.0, 3.0 - way_m, yaw_rad))
    behind_m = one.joints[0, 2] - standing(0.0, 3.0 - ways_m[-1], yaw_rad)[0, 2]
    assert behind_m < ways_m[-1] - ways_m[-2]


def test_a_hidden_arm_goes_with_the_trunk_and_comes_back_without_a_jump_of_the_trunk():
    one, arm = person(), [5, 6, 7, 21, 22]
    seen = ALL.copy()
    seen[arm] = False
    for tick in range(1, 20):
        step(one, standing(0.0, 3.0 - 0.3 * tick * DT_S), seen)
    assert (one.state[arm] == INFERRED).all()
    assert np.abs(one.joints[arm] - standing(0.0, 3.0 - 0.3 * 19 * DT_S)[arm]).max() < 0.25
    for tick in range(20, 40):
        step(one, standing(0.0, 3.0 - 0.3 * tick * DT_S))
    assert (one.state == TRACKED).all()


def test_a_spine_that_comes_back_elsewhere_goes_there_smoothly():
    one, seen = person(), ALL.copy()
    seen[0] = False
    for _ in range(5):
        step(one, standing(0.0, 3.0), seen)
    off = standing(0.0, 3.0)
    off[0, 2] += 0.08
    before = one.joints[0, 2]
    step(one, off)
    assert abs(one.joints[0, 2] - before) < 0.02
    assert one.state[0] == INFERRED
    for _ in range(60):
        step(one, off)
    assert one.joints[0, 2] == pytest.approx(off[0, 2], abs=0.02)
    assert one.state[0] == TRACKED


def test_out_of_sight_one_coasts_is_inferred_then_not_tracked():
    one = person()
    for tick in range(1, 30):
        step(one, standing(0.5 * tick * DT_S, 3.0))
    x = float(one.place[0])
    for _ in range(15):
        one.predict(DT_S)
        one.coast(DT_S)
    assert one.place[0] == pytest.approx(x + 0.5 * 0.5 * 0.8, abs=0.06)
    assert (one.state == INFERRED).all()
    for _ in range(10):
        one.coast(DT_S)
    assert (one.state == NOT_TRACKED).all()


def test_a_place_near_somebody_lost_is_theirs_and_others_are_new():
    lost, near = person(0.0, 3.0), (0.3, 3.2)
    lost.missing_s = 0.2
    assert recover_lost([near, (2.0, 3.0)], [lost]) == [(2.0, 3.0)]
    assert lost.place == pytest.approx(near)
    assert recover_lost([near], [person(0.0, 3.0)]) == [near]


def test_of_two_in_one_place_the_one_seen_longer_stays():
    old, new, other = person(frames=9), person(0.1, 3.0, frames=3), person(1.0, 3.0)
    assert remove_duplicates([new, old, other]) == [old, other]


def test_a_hidden_crown_does_not_shrink_anybody():
    one = Person(0, np.zeros(2))
    one.update_size(1.70, 0.4, DT_S)
    tall = one.scale
    assert tall == pytest.approx(1.70 / person_tracking.CROWN / 1.75)
    for _ in range(300):
        one.update_size(1.20, 0.4, DT_S)
    assert one.scale == tall
    for _ in range(60):
        one.update_size(1.80, 0.4, DT_S)
    assert one.scale == pytest.approx(1.80 / person_tracking.CROWN / 1.75, rel=0.01)


def test_the_forest_rights_a_yaw_that_has_gone_astray():
    one = Person(0, np.zeros(2), yaw_rad=0.0)
    votes = np.array([math.cos(3.0), math.sin(3.0), 90.0])
    for _ in range(15):
        one.update_yaw(votes, DT_S)
    assert abs(person_tracking.wrap_angle(one.yaw_rad - 3.0)) < 0.6
    one.update_yaw(np.zeros(3), DT_S)
    assert not math.isnan(one.yaw_rad)


def test_hands_that_touch_stay_known_for_a_while_and_hands_apart_do_not():
    left, right = person_tracking.HAND_JOINTS.T
    for gap_m, held in ((0.06, True), (0.40, False)):
        one, joints, seen = person(), standing(0.0, 3.0), ALL.copy()
        joints[left] = joints[1] + [0.5 * gap_m, 0.1, -0.3]
        joints[right] = joints[left] - [gap_m, 0.0, 0.0]
        joints[person_tracking.ELBOWS] = joints[left[0]] + [[0.15, -0.2, 0.1], [-0.15, -0.2, 0.1]]
        step(one, joints)
        for _ in range(6):
            step(one, joints)
        seen[[*left, *right]] = False
        for tick in range(20):
            counted = seen.copy()
            one.bridge_dropouts(joints, counted, ~ALL, DT_S)
            step(one, joints, counted)
            known = (tick + 1) * DT_S - 1e-9 < (person_tracking.CLASP_S if held else person_tracking.HOLD_S)
            assert counted[left].all() == counted[right].all() == known


def held(joints: np.ndarray, seen: np.ndarray, one: Person) -> np.ndarray:
    counted = seen.copy()
    one.bridge_dropouts(joints, counted, np.zeros(25, dtype=bool), DT_S)
    return counted


def test_a_joint_that_leaps_is_not_believed_until_it_stays_there():
    hand = JOINT_INDEX["HandLeft"]
    one, joints = person(), standing(0.0, 3.0)
    joints[hand] += [0.0, 0.5, 0.0]
    believed = [bool(held(joints, ALL, one)[hand]) for _ in range(6)]
    assert not any(believed[: int(person_tracking.LEAP_S / DT_S) - 1])
    assert any(believed)


@pytest.mark.parametrize("yaw_rad", [0.0, 1.5, -1.5])
def test_hands_found_together_beside_a_hip_are_the_hand_of_that_side(yaw_rad: float):
    left, right = person_tracking.HAND_JOINTS.T
    one, joints = person(yaw_rad=yaw_rad), standing(0.0, 3.0, yaw_rad)
    joints[right] = joints[left] + [0.02, 0.0, 0.0]
    one.joints = joints.copy()
    for _ in range(4):
        counted = held(joints, ALL, one)
    assert counted[left].all()
    assert not counted[right].any()


def test_a_hand_hidden_as_two_meet_is_beside_the_other():
    left, right = person_tracking.HAND_JOINTS.T
    one, joints, seen = person(), standing(0.0, 3.0), ALL.copy()
    joints[left] = joints[1] + [0.08, 0.1, -0.3]
    joints[right] = joints[left] - [0.15, 0.0, 0.0]
    joints[person_tracking.ELBOWS] = joints[left[0]] + [[0.15, -0.2, 0.1], [-0.15, -0.2, 0.1]]
    one.joints = joints.copy()
    found = joints.copy()
    found[right] += [0.0, -0.6, 0.0]
    seen[right] = False
    counted = held(found, seen, one)
    assert counted[right].all()
    assert found[left] - found[right] == pytest.approx(person_tracking.CLOSING_RATIO * (joints[left] - joints[right]))


def test_a_hand_with_too_few_votes_stays_known_for_longer_but_not_elsewhere():
    left = person_tracking.HAND_JOINTS[1, 0]
    for off_m, held_s in ((0.0, person_tracking.WEAK_S), (0.4, 0.0)):
        one, joints, seen = person(), standing(0.0, 3.0), ALL.copy()
        seen[left] = False
        joints[left, 1] += off_m
        for tick in range(20):
            counted = seen.copy()
            one.bridge_dropouts(joints, counted, ALL, DT_S)
            assert counted[left] == ((tick + 1) * DT_S - 1e-9 < held_s)
            step(one, joints, counted)


def test_no_hand_is_farther_from_its_elbow_than_a_forearm():
    wrist, fist = person_tracking.HAND_JOINTS[:2, 0]
    one, joints = person(), standing(0.0, 3.0)
    for off_m, believed in ((0.0, True), (0.4, False)):
        found = joints.copy()
        found[[wrist, fist], 1] -= off_m
        one.joints = found.copy()
        assert held(found, ALL, one)[[wrist, fist]].tolist() == [believed, believed]


def test_a_hand_held_without_votes_away_from_its_wrist_is_not_seen():
    wrist, fist = person_tracking.HAND_JOINTS[:2, 0]
    one, joints, seen = person(), standing(0.0, 3.0), ALL.copy()
    elbow = person_tracking.ELBOWS[0]
    joints[wrist], joints[fist] = joints[elbow] + [0.0, -0.25, 0.0], joints[elbow] + [0.0, 0.25, 0.0]
    one.joints, seen[fist] = joints.copy(), False
    counted = held(joints, seen, one)
    assert counted[wrist]
    assert not counted[fist]
