"""The replay timing model: dancers perform the event times of a recorded session or of a laboratory's event table."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...choreography.timetable import Timetable
from ...core import ROBOT, Array, Cue, Kind, Move, dancer_name
from ...core.errors import ConfigError, RecordError
from ...core.session_log import Notice, TableEvent, natural_order
from ..motion.planner import MIN_TURN_S
from .cue_assembly import MIN_HOLD_S, MIN_MOVE_S, TURN_AFTER_CLAP_S
from .ensemble import PREPARATION_S
from .human_timing import ObservedRobotEvent

FRAME_S = 1 / 30
"""Resolution of detected times: a move or hold that is too short by no more than this is made long enough [s]."""

MAX_MOVE_S = 6.0
"""Longest move forward or backward [s]; a longer one would lead too far from the slot (assumed)."""

_STARTS = {Kind.START_FORWARD: Move.FORWARD, Kind.START_BACKWARD: Move.BACKWARD}
_STOPS = {Kind.STOP_FORWARD: Move.FORWARD, Kind.STOP_BACKWARD: Move.BACKWARD}

EventsByDancer = Mapping[tuple[int, int], Sequence[TableEvent]]
"""(dancer, iteration) -> events, in order of time."""


@dataclass(frozen=True, slots=True)
class _Performed:
    """Events of a table that make up one move: a start with its stop, one of the two alone, a clap or a turn."""

    start: TableEvent | None
    stop: TableEvent | None

    @property
    def event(self) -> TableEvent:
        """The first event there is."""
        event = self.start or self.stop
        assert event is not None
        return event


class Replay:
    """Implements `HumanTiming` by performing recorded event times; nothing is random, and the robot has no influence.

    Times are session times. A start without its stop, or a stop without its start, as detectors leave them, is
    completed to the score's length of the move, as far as the neighbouring moves allow. A move or hold that is too
    short by at most `FRAME_S` is lengthened. Every other event is performed as it stands, or refused. Early events and
    the robot's events are ignored.

    Args:
        events: rows of one session, each agent's in order of time.
        source: name of the file, for messages.
        timetable: the dance in session time.
        dancers: number of dancers.

    Raises:
        RecordError: an event is not part of the dance or lies outside its iteration, or a move or hold is too short or
            too long; the message names the line and the allowed range.
        ConfigError: the table has another number of dancers.

    Attributes:
        notices: what had to be completed.
    """

    def __init__(self, events: Sequence[TableEvent], source: str, timetable: Timetable, dancers: int) -> None:
        self._source = source
        self._timetable = timetable
        self._dancers = dancers
        self.notices: list[Notice] = []

        performed = [event for event in events if event.agent != ROBOT and not event.early]
        index = _dancer_indices({event.agent for event in performed}, dancers, source)
        own: dict[tuple[int, int], list[TableEvent]] = {}
        for event in performed:
            self._check_iteration(event)
            own.setdefault((index[event.agent], event.iteration), []).append(event)

        # Turns come last: their length depends on the first move of the next iteration.
        self._cues = {key: self._moves_and_claps(key[0], key[1], found) for key, found in sorted(own.items())}
        self._add_turns(own)
        self._begun: int | None = None

    @property
    def next_due_s(self) -> float:
        """See `HumanTiming.next_due_s`; an iteration is decided at once."""
        return math.inf if self._begun is None else -math.inf

    def begin(self, iteration: int, appropriateness_s: float | None, not_before_s: Array) -> None:
        """See `HumanTiming.begin`."""
        self._begun = iteration

    def decide(self, now_s: float, robot: Sequence[ObservedRobotEvent]) -> tuple[tuple[Cue, ...], ...]:
        """See `HumanTiming.decide`."""
        iteration = self._begun
        self._begun = None
        if iteration is None:
            return ((),) * self._dancers

        return tuple(tuple(self._cues.get((dancer, iteration), ())) for dancer in range(self._dancers))

    def _error(self, event: TableEvent, problem: str) -> RecordError:
        """An error that names the file, the line and the event."""
        name = f"{event.agent}'s {event.kind} of iteration {event.iteration} at {event.t_s:g} s"
        return RecordError(f"{self._source}, line {event.line}: {name}: {problem}")

    def _check_iteration(self, event: TableEvent) -> None:
        """Raise for an event of an iteration that the dance does not have, or outside its iteration's time."""
        table = self._timetable
        if not table.first <= event.iteration <= table.last:
            raise self._error(event, f"the dance has iterations {table.first} to {table.last}")

        previous_close_s = 0.0 if event.iteration == table.first else table.close_s(event.iteration - 1)
        low_s = previous_close_s + PREPARATION_S
        high_s = table.time_s(event.iteration, table.choreography.iteration_beats)
        if not low_s <= event.t_s <= high_s:
            raise self._error(event, f"events of this iteration lie from {low_s:.2f} to {high_s:.2f} s here")

    def _moves_and_claps(self, dancer: int, iteration: int, events: Sequence[TableEvent]) -> list[Cue]:
        """Cues of one dancer in one iteration, without the turn."""
        cues: list[Cue] = []
        free_s = -math.inf
        first_event: dict[int, TableEvent] = {}

        for performed in _pair(events):
            if performed.event.kind is Kind.TURN:
                continue

            index = self._nearest_move(iteration, performed.event)
            ordinal = self._timetable.choreography.first_ordinal(index)
            before = first_event.setdefault(ordinal, performed.event)
            if before is not performed.event:
                problem = f"this step of the dance is that of line {before.line} already"
                raise self._error(performed.event, problem)

            cue = self._cue(dancer, index, performed, free_s, _next_event_s(events, performed.event))
            cues.append(cue)
            free_s = cue.t_s + cue.duration_s + MIN_HOLD_S

        return cues

    def _cue(self, dancer: int, index: int, performed: _Performed, free_s: float, next_s: float) -> Cue:
        """Cue of a move or clap.

        Args:
            dancer: index of the dancer.
            index: index of the move in the score.
            performed: its events.
            free_s: session time from which the dancer is free.
            next_s: session time of the dancer's next event.
        """
        event = performed.event
        item = self._timetable.choreography.moves[index]
        end_s = self._timetable.time_s(event.iteration, item.beat + item.beats)
        nominal_s = end_s - self._timetable.time_s(event.iteration, item.beat)

        name = dancer_name(dancer)
        if item.move is not Move.CLAP and (performed.start is None or performed.stop is None):
            missing = "start" if performed.start is None else "stop"
            what = f"{self._source}, line {event.line}: {event.kind} without a {missing}; the score's length is used"
            self.notices.append(Notice(event.t_s, name, what))

        t_s, duration_s = self._interval(performed, nominal_s, free_s, next_s)
        if t_s < free_s - FRAME_S:
            raise self._error(event, f"{free_s:.2f} s at the earliest, {MIN_HOLD_S:g} s after the last move")

        ordinal = self._timetable.choreography.first_ordinal(index)
        return Cue(name, item.move, event.iteration, ordinal, item.beat, max(t_s, free_s), duration_s)

    def _interval(self, performed: _Performed, nominal_s: float, free_s: float, next_s: float) -> tuple[float, float]:
        """Begin and duration of a move or clap [s].

        Args:
            performed: its events.
            nominal_s: duration in the score, for what is missing.
            free_s: session time from which the dancer is free.
            next_s: session time of the dancer's next event.
        """
        start = performed.start
        stop = performed.stop
        if start is not None and start.kind is Kind.CLAP:
            return start.t_s, 0.0

        event = stop or performed.event
        if start is None:
            t_s = max(event.t_s - nominal_s, free_s)
            end_s = event.t_s
        else:
            t_s = start.t_s
            end_s = stop.t_s if stop else min(t_s + nominal_s, next_s - MIN_HOLD_S)

        duration_s = end_s - t_s
        if duration_s >= MIN_MOVE_S - FRAME_S:
            duration_s = max(duration_s, MIN_MOVE_S)
        if not MIN_MOVE_S <= duration_s <= MAX_MOVE_S:
            allowed = f"a move takes from {MIN_MOVE_S:g} to {MAX_MOVE_S:g} s, not {duration_s:.2f} s"
            raise self._error(event, allowed)
        return t_s, duration_s

    def _nearest_move(self, iteration: int, event: TableEvent) -> int:
        """Index of the score's move to which an event belongs: the nearest in time of those that have such an event."""
        move = Move.CLAP if event.kind is Kind.CLAP else _STARTS.get(event.kind) or _STOPS[event.kind]
        stops = event.kind in _STOPS
        gaps = {
            index: abs(self._timetable.time_s(iteration, item.beat + stops * item.beats) - event.t_s)
            for index, item in enumerate(self._timetable.choreography.moves)
            if item.move is move
        }
        if not gaps:
            raise self._error(event, f"not in the dance {self._timetable.choreography.name!r}")

        return min(gaps, key=lambda index: gaps[index])

    def _add_turns(self, own: EventsByDancer) -> None:
        """Add the turns of all dancers; their length depends on when the next iteration begins."""
        table = self._timetable
        turns = [index for index, item in enumerate(table.choreography.moves) if item.move is Move.TURN]

        for index in turns:
            for dancer in range(self._dancers):
                for iteration in range(table.first, table.last + 1):
                    self._cues.setdefault((dancer, iteration), [])
                    self._add_turn(index, dancer, iteration, own)

    def _add_turn(self, index: int, dancer: int, iteration: int, own: EventsByDancer) -> None:
        """Add a turn: at its time in the table, else after the clap, else with the music."""
        table = self._timetable
        item = table.choreography.moves[index]
        cues = self._cues[dancer, iteration]
        recorded = [event for event in own.get((dancer, iteration), ()) if event.kind is Kind.TURN]
        following = self._cues.get((dancer, iteration + 1), ())

        begin_s = table.time_s(iteration, item.beat)
        nominal_s = table.time_s(iteration, item.beat + item.beats) - begin_s
        free_s = cues[-1].t_s + cues[-1].duration_s if cues else -math.inf
        if cues and cues[-1].move is Move.CLAP:
            begin_s = cues[-1].t_s + TURN_AFTER_CLAP_S

        # A turn that the table does not have is shortened rather than refused, as long as it is possible.
        t_s = recorded[0].t_s if recorded else max(begin_s, free_s + MIN_HOLD_S)
        next_s = following[0].t_s if following else math.inf
        duration_s = min(nominal_s, next_s - MIN_HOLD_S - t_s)
        if t_s < free_s or duration_s < MIN_TURN_S:
            event = recorded[0] if recorded else own[dancer, iteration + 1][0]
            raise self._error(event, f"there is no time for a turn of {MIN_TURN_S:g} s beside it")

        ordinal = table.choreography.first_ordinal(index)
        cues.append(Cue(dancer_name(dancer), Move.TURN, iteration, ordinal, item.beat, t_s, duration_s))


def _pair(events: Sequence[TableEvent]) -> list[_Performed]:
    """Starts with the stops that follow them; an event without a partner is alone."""
    out: list[_Performed] = []
    for event in events:
        if event.kind not in _STOPS:
            out.append(_Performed(event, None))
            continue

        start = out[-1].start if out and out[-1].stop is None else None
        if start is not None and _STARTS.get(start.kind) is _STOPS[event.kind]:
            out[-1] = _Performed(start, event)
        else:
            out.append(_Performed(None, event))
    return out


def _next_event_s(events: Sequence[TableEvent], event: TableEvent) -> float:
    """Time of the dancer's next event in the iteration; infinite after the last."""
    return min((other.t_s for other in events if other.t_s > event.t_s), default=math.inf)


def _dancer_indices(agents: set[str], dancers: int, source: str) -> dict[str, int]:
    """Agent -> index of the dancer: by number if all are named dancer_1, ..., else in the order of their names."""
    numbers = [re.fullmatch(r"dancer_([1-8])", agent) for agent in agents]
    if agents and all(numbers) and all(int(number[1]) <= dancers for number in numbers if number):
        return {agent: int(agent[-1]) - 1 for agent in agents}

    if len(agents) != dancers:
        found = ", ".join(sorted(agents)) or "nobody"
        raise ConfigError("dancers", dancers, f"as many as dance in {source}: {len(agents)} ({found})")

    return {agent: index for index, agent in enumerate(sorted(agents, key=natural_order))}
