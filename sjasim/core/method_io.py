"""What an anticipation method is given before the dance, and what it may answer."""

from __future__ import annotations

from dataclasses import dataclass

from . import Kind, Move
from .tempo import TempoMap

ROBOT_MOVES = {
    Kind.START_FORWARD: Move.FORWARD,
    Kind.STOP_FORWARD: Move.STOP,
    Kind.START_BACKWARD: Move.BACKWARD,
    Kind.STOP_BACKWARD: Move.STOP,
    Kind.CLAP: Move.TURN,
    Kind.TURN: Move.TURN,
}
"""Kind of a step -> the robot's move; the robot turns where dancers clap (iqbal2016, section II-C)."""


@dataclass(frozen=True, slots=True)
class Step:
    """One robot event that the choreography wants in every iteration.

    Attributes:
        ordinal: place of the event in the iteration, from 0.
        kind: the dancers' event that it corresponds to; the robot turns where dancers clap.
        occurrence: number of events of this kind that come before it in the iteration.
        beat: nominal beat of the event in the iteration.
    """

    ordinal: int
    kind: Kind
    occurrence: int
    beat: float


@dataclass(frozen=True, slots=True)
class MethodContext:
    """All that an anticipation method is given before the dance. It contains neither the truth nor the dancers' plan.

    Attributes:
        cast: names of the dancers.
        steps: the robot's events of one iteration, in order.
        iterations: number of iterations after the rehearsal.
        beat_s: nominal duration of a beat, from which a dance's tempo may deviate.
        iteration_start_s: session time of beat 0 of each iteration, index 0 being the rehearsal.
        window_end_s: session time at which each iteration's window closes, same index.
        tempo: session time of the beats, counted from an arbitrary one; None for a constant ``beat_s``.
        tau_s: largest time between two events of a kind that count as synchronous, as in the session's own measures.
    """

    cast: tuple[str, ...]
    steps: tuple[Step, ...]
    iterations: int
    beat_s: float
    iteration_start_s: tuple[float, ...]
    window_end_s: tuple[float, ...]
    tempo: TempoMap | None = None
    tau_s: float = 0.25

    def beat(self, iteration: int, t_s: float) -> float:
        """Beat of an iteration at a session time, as a number with a fraction."""
        start_s = self.iteration_start_s[iteration]
        if self.tempo is None:
            return (t_s - start_s) / self.beat_s
        return self.tempo.beat(t_s) - self.tempo.beat(start_s)

    def time_s(self, iteration: int, beat: float) -> float:
        """Session time of a beat of an iteration [s]."""
        start_s = self.iteration_start_s[iteration]
        if self.tempo is None:
            return start_s + beat * self.beat_s
        return self.tempo.time_s(self.tempo.beat(start_s) + beat)


@dataclass(frozen=True, slots=True)
class ScheduleCommand:
    """Answer of a method: send the command for a step at a time, unless it is replaced or cancelled before.

    Attributes:
        iteration: the iteration of the step.
        ordinal: the step, by its place among the context's steps.
        t_s: session time of sending; a time that has passed means at once.
        why: evidence in words, for the decision log.
        person: the dancer whose event led to the decision, or "".
        last_resort: whether the command is only sent if nothing better comes, so that ``t_s`` is not the time at which
            the step is expected.
    """

    iteration: int
    ordinal: int
    t_s: float
    why: str
    person: str = ""
    last_resort: bool = False


@dataclass(frozen=True, slots=True)
class CancelCommand:
    """Answer of a method: do not send the command that is scheduled for a step."""

    iteration: int
    ordinal: int
    why: str


@dataclass(frozen=True, slots=True)
class SetTimer:
    """Answer of a method: call ``on_timer(t_s)`` at this session time, which must lie in the future."""

    t_s: float


MethodAction = ScheduleCommand | CancelCommand | SetTimer
