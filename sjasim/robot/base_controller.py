"""From move commands to wheel speeds: dead time, ramps, straight lines, turns that end where they should.

The executor knows odometry only. It runs at the odometry's rate and takes every interval from the stamps. Its rules
are compiled functions over small arrays (`steer` is a tick of them); the class holds these arrays and hears commands.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numba import njit

from ..config import RobotConfig
from ..core import Array, Move, MoveCommand, RobotState, WheelCommand
from ..core.errors import ConfigError
from .diff_drive import wheel_speeds
from .odometry import HEADING, RATE, STEP, T

HOLD_PER_S = 2.0
"""Yaw rate per radian of heading error on a straight move; assumed."""

HOLD_MAX_RAD_S = 0.35
"""Bound of that yaw rate: below the rate that counts as a turn; assumed."""

AIMED_RAD = 0.02
"""A standing robot this close to the heading it is to take up lets it be; assumed."""

HOLD_REACH_RAD = 1.2
"""A move or a stop takes up the heading it is given if no farther off than this, else it keeps its own; assumed."""

TURN_PER_S = 10.0
"""Yaw rate per radian at the end of a turn, where the square-root profile would be infinitely steep; assumed."""

TURN_EASE = 0.9
"""Share of the yaw acceleration that a turn's deceleration is planned with, so that the limit is never met."""

TURN_LEAD_S = 0.02
"""How far ahead of the last sample the wheels will answer: one control tick."""

TURN_DONE_RAD = math.radians(0.2)
"""A turn is over when its heading is reached this closely and the rate below has been reached; assumed."""

TURN_DONE_RAD_S = 0.05

STALL_S = 0.5
"""Time without motion, though motion is commanded, after which the robot counts as blocked; assumed."""

STALL_SHARE = 0.25
"""Less than this share of the commanded speed counts as no motion; assumed."""

STALL_M_S, STALL_RAD_S = 0.05, 0.2
"""Commands slower than these are never judged."""

LONGEST_STEP_S = 0.1
"""Ramps never take a longer stride than this after a gap in the samples; assumed."""

SETTLE_MAX_M_S = 0.09
"""Fastest that a robot told to stop may settle at: no move to odometry (.10 m/s)."""

NOTHING, STOP, FORWARD, BACKWARD, TURN, DRIVE = range(6)
"""What the base is doing; nothing before the first command and after a turn."""

EXECUTABLE = {Move.FORWARD: FORWARD, Move.BACKWARD: BACKWARD, Move.STOP: STOP, Move.TURN: TURN, Move.DRIVE: DRIVE}

TOP, SPIN, TURN_RATE, PER_S, YAW_PER_S, PATIENCE_S, TRACK_M, RADIUS_M, INTERVAL_S = range(9)
"""A base's limits: speed, yaw rate and yaw rate of a turn; accelerations; time-out; track, wheel radius; interval."""

(
    SPEED, YAW, LEFT_WHEEL, RIGHT_WHEEL, LAST_T, STALLED, TIMED_OUT, HEARD, MOVE, ORDERED, ORDERED_YAW, AIM, FRESH,
) = range(13)  # fmt: skip
"""What an executor is at: ramped speed [m/s] and yaw rate [rad/s], and the wheel speeds for them [rad/s]; time of the
last tick, how long it has been stuck [s]; whether nothing was heard for too long, and when it was [s]; the move under
way, its speed and, of DRIVE, its yaw rate; the heading it holds or turns to, and whether that still is as ordered."""


@njit(cache=True)
def steer(belief: Array, limits: Array, work: Array) -> None:
    """One control tick; see `BaseController`.

    Args:
        belief: the newest odometry sample, columns of `types.RobotState`; its stamp is the tick's time.
        limits: of the base.
        work: what the executor is at, in and out.
    """
    t = belief[T]
    interval = t - work[LAST_T] if not math.isnan(work[LAST_T]) else limits[INTERVAL_S]
    interval = min(interval, LONGEST_STEP_S)
    work[LAST_T] = t
    work[STALLED] = work[STALLED] + interval if _stuck(belief, interval, work) else 0.0
    if work[FRESH] > 0.0:
        work[FRESH] = 0.0
        if work[MOVE] != TURN and abs(work[AIM] - belief[HEADING]) > HOLD_REACH_RAD:
            work[AIM] = belief[HEADING]
    under_way = work[MOVE] > STOP or (work[MOVE] == STOP and work[ORDERED] != 0.0)
    late = under_way and t - work[HEARD] > limits[PATIENCE_S]
    work[TIMED_OUT] = 1.0 if late else 0.0
    speed, yaw = (0.0, 0.0) if late else _wanted(belief, limits, work)
    work[SPEED] = _toward(work[SPEED], speed, limits[PER_S] * interval)
    work[YAW] = _toward(work[YAW], yaw, limits[YAW_PER_S] * interval)
    work[LEFT_WHEEL], work[RIGHT_WHEEL] = wheel_speeds(
        work[SPEED], work[YAW], limits[TOP], limits[SPIN], limits[TRACK_M], limits[RADIUS_M]
    )


@njit(cache=True)
def _stuck(belief: Array, interval: float, work: Array) -> bool:
    """Compare the command in force since the last tick with what odometry felt meanwhile."""
    speed, yaw = abs(work[SPEED]), abs(work[YAW])
    if speed >= STALL_M_S:
        return bool(abs(belief[STEP]) < STALL_SHARE * speed * interval)
    return bool(yaw >= STALL_RAD_S and abs(belief[RATE]) < STALL_SHARE * yaw)


@njit(cache=True)
def _wanted(belief: Array, limits: Array, work: Array) -> tuple[float, float]:
    """Speed and yaw rate that the ramps should go for."""
    move, off = work[MOVE], work[AIM] - belief[HEADING]
    if move == NOTHING:
        return 0.0, 0.0
    if move == TURN:
        return 0.0, _turn_rate(off, limits, work)
    if move == DRIVE:
        return _limited(work[ORDERED], limits[TOP]), _limited(work[ORDERED_YAW], limits[SPIN])
    speed = _limited(work[ORDERED], SETTLE_MAX_M_S if move == STOP else limits[TOP])
    if move != STOP:
        speed = -abs(speed) if move == BACKWARD else abs(speed)
    if speed == 0.0 and work[SPEED] == 0.0 and abs(off) < AIMED_RAD:
        return 0.0, 0.0
    return speed, _limited(HOLD_PER_S * off, HOLD_MAX_RAD_S)


@njit(cache=True)
def _turn_rate(left: float, limits: Array, work: Array) -> float:
    """Yaw rate from which the rest of the turn can just be braked; ends the turn when it is done."""
    if abs(left) < TURN_DONE_RAD and abs(work[YAW]) < TURN_DONE_RAD_S:
        work[MOVE] = NOTHING
        return 0.0
    left -= work[YAW] * TURN_LEAD_S
    brake = math.sqrt(2 * TURN_EASE * limits[YAW_PER_S] * abs(left))
    return math.copysign(min(limits[TURN_RATE], brake, TURN_PER_S * abs(left)), left)


@njit(cache=True)
def _toward(value: float, target: float, step: float) -> float:
    return min(target, value + step) if target > value else max(target, value - step)


@njit(cache=True)
def _limited(value: float, most: float) -> float:
    return min(max(value, -most), most)


class BaseController:
    """Carries out move commands, one at a time; a higher number replaces a lower one after its own dead time.

    A copy of the one under way may carry another speed, which is taken at once. A base that hears nothing for
    ``cmd_timeout_s`` during a move, or while it settles after a stop, ramps to a stop; a copy of the command that
    arrives later lets it go on. A finished turn and a mere stop have nothing to time out.

    Args:
        config: dead time, limits and time-out.

    Attributes:
        number: of the command being carried out, 0 before the first.
        limits: of the base, for `steer`.
        work: what it is at, for `steer`.
    """

    __slots__ = ("_dead_time_s", "_newest", "_waiting", "limits", "number", "work")

    def __init__(self, config: RobotConfig) -> None:
        c = config
        self._dead_time_s = c.command_latency_s
        self._waiting: deque[tuple[float, MoveCommand]] = deque()
        self._newest = self.number = 0
        self.limits = np.array([
            c.max_speed_m_s, c.max_yaw_rate_rad_s, c.turn_rate_rad_s, c.acceleration_m_s2, c.yaw_acceleration_rad_s2,
            c.cmd_timeout_s, c.wheel_separation_m, c.wheel_radius_m, 1.0 / c.odometry_hz,
        ])  # fmt: skip
        self.work = np.zeros(13)
        self.work[LAST_T], self.work[HEARD] = math.nan, -math.inf

    @property
    def timed_out(self) -> bool:
        """Whether a move is being held up because nothing was heard for too long."""
        return self.work.item(TIMED_OUT) > 0.0

    @property
    def blocked(self) -> bool:
        """Whether the base has been told to move for half a second and its own odometry says that it does not."""
        return self.work.item(STALLED) > STALL_S

    def receive(self, t_s: float, command: MoveCommand) -> None:
        """Hear a command; an older one is ignored.

        A copy of the newest shows that the link lives, and may change the speed of the move under way.

        Args:
            t_s: session time of arrival.
            command: what to do.

        Raises:
            ConfigError: the move is not one that a robot can make.
        """
        if command.move not in EXECUTABLE:
            raise ConfigError("command.move", str(command.move), f"one of {', '.join(EXECUTABLE)}")
        if command.number < self._newest:
            return
        self.work[HEARD] = t_s
        if command.number > self._newest:
            self._newest = command.number
            self._waiting.append((t_s + self._dead_time_s, command))
        elif self.number == command.number and self.work[MOVE] != NOTHING:
            self.work[ORDERED], self.work[ORDERED_YAW] = command.speed_m_s, command.yaw_rate_rad_s

    def take_up(self, t_s: float) -> None:
        """Let the latest command whose dead time is over be the one that the next `steer` carries out."""
        while self._waiting and self._waiting[0][0] <= t_s + 1e-9:
            command = self._waiting.popleft()[1]
            self.number = command.number
            self.work[MOVE:] = (
                EXECUTABLE[command.move], command.speed_m_s, command.yaw_rate_rad_s, command.heading_rad, 1.0,
            )  # fmt: skip

    def update(self, state: RobotState) -> WheelCommand:
        """One control tick.

        Args:
            state: the newest odometry sample; its stamp is the tick's time.

        Returns:
            wheel speeds to hold until the next tick.
        """
        self.take_up(state.t_s)
        steer(np.array(state), self.limits, self.work)
        return WheelCommand(self.work.item(LEFT_WHEEL), self.work.item(RIGHT_WHEEL))
