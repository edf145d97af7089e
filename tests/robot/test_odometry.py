from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from sjasim.config import RobotConfig
from sjasim.core import Kind, RobotState, WheelReading
from sjasim.robot.odometry import Odometry, RobotEventDetector

CONFIG = RobotConfig()
RADIUS, TRACK = CONFIG.wheel_radius_m, CONFIG.wheel_separation_m
DT = 0.02


def drive(odometry: Odometry, speed: float, yaw_rate: float, samples: int) -> RobotState:
    """Feed perfect readings of a constant motion, the first at t = 0."""
    state = odometry.update(0.0, WheelReading(0.0, 0.0, yaw_rate))
    for k in range(1, samples + 1):
        left, right = ((speed + side * yaw_rate * TRACK / 2) * k * DT / RADIUS for side in (-1, 1))
        state = odometry.update(k * DT, WheelReading(left, right, yaw_rate))
    return state


def test_the_first_sample_reports_the_start_pose():
    odometry = Odometry(CONFIG, (1.0, -2.0, 0.5))
    state = odometry.update(3.0, WheelReading(12.3, -4.5, 0.0))
    assert state == RobotState(3.0, 1.0, -2.0, 0.5, 0.0, 0.0)
    assert odometry.update(3.02, WheelReading(12.3, -4.5, 0.0)).step_m == 0.0


def test_straight_line_along_the_heading():
    state = drive(Odometry(CONFIG, (1.0, 2.0, math.pi / 2)), 0.25, 0.0, 100)
    assert (state.x_m, state.y_m, state.heading_rad) == pytest.approx((1.0, 2.5, math.pi / 2), abs=2e-4)
    assert state.step_m == pytest.approx(0.005, abs=1e-4)


def test_circle_comes_round():
    state = drive(Odometry(CONFIG, (0.0, 0.0, 0.0)), 0.25, math.pi / 2, 200)
    assert state.heading_rad == pytest.approx(2 * math.pi)
    assert math.hypot(state.x_m, state.y_m) < 2e-3


def test_steps_are_whole_ticks():
    odometry = Odometry(replace(CONFIG, ticks_per_rev=100.0), (0.0, 0.0, 0.0))
    tick = 2 * math.pi / 100
    angles = [0.0, 0.4 * tick, 0.9 * tick, 1.1 * tick, 4.5 * tick, 3.9 * tick]
    steps = [odometry.update(k * DT, WheelReading(a, a, 0.0)).step_m for k, a in enumerate(angles)]
    assert steps == pytest.approx([n * tick * RADIUS for n in (0, 0, 0, 1, 3, -1)])


def test_unequal_intervals_do_not_disturb_the_heading():
    odometry = Odometry(CONFIG, (0.0, 0.0, 0.0))
    times = [n / 240 for n in (0, 5, 10, 15, 20, 24, 29, 34)]
    states = [odometry.update(t, WheelReading(0.0, 0.0, 1.2)) for t in times]
    assert [state.heading_rad for state in states] == pytest.approx([1.2 * t for t in times])


def test_wrong_radius_scales_the_path():
    state = drive(Odometry(replace(CONFIG, wheel_radius_error=0.02), (0.0, 0.0, 0.0)), 0.25, 0.0, 200)
    assert state.x_m == pytest.approx(1.02, abs=2e-4)


def test_wrong_track_turns_the_encoders_heading_only():
    config = replace(CONFIG, wheel_separation_error=-0.05)
    bare = drive(Odometry(config, (0.0, 0.0, 0.0), gyro=False), 0.0, 1.0, 100)
    fused = drive(Odometry(config, (0.0, 0.0, 0.0)), 0.0, 1.0, 100)
    assert bare.heading_rad == pytest.approx(2.0 / 0.95, abs=2e-3)
    assert fused.heading_rad == pytest.approx(2.0)


def test_gyro_bias_drifts():
    state = drive(Odometry(replace(CONFIG, gyro_bias_rad_s=0.01), (0.0, 0.0, 0.0)), 0.0, 0.0, 500)
    assert state.heading_rad == pytest.approx(0.1)
    assert state.yaw_rate_rad_s == pytest.approx(0.01)


def test_gyro_noise_is_seeded_and_of_the_size_asked_for():
    config = replace(CONFIG, gyro_noise_rad_s=0.02)

    def rates(seed: int) -> list[float]:
        odometry = Odometry(config, (0.0, 0.0, 0.0), np.random.default_rng(seed))
        return [odometry.update(k * DT, WheelReading(0.0, 0.0, 0.0)).yaw_rate_rad_s for k in range(2000)]

    assert rates(1) == rates(1)
    assert rates(1) != rates(2)
    assert np.std(rates(1)) == pytest.approx(0.02, rel=0.1)


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


def test_start_and_stop_are_stamped_with_the_first_of_three():
    assert detect(REST + [0.25] * 10 + REST) == [(Kind.START_FORWARD, 5), (Kind.STOP_FORWARD, 15)]
    assert detect(REST + [-0.25] * 10 + REST) == [(Kind.START_BACKWARD, 5), (Kind.STOP_BACKWARD, 15)]


def test_the_event_is_told_with_the_third_sample():
    detector = RobotEventDetector(CONFIG)
    told = [detector.update(RobotState(k * DT, 0.0, 0.0, 0.0, 0.005, 0.0)) for k in range(3)]
    assert told == [None, None, (Kind.START_FORWARD, 0.0)]


def test_two_samples_are_not_enough():
    assert detect(REST + [0.25] * 2 + REST) == []
    assert detect([0.25] * 5 + [0.0] * 2 + [0.25] * 5) == [(Kind.START_FORWARD, 0)]


def test_a_flicker_restarts_the_count():
    assert detect([*REST, 0.25, 0.05, 0.25, 0.25, 0.25]) == [(Kind.START_FORWARD, 7)]
    assert detect([0.25] * 5 + [0.05, 0.05, 0.15, 0.05, 0.05, 0.05]) == [
        (Kind.START_FORWARD, 0),
        (Kind.STOP_FORWARD, 8),
    ]


@pytest.mark.parametrize("dt", [0.05, 0.02, 0.005])
def test_the_threshold_is_a_velocity(dt):
    assert detect([0.09] * 50, dt=dt) == []
    assert detect([0.11] * 50, dt=dt)[0][0] is Kind.START_FORWARD


def test_the_stamped_interval_counts():
    detector = RobotEventDetector(CONFIG)
    ticks = [0, 5, 10, 15, 20, 24, 29, 34, 39, 44, 48]
    steps = [0.095 * (b - a) / 240 for a, b in pairwise(ticks)]
    samples = [RobotState(b / 240, 0.0, 0.0, 0.0, s, 0.0) for b, s in zip(ticks[1:], steps, strict=True)]
    assert [detector.update(sample) for sample in samples] == [None] * 10


def test_reversal_without_a_pause_gives_stop_then_start():
    assert detect([0.25] * 5 + [-0.25] * 5) == [
        (Kind.START_FORWARD, 0),
        (Kind.STOP_FORWARD, 5),
        (Kind.START_BACKWARD, 5),
    ]


def test_a_turn_is_its_first_sample_and_comes_once():
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
