"""The base controller: carries out move commands by wheel speeds, from odometry alone.

It delays a command by the robot's latency, limits accelerations, keeps straight moves on their heading and ends turns
at theirs. It runs at the rate of the odometry and takes every interval from the samples' times.
"""

from __future__ import annotations

import math
from collections import deque
from enum import IntEnum

import numpy as np

from ..config import RobotConfig
from ..core import Array, Move, MoveCommand, RobotState, WheelCommand
from ..core.compiled import compiled_entry, compiled_inner
from ..core.errors import ConfigError
from .diff_drive import wheel_speeds
from .odometry import OdometryColumn

HEADING_GAIN_PER_S = 2.0
"""Yaw rate per heading error on a straight move [1/s] (assumed)."""

HEADING_MAX_RAD_S = 0.35
"""Largest such yaw rate [rad/s]: below the rate that counts as a turn (assumed)."""

HEADING_TOLERANCE_RAD = 0.02
"""A standing robot corrects no smaller heading error [rad] (assumed)."""

HEADING_REACH_RAD = 1.2
"""A move or a stop whose commanded heading is farther off than this keeps the present heading [rad] (assumed)."""

TURN_GAIN_PER_S = 10.0
"""Yaw rate per remaining angle at the end of a turn, where a square-root profile is too steep [1/s] (assumed)."""

TURN_DECELERATION_SHARE = 0.9
"""Share of the yaw acceleration with which the end of a turn is planned, so that the limit is never met (assumed)."""

TURN_LEAD_S = 0.02
"""Time after the last sample at which the wheels respond: one control step [s]."""

TURN_DONE_RAD = math.radians(0.2)
"""Remaining angle at which a turn is over, if the next rate is reached too [rad] (assumed)."""

TURN_DONE_RAD_S = 0.05
"""Yaw rate at which a turn is over [rad/s] (assumed)."""

STALL_S = 0.5
"""Time without motion, though a motion is commanded, after which the robot counts as blocked [s] (assumed)."""

STALL_SHARE = 0.25
"""Share of the commanded speed below which the robot counts as not moving (assumed)."""

STALL_MIN_M_S = 0.05
"""Slowest commanded speed with which a stall is detected [m/s] (assumed)."""

STALL_MIN_RAD_S = 0.2
"""Slowest commanded yaw rate with which a stall is detected [rad/s] (assumed)."""

MAX_INTERVAL_S = 0.1
"""Longest interval over which speeds are ramped at once, after a gap in the samples [s] (assumed)."""

SETTLING_MAX_M_S = 0.09
"""Fastest speed of a STOP that corrects the position [m/s]: below .10 m/s, which counts as a move."""

IDLE = 0.0
"""Activity before the first command and after a turn."""

STOP = 1.0
"""Activity: the base stops, or corrects its position with a low speed."""

FORWARD = 2.0
"""Activity: a move forward."""

BACKWARD = 3.0
"""Activity: a move backward."""

TURN = 4.0
"""Activity: a turn on the spot."""

DRIVE = 5.0
"""Activity: a given speed and yaw rate."""

ACTIVITIES = {Move.FORWARD: FORWARD, Move.BACKWARD: BACKWARD, Move.STOP: STOP, Move.TURN: TURN, Move.DRIVE: DRIVE}
"""Move of a command -> activity. Activities are floats, because they stand in an array of floats."""


class LimitColumn(IntEnum):
    """Places in the limits of a base, with the fields of `RobotConfig` that they hold."""

    SPEED = 0
    """``max_speed_m_s``"""
    YAW_RATE = 1
    """``max_yaw_rate_rad_s``"""
    TURN_RATE = 2
    """``turn_rate_rad_s``"""
    ACCELERATION = 3
    """``acceleration_m_s2``"""
    YAW_ACCELERATION = 4
    """``yaw_acceleration_rad_s2``"""
    TIMEOUT = 5
    """``cmd_timeout_s``"""
    WHEEL_SEPARATION = 6
    """``wheel_separation_m``"""
    WHEEL_RADIUS = 7
    """``wheel_radius_m``"""
    INTERVAL = 8
    """1 / ``odometry_hz`` [s]"""


class DriveColumn(IntEnum):
    """Places in the state of a `BaseController`. Those from ACTIVITY on are set by a command."""

    SPEED = 0
    """Ramped speed [m/s]."""
    YAW_RATE = 1
    """Ramped yaw rate [rad/s]."""
    LEFT_WHEEL = 2
    """Speed of the left wheel that follows [rad/s]."""
    RIGHT_WHEEL = 3
    """Speed of the right wheel [rad/s]."""
    LAST_T = 4
    """Time of the last control step [s]."""
    STALLED = 5
    """Time without motion though a motion is commanded [s]."""
    TIMED_OUT = 6
    """1 if a move is stopped because no command arrived for too long, else 0."""
    HEARD_T = 7
    """Time of the last arrival of a command [s]."""
    ACTIVITY = 8
    """What the base does: `IDLE`, `STOP`, ..."""
    COMMANDED_SPEED = 9
    """[m/s]"""
    COMMANDED_YAW_RATE = 10
    """Of DRIVE [rad/s]."""
    HEADING = 11
    """Heading that a move keeps or a turn ends at [rad]."""
    NEW = 12
    """1 until the first control step of a command, which may change the heading; see `HEADING_REACH_RAD`."""


@compiled_entry
def update_drive(estimate: Array, limits: Array, drive: Array) -> None:
    """Take one control step; see `BaseController`.

    Args:
        estimate: newest odometry estimate, see `OdometryColumn`; its time is that of the step.
        limits: (9,) see `LimitColumn`.
        drive: (13,) state of the controller, in and out; see `DriveColumn`.
    """
    t = estimate[OdometryColumn.T]
    last_t = drive[DriveColumn.LAST_T]
    interval = t - last_t if not math.isnan(last_t) else limits[LimitColumn.INTERVAL]
    interval = min(interval, MAX_INTERVAL_S)
    drive[DriveColumn.LAST_T] = t
    stalls = _stalls(estimate, interval, drive)
    drive[DriveColumn.STALLED] = drive[DriveColumn.STALLED] + interval if stalls else 0.0

    if drive[DriveColumn.NEW] > 0.0:
        drive[DriveColumn.NEW] = 0.0
        off = drive[DriveColumn.HEADING] - estimate[OdometryColumn.HEADING]
        if drive[DriveColumn.ACTIVITY] != TURN and abs(off) > HEADING_REACH_RAD:
            drive[DriveColumn.HEADING] = estimate[OdometryColumn.HEADING]

    # A stop without a speed has nothing to time out.
    activity = drive[DriveColumn.ACTIVITY]
    under_way = activity > STOP or (activity == STOP and drive[DriveColumn.COMMANDED_SPEED] != 0.0)
    late = under_way and t - drive[DriveColumn.HEARD_T] > limits[LimitColumn.TIMEOUT]
    drive[DriveColumn.TIMED_OUT] = 1.0 if late else 0.0

    speed, yaw_rate = (0.0, 0.0) if late else _target(estimate, limits, drive)
    drive[DriveColumn.SPEED] = _approach(drive[DriveColumn.SPEED], speed, limits[LimitColumn.ACCELERATION] * interval)
    drive[DriveColumn.YAW_RATE] = _approach(
        drive[DriveColumn.YAW_RATE], yaw_rate, limits[LimitColumn.YAW_ACCELERATION] * interval
    )

    left, right = wheel_speeds(
        drive[DriveColumn.SPEED],
        drive[DriveColumn.YAW_RATE],
        limits[LimitColumn.SPEED],
        limits[LimitColumn.YAW_RATE],
        limits[LimitColumn.WHEEL_SEPARATION],
        limits[LimitColumn.WHEEL_RADIUS],
    )
    drive[DriveColumn.LEFT_WHEEL] = left
    drive[DriveColumn.RIGHT_WHEEL] = right


@compiled_inner
def _stalls(estimate: Array, interval: float, drive: Array) -> bool:
    """Whether odometry shows too little of the motion that was commanded in the last interval."""
    speed = abs(drive[DriveColumn.SPEED])
    if speed >= STALL_MIN_M_S:
        return bool(abs(estimate[OdometryColumn.STEP]) < STALL_SHARE * speed * interval)

    yaw_rate = abs(drive[DriveColumn.YAW_RATE])
    return bool(yaw_rate >= STALL_MIN_RAD_S and abs(estimate[OdometryColumn.YAW_RATE]) < STALL_SHARE * yaw_rate)


@compiled_inner
def _target(estimate: Array, limits: Array, drive: Array) -> tuple[float, float]:
    """Speed [m/s] and yaw rate [rad/s] that the ramps approach."""
    activity = drive[DriveColumn.ACTIVITY]
    off = drive[DriveColumn.HEADING] - estimate[OdometryColumn.HEADING]
    commanded = drive[DriveColumn.COMMANDED_SPEED]

    if activity == IDLE:
        return 0.0, 0.0
    if activity == TURN:
        return 0.0, _turn_rate(off, limits, drive)
    if activity == DRIVE:
        yaw_rate = _clip(drive[DriveColumn.COMMANDED_YAW_RATE], limits[LimitColumn.YAW_RATE])
        return _clip(commanded, limits[LimitColumn.SPEED]), yaw_rate

    speed = _clip(commanded, SETTLING_MAX_M_S if activity == STOP else limits[LimitColumn.SPEED])
    if activity != STOP:
        speed = -abs(speed) if activity == BACKWARD else abs(speed)
    # A base at rest does not chase small errors, which would look like motion.
    if speed == 0.0 and drive[DriveColumn.SPEED] == 0.0 and abs(off) < HEADING_TOLERANCE_RAD:
        return 0.0, 0.0

    return speed, _clip(HEADING_GAIN_PER_S * off, HEADING_MAX_RAD_S)


@compiled_inner
def _turn_rate(remaining: float, limits: Array, drive: Array) -> float:
    """Fastest yaw rate from which the base can still stop at the end of a turn; ends the turn when it is done."""
    if abs(remaining) < TURN_DONE_RAD and abs(drive[DriveColumn.YAW_RATE]) < TURN_DONE_RAD_S:
        drive[DriveColumn.ACTIVITY] = IDLE
        return 0.0

    # The wheels respond a step later, when the base has turned further.
    remaining -= drive[DriveColumn.YAW_RATE] * TURN_LEAD_S
    braking = math.sqrt(2 * TURN_DECELERATION_SHARE * limits[LimitColumn.YAW_ACCELERATION] * abs(remaining))
    return math.copysign(min(limits[LimitColumn.TURN_RATE], braking, TURN_GAIN_PER_S * abs(remaining)), remaining)


@compiled_inner
def _approach(value: float, target: float, step: float) -> float:
    """The value, moved towards a target by at most one step."""
    return min(target, value + step) if target > value else max(target, value - step)


@compiled_inner
def _clip(value: float, limit: float) -> float:
    """The value within plus and minus a limit."""
    return min(max(value, -limit), limit)


class BaseController:
    """Carries out move commands, one at a time; a command with a higher number replaces the present one.

    A command takes effect `RobotConfig.command_latency_s` after its arrival. A copy of the present command may carry
    another speed, which takes effect at once. Where no command arrives for `RobotConfig.cmd_timeout_s` during a move,
    or while a STOP corrects the position, the base ramps to a stop; a later copy of the command lets it continue. A
    finished turn and a STOP without a speed do not time out.

    Args:
        config: latency, limits and time-out.

    Attributes:
        number: number of the command being carried out, 0 before the first.
        limits: (9,) limits of the base, see `LimitColumn`.
        drive: (13,) state of the controller, see `DriveColumn`.
    """

    __slots__ = ("_latency_s", "_newest", "_pending", "drive", "limits", "number")

    def __init__(self, config: RobotConfig) -> None:
        self._latency_s = config.command_latency_s
        self._pending: deque[tuple[float, MoveCommand]] = deque()
        self._newest = 0
        self.number = 0

        # In the order of LimitColumn.
        self.limits = np.array(
            [
                config.max_speed_m_s,
                config.max_yaw_rate_rad_s,
                config.turn_rate_rad_s,
                config.acceleration_m_s2,
                config.yaw_acceleration_rad_s2,
                config.cmd_timeout_s,
                config.wheel_separation_m,
                config.wheel_radius_m,
                1.0 / config.odometry_hz,
            ]
        )
        self.drive = np.zeros(len(DriveColumn))
        self.drive[DriveColumn.LAST_T] = math.nan
        self.drive[DriveColumn.HEARD_T] = -math.inf

    @property
    def timed_out(self) -> bool:
        """Whether a move is stopped because no command arrived for too long."""
        return self.drive.item(DriveColumn.TIMED_OUT) > 0.0

    @property
    def blocked(self) -> bool:
        """Whether odometry has shown no motion for `STALL_S`, though a motion was commanded."""
        return self.drive.item(DriveColumn.STALLED) > STALL_S

    @property
    def wheels(self) -> WheelCommand:
        """Wheel speeds of the last control step."""
        return WheelCommand(self.drive.item(DriveColumn.LEFT_WHEEL), self.drive.item(DriveColumn.RIGHT_WHEEL))

    def receive(self, t_s: float, command: MoveCommand) -> None:
        """Accept a command, unless it is older than the newest one.

        A copy of the newest command shows that the link works, and may change the speed of the present move.

        Args:
            t_s: session time of arrival.
            command: the command.

        Raises:
            ConfigError: the move is not one that a robot can make.
        """
        if command.move not in ACTIVITIES:
            raise ConfigError("command.move", str(command.move), f"one of {', '.join(ACTIVITIES)}")
        if command.number < self._newest:
            return

        self.drive[DriveColumn.HEARD_T] = t_s
        if command.number > self._newest:
            self._newest = command.number
            self._pending.append((t_s + self._latency_s, command))
        elif self.number == command.number and self.drive[DriveColumn.ACTIVITY] != IDLE:
            self.drive[DriveColumn.COMMANDED_SPEED] = command.speed_m_s
            self.drive[DriveColumn.COMMANDED_YAW_RATE] = command.yaw_rate_rad_s

    def start_pending(self, t_s: float) -> None:
        """Start the latest command whose latency is over; `update_drive` carries it out."""
        # The tolerance lets a command start in the step at which its latency ends exactly.
        while self._pending and self._pending[0][0] <= t_s + 1e-9:
            command = self._pending.popleft()[1]
            self.number = command.number
            self.drive[DriveColumn.ACTIVITY] = ACTIVITIES[command.move]
            self.drive[DriveColumn.COMMANDED_SPEED] = command.speed_m_s
            self.drive[DriveColumn.COMMANDED_YAW_RATE] = command.yaw_rate_rad_s
            self.drive[DriveColumn.HEADING] = command.heading_rad
            self.drive[DriveColumn.NEW] = 1.0

    def update(self, state: RobotState) -> WheelCommand:
        """Take one control step.

        Args:
            state: newest odometry estimate; its time is that of the step.

        Returns:
            wheel speeds to hold until the next step.
        """
        self.start_pending(state.t_s)
        update_drive(np.array(state), self.limits, self.drive)
        return self.wheels
