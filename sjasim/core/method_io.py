"""Input and output of anticipation methods: the context before a dance, and the actions that hooks return."""

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
    """One event that the robot is to perform in every iteration of the choreography.

    Attributes:
        ordinal: place of the event in the iteration, from 0.
        kind: kind of the corresponding event of the dancers; CLAP where the robot turns.
        occurrence: number of events of this kind that come before it in the iteration.
        beat: nominal beat of the event in the iteration.
    """

    ordinal: int
    kind: Kind
    occurrence: int
    beat: float


@dataclass(frozen=True, slots=True)
class MethodContext:
    """Information that an anticipation method has before a dance. It excludes ground truth and the dancers' plan.

    Attributes:
        cast: names of the dancers.
        steps: the robot's events of one iteration, in order.
        iterations: number of iterations after the rehearsal.
        beat_s: nominal duration of a beat, from which the tempo of a dance may deviate.
        iteration_start_s: session time of beat 0 of each iteration; index 0 is the rehearsal.
        window_end_s: session time at which the window of each iteration closes, with the same indices.
        tempo: map from beats to session times, with an arbitrary beat as origin; None if every beat lasts ``beat_s``.
        tau_s: two events of a kind coincide if they are less than this apart, as in the measures of the session.
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
        """Return the fractional beat, counted from beat 0 of an iteration, at session time ``t_s``."""
        start_s = self.iteration_start_s[iteration]
        if self.tempo is None:
            return (t_s - start_s) / self.beat_s
        return self.tempo.beat(t_s) - self.tempo.beat(start_s)

    def time_s(self, iteration: int, beat: float) -> float:
        """Return the session time of a beat that is counted from beat 0 of an iteration [s]."""
        start_s = self.iteration_start_s[iteration]
        if self.tempo is None:
            return start_s + beat * self.beat_s
        return self.tempo.time_s(self.tempo.beat(start_s) + beat)


@dataclass(frozen=True, slots=True)
class ScheduleCommand:
    """Action: send the command for a step at a session time, unless a later action replaces or cancels it.

    Attributes:
        iteration: iteration of the step.
        ordinal: index of the step in `MethodContext.steps`.
        t_s: session time of sending. The command is sent at once if this time has passed.
        why: reason of the decision, for the decision log.
        person: name of the dancer whose event led to the decision, or "".
        last_resort: whether the command is a fallback, to be sent only if no event triggers the step before. Its
            ``t_s`` is then not an estimate of when the step will happen.
    """

    iteration: int
    ordinal: int
    t_s: float
    why: str
    person: str = ""
    last_resort: bool = False


@dataclass(frozen=True, slots=True)
class CancelCommand:
    """Action: do not send the command that is scheduled for a step."""

    iteration: int
    ordinal: int
    why: str


@dataclass(frozen=True, slots=True)
class SetTimer:
    """Action: call ``on_timer(t_s)`` at session time ``t_s``, which must lie in the future."""

    t_s: float


MethodAction = ScheduleCommand | CancelCommand | SetTimer
