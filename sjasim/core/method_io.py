"""What a method is told before the dance, and what it may answer with; clocks as in `types`."""

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
        ordinal: its place in the iteration, from 0.
        kind: the human event it answers (a clap stands for the robot's turn).
        occurrence: how many events of this kind come before it in the iteration.
        beat: nominal beat inside the iteration.
    """

    ordinal: int
    kind: Kind
    occurrence: int
    beat: float


@dataclass(frozen=True, slots=True)
class MethodContext:
    """All that an anticipation method is told before the dance: never the truth, never the dancers' plan.

    Attributes:
        cast: names of the dancers.
        steps: the robot's events of one iteration, in order.
        iterations: how many iterations will be danced.
        beat_s: nominal length of a beat; a dance's tempo may change about it.
        iteration_start_s: session time of beat 0 of each iteration, index 0 being the rehearsal.
        window_end_s: session time at which each iteration's window closes, same index.
        tempo: session time of the music's beats, counted from anywhere; steady at ``beat_s`` if not given.
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
        """The beat of an iteration, and fraction of one, at a session time."""
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
    """A method's answer: send the command for this step at this time, unless replaced or withdrawn.

    Attributes:
        iteration: which iteration.
        ordinal: which of the context's steps.
        t_s: session time of sending; a time that has passed means at once.
        why: evidence in words, for the decision log.
        person: the dancer whose event decided it, or "".
        last_resort: sent only if nothing better comes: its time is not when the step is expected.
    """

    iteration: int
    ordinal: int
    t_s: float
    why: str
    person: str = ""
    last_resort: bool = False


@dataclass(frozen=True, slots=True)
class CancelCommand:
    """A method's answer: do not send the command for this step after all."""

    iteration: int
    ordinal: int
    why: str


@dataclass(frozen=True, slots=True)
class SetTimer:
    """A method's answer: call ``on_timer(t_s)`` at this session time, which must lie in the future."""

    t_s: float


MethodAction = ScheduleCommand | CancelCommand | SetTimer
