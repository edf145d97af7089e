"""Messages of the robot: move commands, wheel commands, sensor readings and odometry states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from .vocabulary import Move


@dataclass(frozen=True, slots=True)
class MoveCommand:
    """A command to the robot. The server repeats it with the same number, and the robot executes it once.

    Attributes:
        number: number of the command in the session, from 1. A command replaces all commands with lower numbers.
        move: FORWARD, BACKWARD, STOP, TURN or DRIVE.
        t_start_s: session time when the server first sent it.
        speed_m_s: cruise speed of a forward or backward move, not negative. For DRIVE, and for a STOP in which the
            robot drives to its slot at low speed, the signed speed, negative backwards.
        heading_rad: target heading in the odometry frame: the heading at the end of a turn, or the heading that is held
            during another move.
        iteration: iteration to which the command belongs.
        ordinal: index of the step among the iteration's steps, from 0.
        why: method and reason of the decision, for the log.
        yaw_rate_rad_s: yaw rate of DRIVE; not used by other moves.
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
    """Target angular speeds of the left and right wheel [rad/s]."""

    left_rad_s: float
    right_rad_s: float


class WheelReading(NamedTuple):
    """Readings of the base's sensors: wheel angles since power-up [rad] and the gyro's yaw rate [rad/s]."""

    left_rad: float
    right_rad: float
    yaw_rate_rad_s: float


class RobotState(NamedTuple):
    """Odometry estimate of the robot. The robot's computer is assumed to share the server's clock.

    Attributes:
        t_s: session time of the sample.
        x_m: estimated position along world x.
        y_m: estimated position along world y.
        heading_rad: estimated heading, not wrapped to one turn.
        step_m: displacement along the heading since the last sample.
        yaw_rate_rad_s: yaw rate measured by the gyro.
    """

    t_s: float
    x_m: float
    y_m: float
    heading_rad: float
    step_m: float
    yaw_rate_rad_s: float
