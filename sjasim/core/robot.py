"""What the robot is told, and what it says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from .vocabulary import Move


@dataclass(frozen=True, slots=True)
class MoveCommand:
    """An order to the robot. Repeated copies carry the same number and are executed once.

    Attributes:
        number: counts commands of a session from 1; a higher number replaces a lower one.
        move: FORWARD, BACKWARD, STOP, TURN or DRIVE.
        t_start_s: session time when the server sent it first.
        speed_m_s: cruise speed of a forward or backward move; of DRIVE, and of a STOP that lets the robot settle, its
            speed, negative for backwards.
        heading_rad: absolute odometry heading at which a turn ends, or that a move or a stop takes up meanwhile.
        iteration: the iteration it belongs to.
        ordinal: place of its event among the iteration's events, from 0.
        why: method and evidence in words.
        yaw_rate_rad_s: of DRIVE; other moves set their own.
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
    """Wheel speeds for the base [rad/s]."""

    left_rad_s: float
    right_rad_s: float


class WheelReading(NamedTuple):
    """What the base's own sensors say: wheel angles since power-up [rad], yaw rate [rad/s]."""

    left_rad: float
    right_rad: float
    yaw_rate_rad_s: float


class RobotState(NamedTuple):
    """The robot's own belief, from odometry; session clock (its computer runs the server's clock).

    Attributes:
        t_s: when the sample was taken.
        x_m: dead-reckoned position.
        y_m: the same.
        heading_rad: dead-reckoned heading, unwrapped.
        step_m: displacement along the heading since the last sample.
        yaw_rate_rad_s: the gyro's rate.
    """

    t_s: float
    x_m: float
    y_m: float
    heading_rad: float
    step_m: float
    yaw_rate_rad_s: float
