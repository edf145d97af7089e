"""The score of a dance in beats: which moves one iteration consists of, and the events that follow from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from ..core import Kind, Move
from ..core.method_io import Step

MOVE_EVENTS = {
    Move.FORWARD: (Kind.START_FORWARD, Kind.STOP_FORWARD),
    Move.BACKWARD: (Kind.START_BACKWARD, Kind.STOP_BACKWARD),
    Move.CLAP: (Kind.CLAP,),
    Move.TURN: (),
}
"""Move of a dancer -> kinds of its events, in order. A dancer's turn follows the clap and has no event of its own."""


@dataclass(frozen=True, slots=True)
class ScoreMove:
    """One move of the score.

    Attributes:
        move: which move.
        beat: where it begins, counted from the iteration's beat 0.
        beats: nominal length; 0 for a clap.
    """

    move: Move
    beat: float
    beats: float


@dataclass(frozen=True)
class Choreography:
    """A dance: one iteration, which the session repeats.

    Attributes:
        name: the name that users write, as in ``--dance.name``.
        moves: the moves of one iteration, in order.
        iteration_beats: from one iteration's beat 0 to the next one's.
        close_beat: where an iteration's window closes; later events belong to the next iteration.
        turn_rad: change of heading in a turn, counter-clockwise positive [rad].
    """

    name: str
    moves: tuple[ScoreMove, ...]
    iteration_beats: float
    close_beat: float
    turn_rad: float

    def steps(self) -> tuple[Step, ...]:
        """The planned events of one iteration, in order.

        A step's ordinal counts all events of the iteration, its occurrence those of the same kind, both from 0.
        """
        return self._steps

    @cached_property
    def _steps(self) -> tuple[Step, ...]:
        steps: list[Step] = []
        counts: dict[Kind, int] = {}

        for item in self.moves:
            for part, kind in enumerate(MOVE_EVENTS[item.move]):
                occurrence = counts.get(kind, 0)
                counts[kind] = occurrence + 1
                steps.append(Step(len(steps), kind, occurrence, item.beat + part * item.beats))

        return tuple(steps)

    def first_ordinal(self, index: int) -> int:
        """Ordinal of the first event of the ``index``-th move; a turn, which has none, shares that of its clap."""
        return self._first_ordinals[index]

    @cached_property
    def _first_ordinals(self) -> tuple[int, ...]:
        ordinals: list[int] = []
        before = 0
        for item in self.moves:
            count = len(MOVE_EVENTS[item.move])
            ordinals.append(before if count else max(before - 1, 0))
            before += count
        return tuple(ordinals)
