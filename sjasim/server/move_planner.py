"""Speed and heading of the robot's moves, chosen so that the robot returns to its slot."""

from __future__ import annotations

import math
from dataclasses import replace

from ..choreography.layout import Layout
from ..choreography.timetable import Timetable
from ..config import RobotConfig
from ..core import Move, MoveCommand, RobotState
from ..core.method_io import ROBOT_MOVES, MethodContext

MIN_SPEED_M_S = 0.15
"""Slowest corrected cruise [m/s] (assumed); a slower move is hardly visible as one."""

MAX_SPEED_M_S = 0.40
"""Fastest corrected cruise [m/s] (assumed); a faster move takes too long to accelerate."""

CRAWL_M_S = 0.13
"""Speed of a move that has passed its end and has not been stopped [m/s] (assumed).

Odometry still counts it as a move (from .10 m/s), and the robot goes as little farther as possible.
"""

CRAWL_FROM_M = 0.05
"""Distance beyond its end from which a move slows down to `CRAWL_M_S` [m] (assumed)."""

HALT_FROM_M = 0.17
"""Distance beyond the end of a move at which the robot stops, independently of the method [m] (assumed). It prevents a
collision with a dancer in the neighbouring slot."""

REPOSITION_FROM_M = 0.10
"""Distance from the nominal end of the last move from which a stopped robot drives there [m] (assumed)."""

REPOSITION_M_S = 0.08
"""Speed at which it does so [m/s] (assumed); slow enough that odometry does not count it as a move (.10 m/s)."""

STEER_GAIN = 1.0
"""Share of a lateral error that the next move is turned to correct (assumed)."""

MAX_STEER_RAD = 0.45
"""Largest such turn [rad] (assumed)."""

MIN_DURATION_S = 0.5
"""Shortest duration that a move is planned for [s]."""

Key = tuple[int, int]
"""Iteration and ordinal of a step."""


class MovePlanner:
    """Plans speed and heading of the robot's moves from its odometry.

    A forward move ends at its nominal end, a backward move on the robot's slot. Both are turned off the iteration's
    heading to correct a lateral error.

    Args:
        context: steps and iterations of the dance.
        timetable: headings of the iterations, and beats of the steps.
        layout: the robot's slot.
        robot: cruise speed, acceleration and odometry rate of the robot.

    Attributes:
        state: the robot's latest odometry, or None before the first.
    """

    def __init__(self, context: MethodContext, timetable: Timetable, layout: Layout, robot: RobotConfig) -> None:
        self._steps = {step.ordinal: step for step in context.steps}
        self._timetable = timetable
        self._slot_m = (float(layout.robot[0]), float(layout.robot[1]))
        self._robot = robot
        self.state: RobotState | None = None

    def nominal_duration_s(self, key: Key) -> float:
        """Time from a step to the next one by the score [s]; `MIN_DURATION_S` for the last step."""
        iteration, ordinal = key
        following = self._steps.get(ordinal + 1)
        if following is None:
            return MIN_DURATION_S

        start_s = self._timetable.time_s(iteration, self._steps[ordinal].beat)
        return self._timetable.time_s(iteration, following.beat) - start_s

    def speed_m_s(self, move: Move, iteration: int, duration_s: float) -> float:
        """Cruise speed of a move, so that it ends where it should after a given time [m/s].

        With equal limits on speeding up and slowing down, a move covers speed times duration, whatever the
        acceleration.

        Args:
            move: `Move.FORWARD` or `Move.BACKWARD`.
            iteration: which iteration.
            duration_s: expected time from this command to the next one [s].
        """
        correction_m_s = self._ahead_m(iteration) / duration_s
        speed = self._robot.cruise_m_s - correction_m_s if move is Move.FORWARD else correction_m_s
        return min(max(speed, MIN_SPEED_M_S), MAX_SPEED_M_S, self._robot.max_speed_m_s)

    def heading_rad(self, key: Key, move: Move) -> float:
        """Heading of a command [rad].

        A turn ends at the next iteration's heading, exactly. A stop takes the heading of the move to come, so that
        the robot is aligned before it starts.
        """
        iteration, ordinal = key
        if move is Move.TURN:
            return float(self._timetable.heading_rad(iteration + 1))

        heading_rad = float(self._timetable.heading_rad(iteration))
        step = self._steps.get(ordinal + 1 if move is Move.STOP else ordinal)
        if step is None:
            return heading_rad
        return heading_rad + self._steer_rad(heading_rad, ROBOT_MOVES[step.kind], (iteration, step.ordinal))

    def limit_repeated(self, command: MoveCommand) -> MoveCommand:
        """The command as it is repeated now, with a speed that keeps the robot near the nominal end of its move.

        A move that nobody stops slows down beyond its end and soon halts: one lost stop would otherwise take the
        robot a metre away from its slot. A stop that came too soon or too late drives the robot slowly to where its
        move should have ended: after a dancer whose step was half as long the robot is that far off, and no cruise
        speed could have known it.
        """
        remaining_m = self._remaining_m(command)
        if command.move is Move.STOP:
            speed = math.copysign(REPOSITION_M_S, remaining_m) if abs(remaining_m) > REPOSITION_FROM_M else 0.0
            return replace(command, speed_m_s=speed)

        overshoot_m = -remaining_m if command.move is Move.FORWARD else remaining_m
        if command.move is Move.TURN or command.speed_m_s == 0.0 or overshoot_m <= CRAWL_FROM_M:
            return command
        return replace(command, speed_m_s=CRAWL_M_S if overshoot_m < HALT_FROM_M else 0.0)

    def _steer_rad(self, heading_rad: float, move: Move, key: Key) -> float:
        """Angle by which a move is turned off the iteration's heading, counter-clockwise positive [rad].

        A robot to the left of its lane steers right when it moves forward. When it moves backward it turns left, for
        it then travels against its heading. 0 for other moves, and before the first odometry.
        """
        if move not in (Move.FORWARD, Move.BACKWARD) or self.state is None:
            return 0.0
        x_m = self.state.x_m - self._slot_m[0]
        y_m = self.state.y_m - self._slot_m[1]
        left_m = y_m * math.cos(heading_rad) - x_m * math.sin(heading_rad)
        length_m = self._robot.cruise_m_s * self.nominal_duration_s(key)

        steer_rad = min(max(STEER_GAIN * left_m / length_m, -MAX_STEER_RAD), MAX_STEER_RAD)
        return steer_rad if move is Move.BACKWARD else -steer_rad

    def _remaining_m(self, command: MoveCommand) -> float:
        """How far ahead of the robot its move should end, or should have ended [m]; negative behind it.

        0 for turns, for moves that no step of the dance has, and for a stop that no such move precedes.
        """
        start = self._steps.get(command.ordinal - (command.move is Move.STOP))
        move = ROBOT_MOVES[start.kind] if start is not None else Move.STOP

        if move is Move.FORWARD:
            assert start is not None
            end_m = self._robot.cruise_m_s * self.nominal_duration_s((command.iteration, start.ordinal))
        elif move is Move.BACKWARD:
            end_m = 0.0
        else:
            return 0.0
        return end_m - self._ahead_m(command.iteration)

    def _ahead_m(self, iteration: int) -> float:
        """Where the robot will have come to rest if it brakes now, along the iteration's heading from its slot [m]."""
        state = self.state
        if state is None:
            return 0.0
        heading = self._timetable.heading_rad(iteration)
        x_m = state.x_m - self._slot_m[0]
        y_m = state.y_m - self._slot_m[1]
        ahead_m = x_m * math.cos(heading) + y_m * math.sin(heading)

        # Braking distance v^2 / 2a, with the sign of the motion.
        speed = state.step_m * self._robot.odometry_hz
        return ahead_m + speed * abs(speed) / (2.0 * self._robot.acceleration_m_s2)
