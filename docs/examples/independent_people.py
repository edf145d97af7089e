"""A human timing model in one file: every dancer keeps to the music alone, with noise of its own.

python3 scripts/launch.py run --humans independent_people:IndependentPeople
"""

import math
from collections.abc import Sequence

import numpy as np

from sjasim.choreography.timetable import Timetable
from sjasim.core import Array, Cue, dancer_name
from sjasim.humans.timing.human_timing import ObservedRobotEvent

NOISE_S = 0.08
"""Standard deviation of each move's begin [s]."""


class IndependentPeople:
    """Implements `HumanTiming`: nobody corrects towards anybody.

    Args:
        timetable: the dance in session time.
        dancers: number of dancers.
        people: generator of the persons, the same under every method.
        performance: generator of this performance.
    """

    def __init__(
        self, timetable: Timetable, dancers: int, people: np.random.Generator, performance: np.random.Generator
    ) -> None:
        self._timetable = timetable
        # One constant lateness a person: whoever is slow is slow in every performance.
        self._late_s = people.normal(0.0, NOISE_S / 2, dancers)
        self._rng = performance
        self._due_s = math.inf

    @property
    def next_due_s(self) -> float:
        """Session time by which `decide` is to be called; infinite once the iteration is decided."""
        return self._due_s

    def begin(self, iteration: int, appropriateness_s: float | None, not_before_s: Array) -> None:
        """Begin an iteration; it is decided as a whole, two seconds before its beat 0."""
        self._iteration = iteration
        self._not_before_s = not_before_s
        self._due_s = self._timetable.start_s(iteration) - 2.0

    def decide(self, now_s: float, robot: Sequence[ObservedRobotEvent]) -> tuple[tuple[Cue, ...], ...]:
        """Cues of every dancer, in order of time."""
        self._due_s = math.inf
        return tuple(self._cues(dancer) for dancer in range(len(self._late_s)))

    def _cues(self, dancer: int) -> tuple[Cue, ...]:
        cues = []
        free_s = float(self._not_before_s[dancer])
        choreography = self._timetable.choreography

        for index, item in enumerate(choreography.moves):
            nominal_s = self._timetable.time_s(self._iteration, item.beat)
            end_s = self._timetable.time_s(self._iteration, item.beat + item.beats)
            begin_s = max(nominal_s + self._late_s[dancer] + self._rng.normal(0.0, NOISE_S), free_s)
            ordinal = choreography.first_ordinal(index)
            cue = Cue(dancer_name(dancer), item.move, self._iteration, ordinal, item.beat, begin_s, end_s - nominal_s)
            cues.append(cue)
            # Two moves of one dancer do not overlap.
            free_s = begin_s + cue.duration_s + 0.2

        return tuple(cues)
