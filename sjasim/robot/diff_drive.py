"""Kinematics of two driven wheels on one axle: exact, without state."""

from __future__ import annotations

import math

from numba import njit

from ..config import RobotConfig
from ..core import WheelCommand

Pose = tuple[float, float, float]
"""x [m], y [m] of the axle's middle, and heading [rad], counter-clockwise and never wrapped."""

_STRAIGHT_RAD = 1e-6


def wheel_command(speed_m_s: float, yaw_rate_rad_s: float, config: RobotConfig) -> WheelCommand:
    """Wheel speeds that move the base as asked, within what it can do.

    Speed and yaw rate are first clipped to the base's limits. Where one wheel would still run faster than
    ``max_speed_m_s``, both are slowed by the same factor, so that the base stays on the arc that was asked for.

    Args:
        speed_m_s: speed of the axle's middle, forward positive.
        yaw_rate_rad_s: counter-clockwise positive.
        config: track, wheel radius and limits.
    """
    left, right = wheel_speeds(
        speed_m_s, yaw_rate_rad_s, config.max_speed_m_s, config.max_yaw_rate_rad_s, config.wheel_separation_m,
        config.wheel_radius_m,
    )  # fmt: skip
    return WheelCommand(left, right)


@njit(cache=True)
def wheel_speeds(
    speed_m_s: float,
    yaw_rate_rad_s: float,
    top_m_s: float,
    spin_rad_s: float,
    wheel_separation_m: float,
    radius_m: float,
) -> tuple[float, float]:
    """Left and right [rad/s]; see `wheel_command`."""
    speed = min(max(speed_m_s, -top_m_s), top_m_s)
    offset = min(max(yaw_rate_rad_s, -spin_rad_s), spin_rad_s) * wheel_separation_m / 2
    fastest = abs(speed) + abs(offset)
    scale = 1.0 / radius_m
    if fastest > top_m_s:
        scale *= top_m_s / fastest
    return (speed - offset) * scale, (speed + offset) * scale


def body_rates(wheels: WheelCommand, config: RobotConfig) -> tuple[float, float]:
    """Speed [m/s] and yaw rate [rad/s] of a base whose wheels roll without slip; undoes `wheel_command`."""
    left = wheels.left_rad_s * config.wheel_radius_m
    right = wheels.right_rad_s * config.wheel_radius_m
    return (left + right) / 2, (right - left) / config.wheel_separation_m


@njit(cache=True)
def moved(pose: Pose, left_m: float, right_m: float, wheel_separation_m: float) -> Pose:
    """Pose after the wheels have rolled, exact for any arc of constant curvature.

    A straight line is the arc of infinite radius; a turn on the spot leaves x and y as they are.

    Args:
        pose: where the base was.
        left_m: path of the left wheel, forward positive.
        right_m: the same of the right wheel.
        wheel_separation_m: distance between the wheels.
    """
    x, y, heading = pose
    half = (right_m - left_m) / wheel_separation_m / 2
    chord = (left_m + right_m) / 2
    if abs(half) > _STRAIGHT_RAD:
        chord *= math.sin(half) / half
    along = heading + half
    return x + chord * math.cos(along), y + chord * math.sin(along), along + half
