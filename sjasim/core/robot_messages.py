"""Commands to the robot and its wheels, and readings and state that the robot reports."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from .vocabulary import Move


@dataclass(frozen=True, slots=True)
class MoveCommand:
    """A command to the robot. Repeated copies have the same number and are executed once.

    Attributes:
        number: number of the command in the session, from 1; a higher number replaces a lower one.
        move: FORWARD, BACKWARD, STOP, TURN or DRIVE.
        t_start_s: session time when the server first sent it.
        speed_m_s: cruise speed of a forward or backward move. For DRIVE, and for a STOP that drives the robot to its
            slot at low speed, the speed itself, negative backwards.
        heading_rad: absolute odometry heading at which a turn ends, or to which the robot steers during a move or stop.
        iteration: iteration to which the command belongs.
        ordinal: place of its event among the iteration's events, from 0.
        why: method and evidence in words.
        yaw_rate_rad_s: yaw rate of DRIVE; the other moves determine their own.
    """

    number: int
    move: Move
    t_start_s: float
    speed_m_s: float
    heading_rad: float
    iteration: int
    ordinal: int
    why: str
    yaw_rate_rad_s: float = 0.0


class WheelCommand(NamedTuple):
    """Angular speeds of the wheels that the base is to reach [rad/s]."""

    left_rad_s: float
    right_rad_s: float


class WheelReading(NamedTuple):
    """Readings of the base's sensors: wheel angles since power-up [rad] and the gyro's yaw rate [rad/s]."""

    left_rad: float
    right_rad: float
    yaw_rate_rad_s: float


class RobotState(NamedTuple):
    """The robot's odometry estimate. Its computer runs the server's clock, so the time is session time.

    Attributes:
        t_s: when the sample was taken.
        x_m: estimated position along world x.
        y_m: estimated position along world y.
        heading_rad: estimated heading, unwrapped.
        step_m: displacement along the heading since the last sample.
        yaw_rate_rad_s: yaw rate of the gyro.
    """

    t_s: float
    x_m: float
    y_m: float
    heading_rad: float
    step_m: float
    yaw_rate_rad_s: float
