"""Claps seen from the side, by a client that assists."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.config import DetectorConfig
from sjasim.core import TRACKED, Kind, SkeletonFrame, Skeletons
from sjasim.sensors.events.frame_features import HAND_LEFT, HAND_RIGHT
from sjasim.sensors.events.side_view_claps import SideClapDetector

from ..scripted import FRAME_HZ, NORTH, Screen, Script, ScriptedView, Walk, detect, make_client

CLAPS = [2.0 + 2.5 * k for k in range(8)]


@pytest.mark.parametrize("heading", [0.0, math.pi])
def test_claps_are_detected_once_from_either_side(heading: float):
    events = detect(ScriptedView([Script((0.0, 0.3), heading, claps=CLAPS)]), 23.0, side=True)
    assert [event.kind for event in events] == [Kind.CLAP] * len(CLAPS)
    for event, clap in zip(events, CLAPS, strict=True):
        assert clap < event.t_device_s < clap + 0.25
        assert event.t_onset_device_s == pytest.approx(clap, abs=0.12)


def test_the_near_hand_is_enough():
    """A sphere occludes the far hand all the time."""
    script = Script((0.0, 0.3), 0.0, claps=CLAPS)
    far = np.array([0.06, 0.3 - 0.26, 0.80])
    view = ScriptedView([script], [Screen(tuple(0.9 * far + 0.1 * NORTH.position), 0.08)])
    assert len(detect(view, 23.0, side=True)) == len(CLAPS)


def test_walking_and_turning_are_no_claps():
    walks = [Walk(2.0 + 3.0 * k, 1.8, 0.5 * (-1) ** k) for k in range(6)]
    turns = [(21.0, 1.8, math.pi / 2), (24.0, 1.8, -math.pi)]
    for seed in range(3):
        view = ScriptedView([Script((0.0, 0.3), 0.0, walks=walks, turns=turns)])
        assert detect(view, 28.0, make_client(seed, dancers=1), side=True) == []


def test_claps_behind_a_back_are_not_seen():
    assert detect(ScriptedView([Script((0.0, 0.3), -math.pi / 2, claps=CLAPS)]), 23.0, side=True) == []


def test_one_arm_that_swings_across_is_no_clap():
    view = ScriptedView([Script((0.0, 0.3), 0.0)])
    detector = SideClapDetector(DetectorConfig())
    persons = np.zeros(1, dtype=np.int64)
    events = []
    for tick in range(120):
        t_s = tick / FRAME_HZ
        joints = view.sensor_joints(t_s)
        near = HAND_LEFT if joints[0, HAND_LEFT, 2] < joints[0, HAND_RIGHT, 2] else HAND_RIGHT
        joints[0, near, 2] += 0.26 * max(0.0, math.sin(2 * math.pi * 0.5 * t_s))
        skeletons = Skeletons(persons, joints, np.full((1, 25), TRACKED, dtype=np.int8))
        events += detector.update(SkeletonFrame("north", t_s, t_s, t_s, skeletons))
    assert events == []
