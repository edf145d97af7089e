"""From move commands to wheel speeds: dead time, ramps, straight lines, turns that end where they should.

The executor knows odometry only. It runs at the odometry's rate and takes every interval from the stamps.
"""

from __future__ import annotations

import math
from collections import deque

from ..config import RobotConfig
from ..errors import ConfigError
from ..types import Move, MoveCommand, RobotState, WheelCommand
from .diff_drive import wheel_command

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

EXECUTABLE = (Move.FORWARD, Move.BACKWARD, Move.STOP, Move.TURN, Move.DRIVE)


class Executor:
    """Carries out move commands, one at a time; a higher number replaces a lower one after its own dead time.

    A copy of the one under way may carry another speed, which is taken at once. A base that hears nothing for
    ``command_timeout_s`` during a move, or while it settles after a stop, ramps to a stop; a copy of the command that
    arrives later lets it go on. A finished turn and a mere stop have nothing to time out.

    Attributes:
        number: of the command being carried out, 0 before the first.

    Args:
        config: dead time, limits and time-out.
    """

    __slots__ = (
        "_command", "_config", "_heading_ref", "_heard", "_newest", "_speed", "_stalled", "_t", "_timed_out",
        "_waiting", "_yaw", "number",
    )  # fmt: skip

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self._waiting: deque[tuple[float, MoveCommand]] = deque()
        self._command: MoveCommand | None = None
        self._newest = self.number = 0
        self._heard = -math.inf
        self._heading_ref = math.nan
        self._speed = self._yaw = self._stalled = 0.0
        self._t = math.nan
        self._timed_out = False

    @property
    def timed_out(self) -> bool:
        """Whether a move is being held up because nothing was heard for too long."""
        return self._timed_out

    @property
    def blocked(self) -> bool:
        """Whether the base has been told to move for half a second and its own odometry says that it does not."""
        return self._stalled > STALL_S

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
        self._heard = t_s
        if command.number > self._newest:
            self._newest = command.number
            self._waiting.append((t_s + self._config.dead_time_s, command))
        elif self._command is not None and self._command.number == command.number:
            self._command = command

    def update(self, state: RobotState) -> WheelCommand:
        """One control tick.

        Args:
            state: the newest odometry sample; its stamp is the tick's time.

        Returns:
            wheel speeds to hold until the next tick.
        """
        config = self._config
        t = state.t_s
        interval = t - self._t if not math.isnan(self._t) else 1.0 / config.odometry_hz
        interval = min(interval, LONGEST_STEP_S)
        self._t = t
        self._judge(state, interval)
        while self._waiting and self._waiting[0][0] <= t + 1e-9:
            self._begin(self._waiting.popleft()[1], state.heading_rad)
        self._timed_out = (
            self._command is not None
            and not (self._command.move is Move.STOP and self._command.speed_m_s == 0.0)
            and t - self._heard > config.command_timeout_s
        )
        speed, yaw = self._wanted(state)
        self._speed = _toward(self._speed, speed, config.acceleration_m_s2 * interval)
        self._yaw = _toward(self._yaw, yaw, config.yaw_acceleration_rad_s2 * interval)
        return wheel_command(self._speed, self._yaw, config)

    def _begin(self, command: MoveCommand, heading: float) -> None:
        self._command = command
        self.number = command.number
        if command.move is Move.TURN:
            self._heading_ref = command.heading_rad
        else:
            near = abs(command.heading_rad - heading) <= HOLD_REACH_RAD
            self._heading_ref = command.heading_rad if near else heading

    def _wanted(self, state: RobotState) -> tuple[float, float]:
        """Speed and yaw rate that the ramps should go for."""
        command = self._command
        if command is None or self._timed_out:
            return 0.0, 0.0
        if command.move is Move.TURN:
            return 0.0, self._turn_rate(state)
        if command.move is Move.DRIVE:
            most, fastest = self._config.max_speed_m_s, self._config.max_yaw_rate_rad_s
            return min(max(command.speed_m_s, -most), most), min(max(command.yaw_rate_rad_s, -fastest), fastest)
        most = SETTLE_MAX_M_S if command.move is Move.STOP else self._config.max_speed_m_s
        speed = min(max(command.speed_m_s, -most), most)
        if command.move is not Move.STOP:
            speed = -abs(speed) if command.move is Move.BACKWARD else abs(speed)
        off = self._heading_ref - state.heading_rad
        if speed == 0.0 and self._speed == 0.0 and abs(off) < AIMED_RAD:
            return 0.0, 0.0
        hold = HOLD_PER_S * off
        return speed, min(max(hold, -HOLD_MAX_RAD_S), HOLD_MAX_RAD_S)

    def _turn_rate(self, state: RobotState) -> float:
        """Yaw rate from which the rest of the turn can just be braked; ends the turn when it is done."""
        left = self._heading_ref - state.heading_rad
        if abs(left) < TURN_DONE_RAD and abs(self._yaw) < TURN_DONE_RAD_S:
            self._command = None
            return 0.0
        left -= self._yaw * TURN_LEAD_S
        brake = math.sqrt(2 * TURN_EASE * self._config.yaw_acceleration_rad_s2 * abs(left))
        return math.copysign(min(self._config.turn_rate_rad_s, brake, TURN_PER_S * abs(left)), left)

    def _judge(self, state: RobotState, interval: float) -> None:
        """Compare the command in force since the last tick with what odometry felt meanwhile."""
        if abs(self._speed) >= STALL_M_S:
            stuck = abs(state.step_m) < STALL_SHARE * abs(self._speed) * interval
        elif abs(self._yaw) >= STALL_RAD_S:
            stuck = abs(state.yaw_rate_rad_s) < STALL_SHARE * abs(self._yaw)
        else:
            stuck = False
        self._stalled = self._stalled + interval if stuck else 0.0


def _toward(value: float, target: float, step: float) -> float:
    return min(target, value + step) if target > value else max(target, value - step)
