"""A dance as a score in beats over a tempo map: what is danced when, before people add their own timing."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..core import Kind, Move
from ..core.method_io import Step
from ..core.tempo import TempoMap

MOVE_EVENTS = {
    Move.FORWARD: (Kind.START_FORWARD, Kind.STOP_FORWARD),
    Move.BACKWARD: (Kind.START_BACKWARD, Kind.STOP_BACKWARD),
    Move.CLAP: (Kind.CLAP,),
    Move.TURN: (),
}
"""The events that each move of a dancer gives rise to; a dancer's turn follows the clap and is no event of its own."""


@dataclass(frozen=True, slots=True)
class ScoreMove:
    """One move of the score: beat inside the iteration and nominal length in beats (0 for a clap)."""

    move: Move
    beat: float
    beats: float


@dataclass(frozen=True, slots=True)
class Choreography:
    """One iteration of a dance, repeated.

    Attributes:
        name: what users write.
        moves: the moves of one iteration, in order.
        iteration_beats: from one iteration's beat 0 to the next one's.
        close_beat: where an iteration's window closes; later events belong to the next iteration.
        turn_rad: heading change of a turn, counter-clockwise positive.
    """

    name: str
    moves: tuple[ScoreMove, ...]
    iteration_beats: float
    close_beat: float
    turn_rad: float

    def steps(self) -> tuple[Step, ...]:
        """The events of one iteration, in order, with their occurrence among events of their kind."""
        steps: list[Step] = []
        seen: dict[Kind, int] = {}
        for item in self.moves:
            for part, kind in enumerate(MOVE_EVENTS[item.move]):
                occurrence = seen.get(kind, 0)
                seen[kind] = occurrence + 1
                steps.append(Step(len(steps), kind, occurrence, item.beat + part * item.beats))
        return tuple(steps)

    def first_ordinal(self, index: int) -> int:
        """Ordinal of the first event that belongs to the ``index``-th move (a turn shares its clap's)."""
        before = sum(len(MOVE_EVENTS[item.move]) for item in self.moves[:index])
        return before if MOVE_EVENTS[self.moves[index].move] else max(before - 1, 0)


@dataclass(frozen=True)
class Timetable:
    """Session times of a whole dance: where beats fall once lead-in, rehearsal and iterations are laid out.

    Attributes:
        choreography: the dance.
        tempo: beats of the song, beat 0 being the rehearsal's first.
        lead_in_s: session time of the song's beat 0.
        first: index of the first iteration: 0 with a rehearsal, 1 without.
        last: index of the last iteration.
    """

    choreography: Choreography
    tempo: TempoMap
    lead_in_s: float
    first: int
    last: int

    def time_s(self, iteration: int, beat: float) -> float:
        """Session time of a beat of an iteration [s]."""
        song_beat = (iteration - self.first) * self.choreography.iteration_beats + beat
        return self.lead_in_s + self.tempo.time_s(song_beat)

    def start_s(self, iteration: int) -> float:
        """Session time of an iteration's beat 0 [s]."""
        return self.time_s(iteration, 0.0)

    def close_s(self, iteration: int) -> float:
        """Session time at which an iteration's window closes [s]."""
        return self.time_s(iteration, self.choreography.close_beat)

    @cached_property
    def _closings_s(self) -> list[float]:
        return [self.close_s(iteration) for iteration in range(self.first, self.last)]

    def iteration_at(self, t_s: float) -> int:
        """The iteration whose window holds this session time; before the first window the first one."""
        return self.first + bisect_left(self._closings_s, t_s)

    def end_s(self) -> float:
        """Session time at which the last iteration is over [s]."""
        return self.time_s(self.last, self.choreography.iteration_beats)

    def heading_rad(self, iteration: int) -> float:
        """Heading of everyone before the turn of this iteration; iteration 1 faces north (world +y)."""
        return np.pi / 2 + (iteration - 1) * self.choreography.turn_rad
