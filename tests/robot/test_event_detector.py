"""Tests of the robot's event detection."""

from __future__ import annotations

from itertools import pairwise

import pytest

from sjasim.config import RobotConfig
from sjasim.core import Kind, RobotState
from sjasim.robot.event_detector import RobotEventDetector

CONFIG = RobotConfig()
DT = 0.02


def detect(speeds: list[float], yaw_rates: list[float] | None = None, dt: float = DT) -> list[tuple[Kind, int]]:
    """Events of a sequence of samples, with the index of the sample that each is stamped with."""
    detector = RobotEventDetector(CONFIG)
    found = []
    for k, speed in enumerate(speeds):
        yaw_rate = yaw_rates[k] if yaw_rates else 0.0
        event = detector.update(RobotState(k * dt, 0.0, 0.0, 0.0, speed * dt, yaw_rate))
        if event is not None:
            found.append((event[0], round(event[1] / dt)))
    return found


REST = [0.0] * 5


def test_starts_and_stops_have_the_time_of_the_first_of_three_samples():
    assert detect(REST + [0.25] * 10 + REST) == [(Kind.START_FORWARD, 5), (Kind.STOP_FORWARD, 15)]
    assert detect(REST + [-0.25] * 10 + REST) == [(Kind.START_BACKWARD, 5), (Kind.STOP_BACKWARD, 15)]


def test_an_event_is_reported_with_the_third_sample():
    detector = RobotEventDetector(CONFIG)
    reported = [detector.update(RobotState(k * DT, 0.0, 0.0, 0.0, 0.005, 0.0)) for k in range(3)]
    assert reported == [None, None, (Kind.START_FORWARD, 0.0)]


def test_two_samples_do_not_confirm_an_event():
    assert detect(REST + [0.25] * 2 + REST) == []
    assert detect([0.25] * 5 + [0.0] * 2 + [0.25] * 5) == [(Kind.START_FORWARD, 0)]


def test_a_contrary_sample_restarts_the_count():
    assert detect([*REST, 0.25, 0.05, 0.25, 0.25, 0.25]) == [(Kind.START_FORWARD, 7)]
    assert detect([0.25] * 5 + [0.05, 0.05, 0.15, 0.05, 0.05, 0.05]) == [
        (Kind.START_FORWARD, 0),
        (Kind.STOP_FORWARD, 8),
    ]


@pytest.mark.parametrize("dt", [0.05, 0.02, 0.005])
def test_the_threshold_does_not_depend_on_the_rate(dt):
    assert detect([0.09] * 50, dt=dt) == []
    assert detect([0.11] * 50, dt=dt)[0][0] is Kind.START_FORWARD


def test_intervals_are_differences_of_the_samples_times():
    detector = RobotEventDetector(CONFIG)
    ticks = [0, 5, 10, 15, 20, 24, 29, 34, 39, 44, 48]
    steps = [0.095 * (b - a) / 240 for a, b in pairwise(ticks)]
    samples = [RobotState(b / 240, 0.0, 0.0, 0.0, s, 0.0) for b, s in zip(ticks[1:], steps, strict=True)]
    assert [detector.update(sample) for sample in samples] == [None] * 10


def test_a_reversal_without_a_pause_gives_a_stop_and_a_start():
    assert detect([0.25] * 5 + [-0.25] * 5) == [
        (Kind.START_FORWARD, 0),
        (Kind.STOP_FORWARD, 5),
        (Kind.START_BACKWARD, 5),
    ]


def test_a_turn_has_the_time_of_its_first_sample_and_is_reported_once():
    yaw = [0.0] * 3 + [0.39, 0.41, 1.0, 1.6, 0.38, 0.45, 0.2, 0.0, 0.0, 0.0, -0.5, -0.5]
    assert detect([0.0] * len(yaw), yaw) == [(Kind.TURN, 4), (Kind.TURN, 13)]


def test_nothing_starts_during_a_turn():
    yaw = [0.0] * 3 + [1.5] * 8 + [0.0] * 5
    speeds = [0.0] * 3 + [0.15] * 8 + [0.0] * 5
    assert detect(speeds, yaw) == [(Kind.TURN, 3)]


def test_a_move_still_stops_during_a_turn():
    yaw = [0.0] * 6 + [1.5] * 8
    speeds = [0.25] * 8 + [0.05] * 6
    assert detect(speeds, yaw) == [(Kind.START_FORWARD, 0), (Kind.TURN, 6), (Kind.STOP_FORWARD, 8)]
