"""Tests of the kinematics of a differential drive."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sjasim.config import RobotConfig
from sjasim.core import WheelCommand
from sjasim.robot.diff_drive import advance_pose, body_rates, wheel_command

CONFIG = RobotConfig()
SEPARATION = CONFIG.wheel_separation_m


@given(st.floats(-0.3, 0.3), st.floats(-3.0, 3.0))
def test_body_rates_invert_wheel_command(speed, yaw_rate):
    assert body_rates(wheel_command(speed, yaw_rate, CONFIG), CONFIG) == pytest.approx((speed, yaw_rate), abs=1e-12)


def test_positive_wheels_drive_forward_and_left_turns_counter_clockwise():
    straight = wheel_command(0.35, 0.0, CONFIG)
    assert (straight.left_rad_s, straight.right_rad_s) == pytest.approx((10.0, 10.0))
    turn = wheel_command(0.0, 1.0, CONFIG)
    assert turn.left_rad_s == -turn.right_rad_s
    assert turn.right_rad_s == pytest.approx(SEPARATION / 2 / CONFIG.wheel_radius_m)


def test_wheel_commands_keep_the_limits():
    assert body_rates(wheel_command(9.0, 0.0, CONFIG), CONFIG) == pytest.approx((CONFIG.max_speed_m_s, 0.0))
    assert body_rates(wheel_command(0.0, -9.0, CONFIG), CONFIG) == pytest.approx((0.0, -math.pi))


def test_an_arc_beyond_the_limit_keeps_its_curvature():
    wheels = wheel_command(0.6, 2.0, CONFIG)
    speed, yaw_rate = body_rates(wheels, CONFIG)
    assert max(wheels.left_rad_s, wheels.right_rad_s) * CONFIG.wheel_radius_m == pytest.approx(CONFIG.max_speed_m_s)
    assert yaw_rate / speed == pytest.approx(2.0 / 0.6)


@pytest.mark.parametrize("turn", [1e-9, 1e-3, 0.5, math.pi / 2, 3.0, -2.0])
@pytest.mark.parametrize("radius", [0.0, 0.4, -0.7])
def test_an_arc_is_exact(turn, radius):
    """A circle of this radius, centre on the robot's left, started at the origin facing x."""
    path = radius * turn
    half = turn * SEPARATION / 2
    x, y, heading = advance_pose((0.0, 0.0, 0.0), path - half, path + half, SEPARATION)
    assert heading == pytest.approx(turn)
    assert (x, y) == pytest.approx((radius * math.sin(turn), radius * (1 - math.cos(turn))), abs=1e-9)


def test_many_small_arcs_add_up_to_the_large_one():
    pose = (0.3, -0.2, 0.7)
    whole = advance_pose(pose, 0.5, 0.8, SEPARATION)
    for _ in range(1000):
        pose = advance_pose(pose, 0.0005, 0.0008, SEPARATION)
    assert pose == pytest.approx(whole)


def test_the_opposite_motion_returns_to_the_pose():
    pose = (1.0, 2.0, -3.0)
    assert advance_pose(advance_pose(pose, 0.4, 0.1, SEPARATION), -0.4, -0.1, SEPARATION) == pytest.approx(pose)


def test_heading_is_not_wrapped():
    assert advance_pose((0.0, 0.0, 0.0), -5 * SEPARATION, 5 * SEPARATION, SEPARATION)[2] == pytest.approx(10.0)


def test_body_rates_of_a_still_base():
    assert body_rates(WheelCommand(0.0, 0.0), CONFIG) == (0.0, 0.0)
