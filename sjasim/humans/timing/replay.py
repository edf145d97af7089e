"""People who do what an event table says, at the times it says: a session danced again, or a laboratory's group."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from ...choreography.timetable import Timetable
from ...core import ROBOT, Array, Cue, Kind, Move, dancer_name
from ...core.errors import ConfigError, RecordError
from ...core.session_log import Notice, TableEvent, natural_order
from ..motion.planner import MIN_TURN_S
from .ensemble import MIN_HOLD_S, MIN_MOVE_S, PREPARATION_S, TURN_AFTER_CLAP_S
from .human_timing import ObservedRobotEvent

FRAME_S = 1 / 30
"""Detected times are only as fine as a camera's frames: a move or hold shorter by so much is made long enough."""
LONGEST_MOVE_S = 6.0
"""A longer move would lead out of the room (assumed)."""
_STARTS = {Kind.START_FORWARD: Move.FORWARD, Kind.START_BACKWARD: Move.BACKWARD}
_STOPS = {Kind.STOP_FORWARD: Move.FORWARD, Kind.STOP_BACKWARD: Move.BACKWARD}

Own = Mapping[tuple[int, int], Sequence[TableEvent]]
"""(dancer, iteration) -> events, in order of time."""


class Replay:
    """A human timing model that performs recorded event times; nothing about it is random, and nobody sees the robot.

    Times are on the session's clock. A start without its stop, or a stop without its start, as detectors leave them,
    is completed to the score's length of the move, within what lies around it. A move or hold that a camera's frame
    makes too short is as long as it must be; everything else is performed as it stands or refused. Early events only
    announce regular ones, and the robot dances by itself: both are left aside.

    Args:
        events: rows of one session, each agent's in order of time.
        source: the file's name, for messages.
        timetable: the dance on the session's clock.
        dancers: how many dance.

    Raises:
        RecordError: an event is not of this dance, outside its iteration's time, or a move or hold too short to be
            possible; the line and the allowed range are named.
        ConfigError: there are more or fewer dancers in the table than in the group.

    Attributes:
        notices: what had to be completed.
    """

    def __init__(self, events: Sequence[TableEvent], source: str, timetable: Timetable, dancers: int) -> None:
        self._source, self._timetable = source, timetable
        performed = [event for event in events if event.agent != ROBOT and not event.early]
        self._places = _places({event.agent for event in performed}, dancers, source)
        self.notices: list[Notice] = []
        own: dict[tuple[int, int], list[TableEvent]] = {}
        for event in performed:
            self._check_iteration(event)
            own.setdefault((self._places[event.agent], event.iteration), []).append(event)
        self._cues = {key: self._perform(key[0], key[1], found) for key, found in sorted(own.items())}
        self._waiting: int | None = None
        self._dancers = dancers
        self._turns(own)

    @property
    def next_due_s(self) -> float:
        """See `HumanTiming`; an iteration is decided at once."""
        return math.inf if self._waiting is None else -math.inf

    def begin(self, iteration: int, appropriateness_s: float | None, not_before_s: Array) -> None:
        """See `HumanTiming`."""
        self._waiting = iteration

    def decide(self, now_s: float, robot: Sequence[ObservedRobotEvent]) -> tuple[tuple[Cue, ...], ...]:
        """See `HumanTiming`."""
        iteration, self._waiting = self._waiting, None
        if iteration is None:
            return ((),) * self._dancers
        return tuple(tuple(self._cues.get((dancer, iteration), ())) for dancer in range(self._dancers))

    def _wrong(self, event: TableEvent, what: str) -> RecordError:
        told = f"{event.agent}'s {event.kind} of iteration {event.iteration} at {event.t_s:g} s"
        return RecordError(f"{self._source}, line {event.line}: {told}: {what}")

    def _check_iteration(self, event: TableEvent) -> None:
        table = self._timetable
        if not table.first <= event.iteration <= table.last:
            raise self._wrong(event, f"the dance has iterations {table.first} to {table.last}")
        first = event.iteration == table.first
        low = (0.0 if first else table.close_s(event.iteration - 1)) + PREPARATION_S
        high = table.time_s(event.iteration, table.choreography.iteration_beats)
        if not low <= event.t_s <= high:
            raise self._wrong(event, f"events of this iteration lie from {low:.2f} to {high:.2f} s here")

    def _perform(self, dancer: int, iteration: int, events: Sequence[TableEvent]) -> list[Cue]:
        """One dancer's moves and claps of one iteration, the turn left out."""
        name, cues = dancer_name(dancer), []
        free_s = -math.inf
        taken: dict[tuple[Move, int], TableEvent] = {}
        for start, stop in _pairs(events):
            event = start or stop
            assert event is not None
            if event.kind is Kind.TURN:
                continue
            move = Move.CLAP if event.kind is Kind.CLAP else _STARTS.get(event.kind) or _STOPS[event.kind]
            index = self._nearest(move, iteration, event)
            item = self._timetable.choreography.moves[index]
            ordinal = self._timetable.choreography.first_ordinal(index)
            before = taken.setdefault((move, ordinal), event)
            if before is not event:
                raise self._wrong(event, f"this step of the dance is that of line {before.line} already")
            length = self._timetable.time_s(iteration, item.beat + item.beats)
            length -= self._timetable.time_s(iteration, item.beat)
            if move is not Move.CLAP and (start is None or stop is None):
                what = f"{self._source}, line {event.line}: {event.kind} has no partner; the score's length is taken"
                self.notices.append(Notice(event.t_s, name, what))
            t_s, duration_s = self._span(start, stop, length, free_s, _after(events, event))
            if t_s < free_s - FRAME_S:
                raise self._wrong(event, f"{free_s:.2f} s at the earliest, {MIN_HOLD_S:g} s after the last move")
            t_s = max(t_s, free_s)
            cues.append(Cue(name, move, iteration, ordinal, item.beat, t_s, duration_s))
            free_s = t_s + duration_s + MIN_HOLD_S
        return cues

    def _span(
        self, start: TableEvent | None, stop: TableEvent | None, length: float, free_s: float, next_s: float
    ) -> tuple[float, float]:
        """Begin and duration of a move or clap; ``length`` is the score's, for what is missing [s]."""
        if start is not None and start.kind is Kind.CLAP:
            return start.t_s, 0.0
        if start is None:
            assert stop is not None
            t_s = max(stop.t_s - length, free_s)
            event, duration_s = stop, stop.t_s - t_s
        else:
            t_s = start.t_s
            event, end_s = (stop, stop.t_s) if stop else (start, min(t_s + length, next_s - MIN_HOLD_S))
            duration_s = end_s - t_s
        if duration_s >= MIN_MOVE_S - FRAME_S:
            duration_s = max(duration_s, MIN_MOVE_S)
        if not MIN_MOVE_S <= duration_s <= LONGEST_MOVE_S:
            allowed = f"a move takes from {MIN_MOVE_S:g} to {LONGEST_MOVE_S:g} s, not {duration_s:.2f} s"
            raise self._wrong(event, allowed)
        return t_s, duration_s

    def _nearest(self, move: Move, iteration: int, event: TableEvent) -> int:
        """Which of the score's moves this is."""
        late = event.kind in _STOPS
        moves = self._timetable.choreography.moves
        gaps = {
            index: abs(self._timetable.time_s(iteration, item.beat + late * item.beats) - event.t_s)
            for index, item in enumerate(moves)
            if item.move is move
        }
        if not gaps:
            raise self._wrong(event, f"not in the dance {self._timetable.choreography.name!r}")
        return min(gaps, key=lambda index: gaps[index])

    def _turns(self, own: Own) -> None:
        """Let everybody turn in every iteration, once it is known when they begin the next one."""
        table = self._timetable
        for index, item in enumerate(table.choreography.moves):
            if item.move is not Move.TURN:
                continue
            for dancer in range(self._dancers):
                for iteration in range(table.first, table.last + 1):
                    self._cues.setdefault((dancer, iteration), [])
                    self._turn(index, dancer, iteration, own)

    def _turn(self, index: int, dancer: int, iteration: int, own: Own) -> None:
        """Add a turn: where the table says so, else after the clap, else with the music."""
        table, cues = self._timetable, self._cues[dancer, iteration]
        item = table.choreography.moves[index]
        said = [event for event in own.get((dancer, iteration), ()) if event.kind is Kind.TURN]
        after = self._cues.get((dancer, iteration + 1), ())
        begin_s = table.time_s(iteration, item.beat)
        length = table.time_s(iteration, item.beat + item.beats) - begin_s
        free_s = cues[-1].t_s + cues[-1].duration_s if cues else -math.inf
        if cues and cues[-1].move is Move.CLAP:
            begin_s = cues[-1].t_s + TURN_AFTER_CLAP_S
        t_s = said[0].t_s if said else max(begin_s, free_s + MIN_HOLD_S)
        duration_s = min(length, (after[0].t_s if after else math.inf) - MIN_HOLD_S - t_s)
        if t_s < free_s or duration_s < MIN_TURN_S:
            event = said[0] if said else own[dancer, iteration + 1][0]
            raise self._wrong(event, f"there is no time for a turn of {MIN_TURN_S:g} s beside it")
        ordinal = table.choreography.first_ordinal(index)
        cues.append(Cue(dancer_name(dancer), Move.TURN, iteration, ordinal, item.beat, t_s, duration_s))


def _pairs(events: Sequence[TableEvent]) -> list[tuple[TableEvent | None, TableEvent | None]]:
    """Starts with their stops; what has no partner, or needs none, is alone."""
    out: list[tuple[TableEvent | None, TableEvent | None]] = []
    for event in events:
        start = out[-1][0] if out and out[-1][1] is None else None
        if event.kind in _STOPS and start is not None and _STARTS.get(start.kind) is _STOPS[event.kind]:
            out[-1] = (start, event)
        else:
            out.append((None, event) if event.kind in _STOPS else (event, None))
    return out


def _after(events: Sequence[TableEvent], event: TableEvent) -> float:
    """Time of the next event of this dancer in the iteration; infinite after the last."""
    return min((other.t_s for other in events if other.t_s > event.t_s), default=math.inf)


def _places(agents: set[str], dancers: int, source: str) -> dict[str, int]:
    """Agent -> dancer: by name where all are called dancer_1, ..., else in the order of their names."""
    numbers = [re.fullmatch(r"dancer_([1-8])", agent) for agent in agents]
    if agents and all(numbers) and all(int(number[1]) <= dancers for number in numbers if number):
        return {agent: int(agent[-1]) - 1 for agent in agents}
    if len(agents) != dancers:
        told = ", ".join(sorted(agents)) or "nobody"
        raise ConfigError("dancers", dancers, f"as many as dance in {source}: {len(agents)} ({told})")
    return {agent: place for place, agent in enumerate(sorted(agents, key=natural_order))}
