"""Dispatch of robot commands: a method's actions become commands, each sent once at its time and then repeated."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable
from statistics import median

from ..choreography.layout import Layout
from ..choreography.timetable import Timetable
from ..config import RobotConfig
from ..core import ROBOT, Kind, Move, MoveCommand, RobotState
from ..core.method_io import ROBOT_MOVES, CancelCommand, MethodAction, MethodContext, ScheduleCommand, SetTimer
from ..core.session_log import Decision, Notice
from .move_planner import MIN_DURATION_S, Key, MovePlanner

SILENCE_S = 1.0
"""A robot that has sent nothing for longer than this is dead: ten reports are missing [s]."""

_NOTICE_SOURCE = "method"
"""Source of the notices about actions that no method should return."""

_NO_SUCH_STEP = "no such step"
_NO_FINITE_TIME = "no finite time"
_METHOD_ERRORS = (_NO_SUCH_STEP, _NO_FINITE_TIME)
"""Reasons of refusals that are the method's mistake; other refusals happen in every dance."""

_EXTERNAL = "ordered from outside the score"
"""Reason given for commands that come from `Dispatcher.command_move`. The dispatcher does not change their speed."""


class Dispatcher:
    """Keeps the schedule of the robot's commands, sends each when it is due, and repeats the current one.

    There is at most one scheduled command for each step. A step behind one that has been sent is ignored: the robot
    never goes back in the score. The current command is repeated under its own number at the heartbeat rate, so that a
    lost packet delays it by one interval and a silent link stops the robot. Repetitions limit how far the robot goes
    beyond the end of a move, see `MovePlanner.limit_repeated`.

    Args:
        context: steps and iterations of the dance.
        timetable: headings of the iterations.
        layout: the robot's slot.
        robot: its cruise speed, acceleration and odometry rate.
        heartbeat_hz: repetitions per second; 0 for none.

    Attributes:
        next_due_s: session time at which `due_commands` or `due_timers` is to be called next [s]; infinite for never.
        decisions: outcome of every action, for the log.
        notices: a dead robot, and actions that no method should return.
    """

    def __init__(
        self, context: MethodContext, timetable: Timetable, layout: Layout, robot: RobotConfig, heartbeat_hz: float
    ) -> None:
        self._context = context
        self._timetable = timetable
        self._planner = MovePlanner(context, timetable, layout, robot)
        self._steps = {step.ordinal: step for step in context.steps}

        self._pending: dict[Key, ScheduleCommand] = {}
        self._sent_s: dict[Key, float] = {}
        self._last_sent: Key = (-1, -1)
        self._timers_s: list[float] = []

        self._current: MoveCommand | None = None
        self._repeat_interval_s = 1.0 / heartbeat_hz if heartbeat_hz else math.inf
        self._repeat_due_s = math.inf
        self._pending_due_s = math.inf

        self._last_report_s = 0.0
        self._is_alive = True
        self._noticed: set[str] = set()
        self.next_due_s = math.inf
        self.decisions: list[Decision] = []
        self.notices: list[Notice] = []

    @property
    def current(self) -> MoveCommand | None:
        """The command in force, or None before the first one."""
        return self._current

    @property
    def state(self) -> RobotState | None:
        """The robot's latest odometry, or None before the first."""
        return self._planner.state

    def update_robot_state(self, t_arrival_s: float, state: RobotState) -> None:
        """Record the robot's odometry. A report that a later one has overtaken only shows that the robot is alive."""
        self._last_report_s = t_arrival_s
        if not self._is_alive:
            self._is_alive = True
            self.notices.append(Notice(t_arrival_s, ROBOT, "robot is back"))

        # Reports may overtake one another on the link.
        latest = self._planner.state
        if latest is None or state.t_s >= latest.t_s:
            self._planner.state = state

    def check_robot_alive(self, t_s: float) -> None:
        """Add a notice if the robot has been silent for more than `SILENCE_S` at session time ``t_s``."""
        if self._is_alive and t_s - self._last_report_s > SILENCE_S:
            self._is_alive = False
            self.notices.append(Notice(t_s, ROBOT, f"robot is dead: silent for more than {SILENCE_S:g} s"))

    def handle(self, t_s: float, actions: Iterable[MethodAction]) -> None:
        """Handle a method's actions, returned at session time ``t_s``.

        A command for a step that does not exist, that has been sent, or that lies behind a sent one is logged as
        ``ignored``; so is one without a finite time. What no method should ask for also leaves a notice, one for each
        reason. A timer comes after ``t_s`` at the earliest, so that a timer that sets the next one cannot hold up the
        session.
        """
        for action in actions:
            if isinstance(action, SetTimer):
                heapq.heappush(self._timers_s, max(action.t_s, math.nextafter(t_s, math.inf)))
            elif isinstance(action, CancelCommand):
                self._cancel(t_s, action)
            else:
                self._schedule(t_s, action)
        self._update_due()

    def command_move(self, t_s: float, move: Move, speed_m_s: float = 0.0, yaw_rate_rad_s: float = 0.0) -> None:
        """Put a command in force that no method has scheduled; the next `due_commands` sends it.

        Nothing is refused: a move may be repeated, or contradict the score. Speed and heading are those of the nearest
        step of the dance with this move, and that step counts as sent.

        Args:
            t_s: session time of the command [s].
            move: what to do.
            speed_m_s: speed of `Move.DRIVE` [m/s].
            yaw_rate_rad_s: yaw rate of `Move.DRIVE` [rad/s].
        """
        # The log and the robot's events need a step, although no method has scheduled one.
        key = self._nearest_step(t_s, move)
        self._put_in_force(t_s, key, move, _EXTERNAL, (speed_m_s, yaw_rate_rad_s))
        self._repeat_due_s = t_s
        self._update_due()

    def due_timers(self, t_s: float) -> list[float]:
        """Remove and return the timers that are due by ``t_s``, earliest first [s]."""
        due_s: list[float] = []
        while self._timers_s and self._timers_s[0] <= t_s:
            due_s.append(heapq.heappop(self._timers_s))
        self._update_due()
        return due_s

    def due_commands(self, t_s: float) -> list[MoveCommand]:
        """Commands that go to the robot by ``t_s``: new ones in the order of the score, else a repetition if due."""
        commands: list[MoveCommand] = []
        if self._pending_due_s <= t_s:
            for key in sorted(key for key, item in self._pending.items() if item.t_s <= t_s):
                item = self._pending.pop(key)
                # A step that was valid when it was scheduled may have been overtaken since.
                refusal = self._refusal(key)
                if refusal:
                    self._log(t_s, key, "ignored", item, refusal)
                else:
                    commands.append(self._send(t_s, key, item))

        if not commands and self._repeat_due_s <= t_s and self._current is not None:
            if self._current.why != _EXTERNAL:
                self._current = self._planner.limit_repeated(self._current)
            commands.append(self._current)
            self._repeat_due_s = t_s + self._repeat_interval_s

        self._update_due()
        return commands

    def _update_due(self) -> None:
        """Recompute when something is due next."""
        self._pending_due_s = min([item.t_s for item in self._pending.values()], default=math.inf)
        timer_s = self._timers_s[0] if self._timers_s else math.inf
        self.next_due_s = min(self._pending_due_s, self._repeat_due_s, timer_s)

    def _schedule(self, t_s: float, item: ScheduleCommand) -> None:
        """Schedule a command, or replace the scheduled one of the same step."""
        key = (item.iteration, item.ordinal)
        refusal = self._refusal(key) or ("" if math.isfinite(item.t_s) else _NO_FINITE_TIME)
        if refusal:
            self._log(t_s, key, "ignored", item, refusal)
            self._report_method_error(t_s, key, refusal, f"command at {item.t_s:g} s")
            return
        action = "replaced" if key in self._pending else "scheduled"
        self._pending[key] = item
        self._log(t_s, key, action, item)

    def _cancel(self, t_s: float, item: CancelCommand) -> None:
        """Remove the scheduled command of a step."""
        key = (item.iteration, item.ordinal)
        pending = self._pending.pop(key, None)
        if pending is None:
            self._log(t_s, key, "ignored", ScheduleCommand(*key, t_s, item.why), "nothing to withdraw")
            self._report_method_error(t_s, key, self._refusal(key), "cancellation")
        else:
            self._log(t_s, key, "withdrawn", ScheduleCommand(*key, pending.t_s, item.why, pending.person))

    def _report_method_error(self, t_s: float, key: Key, refusal: str, what: str) -> None:
        """Add a notice of an action that no method should return, once for each reason."""
        if refusal not in _METHOD_ERRORS or refusal in self._noticed:
            return
        self._noticed.add(refusal)

        text = f"{what} for iteration {key[0]}, ordinal {key[1]} ignored: {refusal}"
        if refusal == _NO_SUCH_STEP:
            text += f" (iterations 1 to {self._context.iterations}, ordinals 0 to {len(self._steps) - 1})"
        self.notices.append(Notice(t_s, _NOTICE_SOURCE, f"{text}; further ones only in the decisions"))

    def _refusal(self, key: Key) -> str:
        """Why a step cannot be commanded, or "" if it can."""
        if key[1] not in self._steps or not 1 <= key[0] <= self._context.iterations:
            return _NO_SUCH_STEP
        if key in self._sent_s:
            return "already sent"
        return "a later step has been sent" if key < self._last_sent else ""

    def _send(self, t_s: float, key: Key, item: ScheduleCommand) -> MoveCommand:
        """The command of a step that is due; it becomes the current one."""
        command = self._put_in_force(t_s, key, ROBOT_MOVES[self._steps[key[1]].kind], item.why)
        self._last_sent = key
        self._repeat_due_s = t_s + self._repeat_interval_s
        self._log(t_s, key, "sent", item)
        return command

    def _put_in_force(
        self, t_s: float, key: Key, move: Move, why: str, drive: tuple[float, float] = (0.0, 0.0)
    ) -> MoveCommand:
        """Make a command the current one; ``drive`` are speed [m/s] and yaw rate [rad/s] of `Move.DRIVE`."""
        if move is Move.DRIVE:
            speed_m_s = drive[0]
        elif move in (Move.FORWARD, Move.BACKWARD):
            speed_m_s = self._planner.speed_m_s(move, key[0], self._expected_duration_s(key, t_s))
        else:
            speed_m_s = 0.0

        command = MoveCommand(
            number=1 if self._current is None else self._current.number + 1,
            move=move,
            t_start_s=t_s,
            speed_m_s=speed_m_s,
            heading_rad=self._planner.heading_rad(key, move),
            iteration=key[0],
            ordinal=key[1],
            why=why,
            yaw_rate_rad_s=drive[1],
        )
        self._current = command
        if move is not Move.DRIVE:
            self._sent_s[key] = t_s
        return command

    def _nearest_step(self, t_s: float, move: Move) -> Key:
        """The step nearest in time that has this move; for a move that no step has, the nearest step."""
        steps = [step for step in self._context.steps if ROBOT_MOVES[step.kind] is move] or self._context.steps
        return min(
            ((iteration, step.ordinal) for iteration in range(1, self._context.iterations + 1) for step in steps),
            key=lambda key: abs(self._timetable.time_s(key[0], self._steps[key[1]].beat) - t_s),
        )

    def _expected_duration_s(self, key: Key, t_s: float) -> float:
        """Expected time from a step's command, sent at ``t_s``, to the next step's command [s].

        This is the time that the method has scheduled, unless it is a last resort. Without it, it is the median of the
        score's duration and those of earlier iterations. At most twice the score's duration is expected.
        """
        iteration, ordinal = key
        nominal_s = self._planner.nominal_duration_s(key)
        following = self._pending.get((iteration, ordinal + 1))
        if following is not None and not following.last_resort:
            return max(MIN_DURATION_S, min(following.t_s - t_s, 2.0 * nominal_s))

        durations_s = [nominal_s]
        for earlier in range(1, iteration):
            start_s = self._sent_s.get((earlier, ordinal))
            stop_s = self._sent_s.get((earlier, ordinal + 1))
            if start_s is not None and stop_s is not None:
                durations_s.append(stop_s - start_s)
        return max(MIN_DURATION_S, min(median(durations_s), 2.0 * nominal_s))

    def _log(self, t_s: float, key: Key, action: str, item: ScheduleCommand, refusal: str = "") -> None:
        """Add a row to the decision log."""
        step = self._steps.get(key[1])
        # An unknown step has no kind; the log's column needs one.
        kind = step.kind if step is not None else Kind.TURN
        why = f"{refusal}: {item.why}" if refusal else item.why
        self.decisions.append(Decision(t_s, key[0], key[1], kind, action, item.t_s, item.person, why))
