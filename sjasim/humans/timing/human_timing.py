"""The protocol of human timing models."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from ...core import Array, Cue, Kind

ObservedRobotEvent = tuple[Kind, float]
"""An event of the robot that people observed: its kind and its session time [s]."""


@runtime_checkable
class HumanTiming(Protocol):
    """A human timing model: it decides at what times each dancer begins and ends the moves of the dance.

    A model of your own is a class whose constructor takes ``(timetable, dancers, people, performance)``: the
    `Timetable`, the number of dancers, and two random generators. ``people`` is the same for every method, so that the
    same persons meet all methods; ``performance`` differs from one performance to the next.

    The session calls `begin` for each iteration, and `decide` whenever `next_due_s` has come, until `next_due_s` is
    infinite.
    """

    @property
    def next_due_s(self) -> float:
        """Session time by which `decide` is to be called again [s]; infinite once the iteration is decided."""
        ...

    def begin(self, iteration: int, appropriateness_s: float | None, not_before_s: Array) -> None:
        """Begin an iteration.

        Args:
            iteration: its index. Iterations are begun once each, in order, after the one before is decided.
            appropriateness_s: mean timing error of the robot in the iteration before [s], or None if it did not move.
            not_before_s: (D,) earliest session time at which each dancer can begin [s].
        """
        ...

    def decide(self, now_s: float, robot: Sequence[ObservedRobotEvent]) -> tuple[tuple[Cue, ...], ...]:
        """The further cues of each dancer, in order of time.

        A dancer who leaves out a move has no cue for it.

        Args:
            now_s: present session time [s]; no cue may begin before it.
            robot: events of the robot in this iteration that people have observed so far.
        """
        ...
