"""Claps seen from the side, through a client that helps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.config import DetectorConfig
from sjasim.core import ClientOrder, DeviceEvent, Kind, SkeletonFrame, Skeletons
from sjasim.sensors.events.side_view_claps import SideClapDetector

from ..scripted import FRAME_HZ, NORTH, Screen, Script, ScriptedView, Walk, client

CLAPS = [2.0 + 2.5 * k for k in range(8)]


def help_out(view: ScriptedView, until_s: float, seed: int = 0) -> list[DeviceEvent]:
    """Events of a client that is asked for claps only."""
    watcher = client(seed, group=len(view.scripts))
    watcher.handle_message(0.0, ClientOrder("north", False, assist=True), 0.0)
    messages: list[object] = []
    for tick in range(round(until_s * FRAME_HZ)):
        watcher.capture_frame(tick / FRAME_HZ, view.at(tick / FRAME_HZ))
        messages += watcher.pop_messages(tick / FRAME_HZ)
    return [message for message in messages if isinstance(message, DeviceEvent)]


@pytest.mark.parametrize("heading", [0.0, math.pi])
def test_claps_are_heard_from_either_side_once_each(heading: float):
    events = help_out(ScriptedView([Script((0.0, 0.3), heading, claps=CLAPS)]), 23.0)
    assert [event.kind for event in events] == [Kind.CLAP] * len(CLAPS)
    for event, clap in zip(events, CLAPS, strict=True):
        assert clap < event.t_device_s < clap + 0.25
        assert event.t_onset_device_s == pytest.approx(clap, abs=0.12)


def test_the_near_hand_is_enough():
    """A sphere before the far hand, all the time."""
    script = Script((0.0, 0.3), 0.0, claps=CLAPS)
    far = np.array([0.06, 0.3 - 0.26, 0.80])
    view = ScriptedView([script], [Screen(tuple(0.9 * far + 0.1 * NORTH.position), 0.08)])
    assert len(help_out(view, 23.0)) == len(CLAPS)


def test_walking_and_turning_are_no_claps():
    walks = [Walk(2.0 + 3.0 * k, 1.8, 0.5 * (-1) ** k) for k in range(6)]
    turns = [(21.0, 1.8, math.pi / 2), (24.0, 1.8, -math.pi)]
    for seed in range(3):
        view = ScriptedView([Script((0.0, 0.3), 0.0, walks=walks, turns=turns)])
        assert help_out(view, 28.0, seed) == []


def test_claps_behind_a_back_are_not_seen():
    assert help_out(ScriptedView([Script((0.0, 0.3), -math.pi / 2, claps=CLAPS)]), 23.0) == []


def test_one_arm_that_swings_across_is_no_clap():
    view = ScriptedView([Script((0.0, 0.3), 0.0)])
    detectors, persons = SideClapDetector(DetectorConfig()), np.zeros(1, dtype=np.int64)
    events = []
    for tick in range(120):
        t_s = tick / FRAME_HZ
        joints = (view.at(t_s).joints_m - NORTH.position) @ NORTH.world_from_sensor
        near = 7 if joints[0, 7, 2] < joints[0, 11, 2] else 11
        joints[0, near, 2] += 0.26 * max(0.0, math.sin(2 * math.pi * 0.5 * t_s))
        skeletons = Skeletons(persons, joints, np.full((1, 25), 2, dtype=np.int8))
        events += detectors.update(SkeletonFrame("north", t_s, t_s, t_s, skeletons))
    assert events == []
