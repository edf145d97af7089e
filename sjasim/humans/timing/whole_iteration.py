"""Base of timing models that decide an iteration as a whole, because nothing that happens in it changes it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from ...choreography.timetable import Timetable
from ...config.session import MAX_DANCERS
from ...core import Array, BoolArray, Cue
from ...core.errors import ConfigError
from .cue_assembly import ordered_times_s, performed_cues
from .human_timing import ObservedRobotEvent

DECISION_LEAD_S = 1.5
"""Time from the decision for an iteration to its first event [s]; bodies show a move 1.2 s before it."""


class WholeIterationTiming(ABC):
    """Implements `HumanTiming` around the event times of an iteration, which a model plans.

    The robot has no influence. Moves and holds are at least as long as people can make them, and lapses leave out whole
    phrases; see `cue_assembly`.

    Args:
        timetable: the dance in session time.
        dancers: number of dancers.
        performance: generator of this performance.
        lapse: probability that a dancer leaves out a phrase or a clap.

    Raises:
        ConfigError: the number of dancers is not 1 to `MAX_DANCERS`.
    """

    def __init__(self, timetable: Timetable, dancers: int, performance: np.random.Generator, lapse: float) -> None:
        if isinstance(dancers, bool) or not 1 <= dancers <= MAX_DANCERS:
            raise ConfigError("dancers", dancers, f"1 to {MAX_DANCERS} dancers")

        self._timetable = timetable
        self._dancers = dancers
        self._rng = performance
        self._lapse = lapse
        self._beats = np.array([step.beat for step in timetable.choreography.steps()])
        self._begun: tuple[int, Array, BoolArray] | None = None

    @abstractmethod
    def _planned_times_s(self, iteration: int) -> Array:
        """(D, E) session times at which the dancers plan the events of an iteration [s]."""

    @property
    def next_due_s(self) -> float:
        """See `HumanTiming.next_due_s`."""
        return math.inf if self._begun is None else float(self._begun[1].min()) - DECISION_LEAD_S

    def begin(self, iteration: int, appropriateness_s: float | None, not_before_s: Array) -> None:
        """See `HumanTiming.begin`."""
        lapses: BoolArray = self._rng.random((self._dancers, len(self._beats))) < self._lapse
        times_s = ordered_times_s(self._planned_times_s(iteration), not_before_s)
        self._begun = iteration, times_s, lapses

    def decide(self, now_s: float, robot: Sequence[ObservedRobotEvent]) -> tuple[tuple[Cue, ...], ...]:
        """See `HumanTiming.decide`."""
        if self._begun is None:
            return ((),) * self._dancers

        iteration, times_s, lapses = self._begun
        self._begun = None
        return performed_cues(self._timetable, iteration, times_s, lapses)

    def _music_s(self, iteration: int) -> Array:
        """(E,) session times of the events in the music [s]."""
        return np.array([self._timetable.time_s(iteration, beat) for beat in self._beats])
