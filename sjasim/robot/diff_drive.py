"""Kinematics of a differential drive: two driven wheels on one axle, exact and without state."""

from __future__ import annotations

import math

from ..config import RobotConfig
from ..core import WheelCommand
from ..core.compiled import compiled_inner

Pose = tuple[float, float, float]
"""x [m] and y [m] of the axle's middle, and heading [rad], counter-clockwise and never wrapped."""

_STRAIGHT_RAD = 1e-6
"""An arc that turns by less counts as straight: its chord then differs from its length by less than rounding."""


def wheel_command(speed_m_s: float, yaw_rate_rad_s: float, config: RobotConfig) -> WheelCommand:
    """Wheel speeds that move the base with a speed and a yaw rate, within its limits.

    Speed and yaw rate are first clipped to the limits of the base. Where one wheel would still turn faster than
    ``max_speed_m_s`` allows, both wheels are slowed by the same factor, so that the base stays on the same arc.

    Args:
        speed_m_s: speed of the axle's middle, forward positive.
        yaw_rate_rad_s: counter-clockwise positive.
        config: wheel separation, wheel radius and limits.
    """
    left, right = wheel_speeds(
        speed_m_s,
        yaw_rate_rad_s,
        config.max_speed_m_s,
        config.max_yaw_rate_rad_s,
        config.wheel_separation_m,
        config.wheel_radius_m,
    )
    return WheelCommand(left, right)


@compiled_inner
def wheel_speeds(
    speed_m_s: float,
    yaw_rate_rad_s: float,
    max_speed_m_s: float,
    max_yaw_rate_rad_s: float,
    wheel_separation_m: float,
    wheel_radius_m: float,
) -> tuple[float, float]:
    """Speeds of the left and the right wheel [rad/s]; see `wheel_command`."""
    speed = min(max(speed_m_s, -max_speed_m_s), max_speed_m_s)
    yaw_rate = min(max(yaw_rate_rad_s, -max_yaw_rate_rad_s), max_yaw_rate_rad_s)
    # Each wheel runs on a circle half a wheel separation off the middle's.
    offset = yaw_rate * wheel_separation_m / 2

    fastest = abs(speed) + abs(offset)
    scale = 1.0 / wheel_radius_m
    if fastest > max_speed_m_s:
        scale *= max_speed_m_s / fastest

    return (speed - offset) * scale, (speed + offset) * scale


def body_rates(wheels: WheelCommand, config: RobotConfig) -> tuple[float, float]:
    """Speed [m/s] and yaw rate [rad/s] of a base whose wheels roll without slip; the inverse of `wheel_command`."""
    left = wheels.left_rad_s * config.wheel_radius_m
    right = wheels.right_rad_s * config.wheel_radius_m
    return (left + right) / 2, (right - left) / config.wheel_separation_m


@compiled_inner
def advance_pose(pose: Pose, left_m: float, right_m: float, wheel_separation_m: float) -> Pose:
    """The pose after both wheels have rolled a distance at constant speeds, exact for any arc.

    A turn on the spot leaves x and y unchanged.

    Args:
        pose: pose before.
        left_m: distance that the left wheel has rolled, forward positive.
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
