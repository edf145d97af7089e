"""The server's hand: a method's answers become robot commands, each sent once, at its time, and kept alive."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable
from dataclasses import replace
from statistics import median

from ..choreography.layout import Layout
from ..choreography.timetable import Timetable
from ..config import RobotConfig
from ..core import ROBOT, Kind, Move, MoveCommand, RobotState
from ..core.method_io import CancelCommand, MethodAction, MethodContext, ScheduleCommand, SetTimer
from ..core.session_log import Decision, Notice

ROBOT_MOVES = {
    Kind.START_FORWARD: Move.FORWARD,
    Kind.STOP_FORWARD: Move.STOP,
    Kind.START_BACKWARD: Move.BACKWARD,
    Kind.STOP_BACKWARD: Move.STOP,
    Kind.CLAP: Move.TURN,
    Kind.TURN: Move.TURN,
}
"""The robot's move for each of the dance's events; it turns where dancers clap (iqbal2016, section II-C)."""

SPEED_M_S = (0.15, 0.40)
"""Slowest and fastest cruise of a corrected move [m/s]: slower is hardly seen as a move, faster starts too late."""

CRAWL_M_S = 0.13
"""Speed of a move that has reached its end and not been stopped: still a move to odometry (.10 m/s), and as little
farther off as possible; assumed."""

PAST_M = 0.05
"""So far past its end a move begins to crawl (assumed)."""

HALT_M = 0.17
"""And so far past it the server halts it, whatever the method says: the next place is somebody else's (assumed)."""

SETTLE_M, SETTLE_M_S = 0.10, 0.08
"""Standing farther than this from where its move should have ended, the robot settles there, at a speed that is no move
to odometry (.10 m/s); assumed."""

STEER, STEER_MAX_RAD = 1.0, 0.45
"""Share of a sideways error that the next move is turned to make good, and by how much at most (assumed)."""

METHOD = "method"
"""Source of the notices of what a method should not have asked for."""

NO_STEP, NO_TIME = "no such step", "no finite time"
"""Why an answer is ignored that no method should give."""

ORDERED = "ordered from outside the score"
"""Why a command came that no method asked for; the server does not interfere with those."""

SHORTEST_S = 0.5
"""Shortest duration a move is planned for [s]."""

SILENCE_S = 1.0
"""A robot that says nothing for so long is dead: ten reports missed."""

Key = tuple[int, int]
"""Iteration and ordinal."""


class Dispatcher:
    """Keeps at most one pending intention per step, sends each step once, and repeats the current command.

    A step behind one that has been sent is ignored: the robot never goes back in the score. The current command
    is repeated with its own number at the heartbeat's rate, so that a lost packet costs one beat and a silent link
    stops the base; a standing robot hears STOP repeated. The copies of a move that nobody stops slow it down to a
    crawl where it should have ended, and soon halt it, or else one lost stop would leave the robot a metre from its
    slot. Those of a stop that came too soon or too late let it settle where its move should have ended: whoever
    follows a dancer whose step was half as long is that far off, and no speed could have known.

    Args:
        context: the dance.
        timetable: headings of the iterations.
        layout: the robot's slot.
        robot: its cruise speed, acceleration and odometry rate.
        heartbeat_hz: repetitions per second.
    """

    def __init__(
        self, context: MethodContext, timetable: Timetable, layout: Layout, robot: RobotConfig, heartbeat_hz: float
    ) -> None:
        self._context = context
        self._timetable = timetable
        self._slot = (float(layout.robot[0]), float(layout.robot[1]))
        self._robot = robot
        self._beat_s = 1.0 / heartbeat_hz
        self._steps = {step.ordinal: step for step in context.steps}
        self._pending: dict[Key, ScheduleCommand] = {}
        self._sent_s: dict[Key, float] = {}
        self._last: Key = (-1, -1)
        self._wakes: list[float] = []
        self._current: MoveCommand | None = None
        self._repeat_s = math.inf
        self._pending_s = math.inf
        self._state: RobotState | None = None
        self._heard_s = 0.0
        self._alive = True
        self._noticed: set[str] = set()
        self.next_due_s = math.inf
        """Session time at which `due_commands` or `due_timers` has something to do; infinite for never."""
        self.decisions: list[Decision] = []
        self.notices: list[Notice] = []

    @property
    def current(self) -> MoveCommand | None:
        """The command in force, or None before the first one."""
        return self._current

    @property
    def state(self) -> RobotState | None:
        """Where the robot last said it is, or None before it has said anything."""
        return self._state

    def update_robot_state(self, t_arrival_s: float, state: RobotState) -> None:
        """Take in where the robot believes it is; a report overtaken by a later one is a sign of life only."""
        self._heard_s = t_arrival_s
        if not self._alive:
            self._alive = True
            self.notices.append(Notice(t_arrival_s, ROBOT, "robot is back"))
        if self._state is None or state.t_s >= self._state.t_s:
            self._state = state

    def check_robot_alive(self, t_s: float) -> None:
        """Notice by session time ``t_s`` a robot that says nothing any more."""
        if self._alive and t_s - self._heard_s > SILENCE_S:
            self._alive = False
            self.notices.append(Notice(t_s, ROBOT, f"robot is dead: silent for more than {SILENCE_S:g} s"))

    def handle(self, t_s: float, answers: Iterable[MethodAction]) -> None:
        """Take in a method's answers, given at session time ``t_s``.

        An intention for an unknown step, for one that is sent or behind a sent one, or without a finite time is
        logged as ``ignored``; what no method should ask for is noticed too, once for each reason. A timer comes after
        ``t_s`` at the earliest, so that one that asks for the next cannot hold up the session.
        """
        for item in answers:
            if isinstance(item, SetTimer):
                heapq.heappush(self._wakes, max(item.t_s, math.nextafter(t_s, math.inf)))
            elif isinstance(item, CancelCommand):
                self._withdraw(t_s, item)
            else:
                self._intend(t_s, item)
        self._set_due()

    def command_move(self, t_s: float, move: Move, speed_m_s: float = 0.0, yaw_rate_rad_s: float = 0.0) -> None:
        """Put a command in force from outside the score, to be sent with the next `due_commands`.

        Nothing is refused: a move may come again, or against the score. It stands for the nearest step of the dance
        that it can stand for, as far as speed and heading are concerned, and the score counts that step as sent.

        Args:
            t_s: session time of the order.
            move: what to do.
            speed_m_s: of DRIVE.
            yaw_rate_rad_s: of DRIVE.
        """
        key = self._nearest(t_s, move)
        self._put_in_force(t_s, key, move, ORDERED, (speed_m_s, yaw_rate_rad_s))
        self._repeat_s = t_s
        self._set_due()

    def due_timers(self, t_s: float) -> list[float]:
        """Take out the timers that have come by ``t_s``, earliest first."""
        due: list[float] = []
        while self._wakes and self._wakes[0] <= t_s:
            due.append(heapq.heappop(self._wakes))
        self._set_due()
        return due

    def due_commands(self, t_s: float) -> list[MoveCommand]:
        """What goes to the robot by ``t_s``: new commands in the order of the score, else a repetition if due."""
        out: list[MoveCommand] = []
        if self._pending_s <= t_s:
            for key in sorted(key for key, item in self._pending.items() if item.t_s <= t_s):
                item = self._pending.pop(key)
                if self._refusal(key):
                    self._log(t_s, key, "ignored", item, self._refusal(key))
                else:
                    out.append(self._send(t_s, key, item))
        if not out and self._repeat_s <= t_s and self._current is not None:
            if self._current.why != ORDERED:
                self._current = self._paced(self._current)
            out.append(self._current)
            self._repeat_s = t_s + self._beat_s
        self._set_due()
        return out

    def _set_due(self) -> None:
        self._pending_s = min((item.t_s for item in self._pending.values()), default=math.inf)
        self.next_due_s = min(self._pending_s, self._repeat_s, self._wakes[0] if self._wakes else math.inf)

    def _intend(self, t_s: float, item: ScheduleCommand) -> None:
        key = (item.iteration, item.ordinal)
        refusal = self._refusal(key) or ("" if math.isfinite(item.t_s) else NO_TIME)
        if refusal:
            self._log(t_s, key, "ignored", item, refusal)
            self._notice(t_s, key, refusal, f"intention at {item.t_s:g} s")
            return
        action = "replaced" if key in self._pending else "scheduled"
        self._pending[key] = item
        self._log(t_s, key, action, item)

    def _withdraw(self, t_s: float, item: CancelCommand) -> None:
        key = (item.iteration, item.ordinal)
        pending = self._pending.pop(key, None)
        if pending is None:
            self._log(t_s, key, "ignored", ScheduleCommand(*key, t_s, item.why), "nothing to withdraw")
            self._notice(t_s, key, self._refusal(key), "withdrawal")
        else:
            self._log(t_s, key, "withdrawn", ScheduleCommand(*key, pending.t_s, item.why, pending.person))

    def _notice(self, t_s: float, key: Key, refusal: str, what: str) -> None:
        """Say once for each reason that a method asks for what cannot be; other refusals lie in a dance's nature."""
        if refusal not in (NO_STEP, NO_TIME) or refusal in self._noticed:
            return
        self._noticed.add(refusal)
        allowed = f"iterations 1 to {self._context.iterations}, ordinals 0 to {len(self._steps) - 1}"
        said = f"{what} for iteration {key[0]}, ordinal {key[1]} ignored: {refusal}"
        said += f" ({allowed})" if refusal == NO_STEP else ""
        self.notices.append(Notice(t_s, METHOD, f"{said}; further ones only in the decisions"))

    def _refusal(self, key: Key) -> str:
        if key[1] not in self._steps or not 1 <= key[0] <= self._context.iterations:
            return NO_STEP
        if key in self._sent_s:
            return "already sent"
        return "a later step has been sent" if key < self._last else ""

    def _send(self, t_s: float, key: Key, item: ScheduleCommand) -> MoveCommand:
        command = self._put_in_force(t_s, key, ROBOT_MOVES[self._steps[key[1]].kind], item.why)
        self._last = key
        self._repeat_s = t_s + self._beat_s
        self._log(t_s, key, "sent", item)
        return command

    def _put_in_force(
        self, t_s: float, key: Key, move: Move, why: str, velocity: tuple[float, float] = (0.0, 0.0)
    ) -> MoveCommand:
        command = MoveCommand(
            number=1 if self._current is None else self._current.number + 1,
            move=move,
            t_start_s=t_s,
            speed_m_s=velocity[0] if move is Move.DRIVE else self._speed_m_s(key, move, t_s),
            heading_rad=self._heading_rad(key, move),
            iteration=key[0],
            ordinal=key[1],
            why=why,
            yaw_rate_rad_s=velocity[1],
        )
        self._current = command
        if move is not Move.DRIVE:
            self._sent_s[key] = t_s
        return command

    def _nearest(self, t_s: float, move: Move) -> Key:
        """The step nearest in time whose move this is; for a move that no step has, any step."""
        own = [step for step in self._context.steps if ROBOT_MOVES[step.kind] is move] or self._context.steps
        return min(
            ((iteration, step.ordinal) for iteration in range(1, self._context.iterations + 1) for step in own),
            key=lambda key: abs(self._timetable.time_s(key[0], self._steps[key[1]].beat) - t_s),
        )

    def _speed_m_s(self, key: Key, move: Move, t_s: float) -> float:
        """Cruise that ends a forward move at its nominal end and a backward one on the slot.

        With equal limits on speeding up and slowing down a move covers speed x (time from start to stop command),
        whatever the acceleration.
        """
        if move not in (Move.FORWARD, Move.BACKWARD):
            return 0.0
        duration = self._duration_s(key, t_s)
        ahead = self._ahead_m(key[0])
        speed = self._robot.cruise_m_s - ahead / duration if move is Move.FORWARD else ahead / duration
        low, high = SPEED_M_S
        return min(max(speed, low), high, self._robot.max_speed_m_s)

    def _heading_rad(self, key: Key, move: Move) -> float:
        """Heading of a move, or while the robot stands of the move to come; a turn ends at the next iteration's."""
        iteration, ordinal = key
        if move is Move.TURN:
            return float(self._timetable.heading_rad(iteration + 1))
        heading = float(self._timetable.heading_rad(iteration))
        step = self._steps.get(ordinal + 1 if move is Move.STOP else ordinal)
        return (
            heading
            if step is None
            else heading + self._steer_rad(heading, ROBOT_MOVES[step.kind], (iteration, step.ordinal))
        )

    def _steer_rad(self, heading: float, move: Move, key: Key) -> float:
        """How far a move is turned off the iteration's heading, so that it also leads back beside the slot."""
        if move not in (Move.FORWARD, Move.BACKWARD) or self._state is None:
            return 0.0
        x, y = self._state.x_m - self._slot[0], self._state.y_m - self._slot[1]
        aside = y * math.cos(heading) - x * math.sin(heading)
        way = self._robot.cruise_m_s * self._nominal_s(key)
        steer = min(max(STEER * aside / way, -STEER_MAX_RAD), STEER_MAX_RAD)
        return steer if move is Move.BACKWARD else -steer

    def _paced(self, command: MoveCommand) -> MoveCommand:
        """The command again: past its end a move crawls, and far past it halts; a stop far off settles."""
        left = self._left_m(command)
        if command.move is Move.STOP:
            return replace(command, speed_m_s=math.copysign(SETTLE_M_S, left) if abs(left) > SETTLE_M else 0.0)
        past = -left if command.move is Move.FORWARD else left
        if command.move is Move.TURN or command.speed_m_s == 0.0 or past <= PAST_M:
            return command
        return replace(command, speed_m_s=CRAWL_M_S if past < HALT_M else 0.0)

    def _left_m(self, command: MoveCommand) -> float:
        """How far ahead of the robot, or if negative behind it, its move should end or have ended [m]."""
        start = self._steps.get(command.ordinal - (command.move is Move.STOP))
        move = ROBOT_MOVES[start.kind] if start is not None else Move.STOP
        if move is Move.FORWARD:
            assert start is not None
            end = self._robot.cruise_m_s * self._nominal_s((command.iteration, start.ordinal))
        elif move is Move.BACKWARD:
            end = 0.0
        else:
            return 0.0
        return end - self._ahead_m(command.iteration)

    def _ahead_m(self, iteration: int) -> float:
        """Where the robot will have come to rest, along the iteration's heading from its slot [m]."""
        state = self._state
        if state is None:
            return 0.0
        heading = self._timetable.heading_rad(iteration)
        ahead = (state.x_m - self._slot[0]) * math.cos(heading) + (state.y_m - self._slot[1]) * math.sin(heading)
        speed = state.step_m * self._robot.odometry_hz
        return ahead + speed * abs(speed) / (2.0 * self._robot.acceleration_m_s2)

    def _nominal_s(self, key: Key) -> float:
        """Time from a step to the next one by the score."""
        iteration, ordinal = key
        then = self._steps.get(ordinal + 1)
        if then is None:
            return SHORTEST_S
        table = self._timetable
        return table.time_s(iteration, then.beat) - table.time_s(iteration, self._steps[ordinal].beat)

    def _duration_s(self, key: Key, t_s: float) -> float:
        """Expected time from a step's command, sent now, to the next one's.

        As the method has scheduled it, else the median of the score's and what it took in earlier iterations.
        """
        iteration, ordinal = key
        nominal = self._nominal_s(key)
        then = self._pending.get((iteration, ordinal + 1))
        if then is not None and not then.last_resort:
            return max(SHORTEST_S, min(then.t_s - t_s, 2.0 * nominal))
        spans = [nominal]
        for before in range(1, iteration):
            start, stop = self._sent_s.get((before, ordinal)), self._sent_s.get((before, ordinal + 1))
            if start is not None and stop is not None:
                spans.append(stop - start)
        return max(SHORTEST_S, min(median(spans), 2.0 * nominal))

    def _log(self, t_s: float, key: Key, action: str, item: ScheduleCommand, refusal: str = "") -> None:
        step = self._steps.get(key[1])
        kind = step.kind if step is not None else Kind.TURN
        why = f"{refusal}: {item.why}" if refusal else item.why
        self.decisions.append(Decision(t_s, key[0], key[1], kind, action, item.t_s, item.person, why))
