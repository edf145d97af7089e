"""Tests of odometry: encoders, gyro, calibration errors and noise."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sjasim.config import RobotConfig
from sjasim.core import RobotState, WheelReading
from sjasim.robot.odometry import Odometry

CONFIG = RobotConfig()
RADIUS, SEPARATION = CONFIG.wheel_radius_m, CONFIG.wheel_separation_m
DT = 0.02


def drive(odometry: Odometry, speed: float, yaw_rate: float, samples: int) -> RobotState:
    """Feed perfect readings of a constant motion, the first at t = 0."""
    state = odometry.update(0.0, WheelReading(0.0, 0.0, yaw_rate))
    for k in range(1, samples + 1):
        left, right = ((speed + side * yaw_rate * SEPARATION / 2) * k * DT / RADIUS for side in (-1, 1))
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


def test_a_circle_returns_to_its_start():
    state = drive(Odometry(CONFIG, (0.0, 0.0, 0.0)), 0.25, math.pi / 2, 200)
    assert state.heading_rad == pytest.approx(2 * math.pi)
    assert math.hypot(state.x_m, state.y_m) < 2e-3


def test_steps_are_whole_encoder_ticks():
    odometry = Odometry(replace(CONFIG, ticks_per_rev=100.0), (0.0, 0.0, 0.0))
    tick = 2 * math.pi / 100
    angles = [0.0, 0.4 * tick, 0.9 * tick, 1.1 * tick, 4.5 * tick, 3.9 * tick]
    steps = [odometry.update(k * DT, WheelReading(a, a, 0.0)).step_m for k, a in enumerate(angles)]
    assert steps == pytest.approx([n * tick * RADIUS for n in (0, 0, 0, 1, 3, -1)])


def test_the_heading_does_not_depend_on_equal_intervals():
    odometry = Odometry(CONFIG, (0.0, 0.0, 0.0))
    times = [n / 240 for n in (0, 5, 10, 15, 20, 24, 29, 34)]
    states = [odometry.update(t, WheelReading(0.0, 0.0, 1.2)) for t in times]
    assert [state.heading_rad for state in states] == pytest.approx([1.2 * t for t in times])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_gyro_is_integrated_by_the_trapezoidal_rule(sign):
    """The rule is exact for a yaw rate that grows evenly, which a sum of the newest rates would overestimate."""
    acceleration = sign * 2.0
    odometry = Odometry(CONFIG, (0.0, 0.0, 0.3))
    times = [n / 240 for n in (0, 5, 10, 15, 20, 24, 29, 34)]
    states = [odometry.update(t, WheelReading(0.0, 0.0, acceleration * t)) for t in times]

    exact = [0.3 + acceleration * t**2 / 2 for t in times]
    assert [state.heading_rad for state in states] == pytest.approx(exact, abs=1e-12)


def test_a_wrong_wheel_radius_scales_the_path():
    state = drive(Odometry(replace(CONFIG, wheel_radius_error=0.02), (0.0, 0.0, 0.0)), 0.25, 0.0, 200)
    assert state.x_m == pytest.approx(1.02, abs=2e-4)


def test_a_wrong_wheel_separation_affects_the_heading_from_encoders_only():
    config = replace(CONFIG, wheel_separation_error=-0.05)
    encoders = drive(Odometry(config, (0.0, 0.0, 0.0), gyro=False), 0.0, 1.0, 100)
    gyro = drive(Odometry(config, (0.0, 0.0, 0.0)), 0.0, 1.0, 100)
    assert encoders.heading_rad == pytest.approx(2.0 / 0.95, abs=2e-3)
    assert gyro.heading_rad == pytest.approx(2.0)


def test_a_gyro_bias_accumulates_in_the_heading():
    state = drive(Odometry(replace(CONFIG, gyro_bias_rad_s=0.01), (0.0, 0.0, 0.0)), 0.0, 0.0, 500)
    assert state.heading_rad == pytest.approx(0.1)
    assert state.yaw_rate_rad_s == pytest.approx(0.01)


def test_gyro_noise_is_seeded_and_has_the_configured_size():
    config = replace(CONFIG, gyro_noise_rad_s=0.02)

    def rates(seed: int) -> list[float]:
        odometry = Odometry(config, (0.0, 0.0, 0.0), np.random.default_rng(seed))
        return [odometry.update(k * DT, WheelReading(0.0, 0.0, 0.0)).yaw_rate_rad_s for k in range(2000)]

    assert rates(1) == rates(1)
    assert rates(1) != rates(2)
    assert np.std(rates(1)) == pytest.approx(0.02, rel=0.1)
