"""The temporal filter: standing persons are smoothed, walking ones followed, and reappearing joints do not jump."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.core import INFERRED, TRACKED
from sjasim.sensors.skeleton.joint_groups import SPINE_BASE

from .standing import ALL, DT_S, standing, track, tracked_person

LEFT_ARM = [JOINT_INDEX[name] for name in ("ElbowLeft", "WristLeft", "HandLeft", "HandTipLeft", "ThumbLeft")]


def test_a_standing_person_is_tracked_where_seen():
    person = tracked_person()
    assert (person.state == TRACKED).all()
    assert person.joints == pytest.approx(standing(0.0, 3.0), abs=1e-6)
    assert person.confirmed


def test_a_walk_at_constant_speed_is_followed_without_delay():
    person = tracked_person()
    for tick in range(1, 46):
        track(person, standing(0.0, 3.0 - 0.4 * tick * DT_S))
    assert person.joints == pytest.approx(standing(0.0, 3.0 - 0.4 * 45 * DT_S), abs=0.004)
    assert person.velocity == pytest.approx([0.0, -0.4], abs=0.02)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.8, -1.6])
def test_a_standing_trunk_is_less_noisy_than_its_votes(yaw_rad: float):
    person = tracked_person(yaw_rad=yaw_rad)
    rng = np.random.default_rng(0)
    depths_m = []
    for _ in range(90):
        track(person, standing(0.0, 3.0, yaw_rad) + rng.normal(0.0, 0.005, (25, 3)))
        depths_m.append(person.joints[SPINE_BASE, 2])
    assert np.std(np.diff(depths_m)) < 0.001


@pytest.mark.parametrize("yaw_rad", [0.0, 0.8])
def test_a_start_is_followed_within_one_frame(yaw_rad: float):
    person = tracked_person(yaw_rad=yaw_rad)
    travelled_m = 0.5 * 1.5 * (np.arange(1, 13) * DT_S) ** 2
    for distance_m in travelled_m:
        track(person, standing(0.0, 3.0 - distance_m, yaw_rad))
    lag_m = person.joints[SPINE_BASE, 2] - standing(0.0, 3.0 - travelled_m[-1], yaw_rad)[SPINE_BASE, 2]
    assert lag_m < travelled_m[-1] - travelled_m[-2]


def test_a_hidden_arm_moves_with_the_trunk_and_is_tracked_again_when_it_reappears():
    person = tracked_person()
    seen = ALL.copy()
    seen[LEFT_ARM] = False
    for tick in range(1, 20):
        track(person, standing(0.0, 3.0 - 0.3 * tick * DT_S), seen)
    assert (person.state[LEFT_ARM] == INFERRED).all()
    assert np.abs(person.joints[LEFT_ARM] - standing(0.0, 3.0 - 0.3 * 19 * DT_S)[LEFT_ARM]).max() < 0.25

    for tick in range(20, 40):
        track(person, standing(0.0, 3.0 - 0.3 * tick * DT_S))
    assert (person.state == TRACKED).all()


def test_a_trunk_joint_that_reappears_elsewhere_moves_there_smoothly():
    person = tracked_person()
    seen = ALL.copy()
    seen[SPINE_BASE] = False
    for _ in range(5):
        track(person, standing(0.0, 3.0), seen)

    elsewhere = standing(0.0, 3.0)
    elsewhere[SPINE_BASE, 2] += 0.08
    before_m = person.joints[SPINE_BASE, 2]
    track(person, elsewhere)
    assert abs(person.joints[SPINE_BASE, 2] - before_m) < 0.02
    assert person.state[SPINE_BASE] == INFERRED

    for _ in range(60):
        track(person, elsewhere)
    assert person.joints[SPINE_BASE, 2] == pytest.approx(elsewhere[SPINE_BASE, 2], abs=0.02)
    assert person.state[SPINE_BASE] == TRACKED
