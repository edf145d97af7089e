"""Which joints count as seen: short dropouts are bridged, leaps and impossible hands are rejected."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.sensors.skeleton import dropouts
from sjasim.sensors.skeleton.joint_groups import ELBOWS, HAND_JOINTS, SPINE_MID
from sjasim.sensors.skeleton.person_tracking import Person

from .standing import ALL, DT_S, standing, track, tracked_person

LEFT, RIGHT = HAND_JOINTS.T
WRIST, HAND = HAND_JOINTS[:2, 0]


def bridged(joints: np.ndarray, seen: np.ndarray, person: Person, weak: np.ndarray = ~ALL) -> np.ndarray:
    """Return which joints count as seen in one frame."""
    out = seen.copy()
    person.bridge_dropouts(joints, out, weak.copy(), DT_S)
    return out


def clasped(gap_m: float) -> np.ndarray:
    """Return a standing person with both hands in front of the chest, some distance apart."""
    joints = standing(0.0, 3.0)
    joints[LEFT] = joints[SPINE_MID] + [0.5 * gap_m, 0.1, -0.3]
    joints[RIGHT] = joints[LEFT] - [gap_m, 0.0, 0.0]
    joints[ELBOWS] = joints[LEFT[0]] + [[0.15, -0.2, 0.1], [-0.15, -0.2, 0.1]]
    return joints


@pytest.mark.parametrize(
    ("gap_m", "hold_s"), [(0.06, dropouts.TOUCH_HOLD_S), (0.40, dropouts.NO_VOTE_HOLD_S)], ids=["touching", "apart"]
)
def test_hands_that_touch_are_held_longer_than_hands_apart(gap_m: float, hold_s: float):
    person = tracked_person()
    joints = clasped(gap_m)
    for _ in range(7):
        track(person, joints)

    seen = ALL.copy()
    seen[[*LEFT, *RIGHT]] = False
    for tick in range(20):
        counted = bridged(joints, seen, person)
        track(person, joints, counted)
        is_held = (tick + 1) * DT_S - 1e-9 < hold_s
        assert counted[LEFT].all() == counted[RIGHT].all() == is_held


def test_a_joint_that_leaps_does_not_count_until_it_stays_there():
    hand = JOINT_INDEX["HandLeft"]
    person = tracked_person()
    joints = standing(0.0, 3.0)
    joints[hand] += [0.0, 0.5, 0.0]
    counted = [bool(bridged(joints, ALL, person)[hand]) for _ in range(6)]
    assert not any(counted[: int(dropouts.LEAP_S / DT_S) - 1])
    assert any(counted)


@pytest.mark.parametrize("yaw_rad", [0.0, 1.5, -1.5])
def test_hands_found_together_beside_a_hip_are_the_hand_of_that_side(yaw_rad: float):
    person = tracked_person(yaw_rad=yaw_rad)
    joints = standing(0.0, 3.0, yaw_rad)
    joints[RIGHT] = joints[LEFT] + [0.02, 0.0, 0.0]
    person.joints = joints.copy()
    for _ in range(4):
        counted = bridged(joints, ALL, person)
    assert counted[LEFT].all()
    assert not counted[RIGHT].any()


def test_a_hand_hidden_while_two_approach_is_put_beside_the_other():
    person = tracked_person()
    joints = clasped(0.15)
    person.joints = joints.copy()
    found = joints.copy()
    found[RIGHT] += [0.0, -0.6, 0.0]
    seen = ALL.copy()
    seen[RIGHT] = False

    assert bridged(found, seen, person)[RIGHT].all()
    expected = dropouts.CLOSING_RATIO * (joints[LEFT] - joints[RIGHT])
    assert found[LEFT] - found[RIGHT] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("off_m", "hold_s"), [(0.0, dropouts.FEW_VOTES_HOLD_S), (0.4, 0.0)], ids=["at its prediction", "elsewhere"]
)
def test_a_hand_with_too_few_votes_is_held_only_at_its_prediction(off_m: float, hold_s: float):
    person = tracked_person()
    joints = standing(0.0, 3.0)
    joints[HAND, 1] += off_m
    seen = ALL.copy()
    seen[HAND] = False
    for tick in range(20):
        counted = bridged(joints, seen, person, weak=ALL)
        assert counted[HAND] == ((tick + 1) * DT_S - 1e-9 < hold_s)
        track(person, joints, counted)


@pytest.mark.parametrize(("off_m", "counts"), [(0.0, True), (0.4, False)])
def test_a_hand_farther_from_its_elbow_than_a_forearm_is_rejected(off_m: float, counts: bool):
    person = tracked_person()
    joints = standing(0.0, 3.0)
    joints[[WRIST, HAND], 1] -= off_m
    person.joints = joints.copy()
    assert bridged(joints, ALL, person)[[WRIST, HAND]].tolist() == [counts, counts]


def test_a_hand_held_without_votes_away_from_its_wrist_is_rejected():
    person = tracked_person()
    joints = standing(0.0, 3.0)
    joints[WRIST] = joints[ELBOWS[0]] + [0.0, -0.25, 0.0]
    joints[HAND] = joints[ELBOWS[0]] + [0.0, 0.25, 0.0]
    person.joints = joints.copy()
    seen = ALL.copy()
    seen[HAND] = False

    counted = bridged(joints, seen, person)
    assert counted[WRIST]
    assert not counted[HAND]
