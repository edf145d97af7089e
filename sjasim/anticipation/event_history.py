"""What a method remembers: who did what when, by iteration, relative to the music."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from ..core import Array, Event, Kind
from ..core.method_io import MethodContext
from .synchrony import Series
from .timing_appropriateness import ideal_times, occurrences


def nominal_times(brief: MethodContext, iteration: int) -> Array:
    """(K,) times of the brief's steps after beat 0 of an iteration, by the music alone [s]."""
    start_s = brief.iteration_start_s[iteration]
    return np.array([brief.time_s(iteration, step.beat) - start_s for step in brief.steps])


class History:
    """Regular events of the cast by iteration and person, and the schedule that follows from them.

    Early events and persons outside the cast are not kept. Times are relative to beat 0 of their iteration.

    Args:
        brief: the dance.
        epsilon_s: width of a cluster's links [s].
    """

    def __init__(self, brief: MethodContext, epsilon_s: float) -> None:
        self._brief = brief
        self._epsilon_s = epsilon_s
        self._events: dict[int, dict[str, list[tuple[float, Kind]]]] = defaultdict(
            lambda: {person: [] for person in brief.cast}
        )
        self.schedule = nominal_times(brief, 0)
        """(K,) the last schedule, after beat 0 [s]; nominal beats until an iteration has been learnt."""

    def add(self, event: Event) -> None:
        """Remember an event."""
        if event.early or event.person not in self._brief.cast:
            return
        after = event.t_s - self._brief.iteration_start_s[event.iteration]
        self._events[event.iteration][event.person].append((after, event.kind))

    def series(self, iteration: int) -> dict[str, Series]:
        """Times after beat 0 [s] and kinds of every member of the cast; empty where nothing was seen."""
        return {
            person: ([time for time, _ in events], [kind for _, kind in events])
            for person, events in self._events[iteration].items()
        }

    def times(self, iteration: int) -> Array:
        """(D, K) time of each step by each member of the cast, after beat 0 [s], NaN where missing."""
        nominal = nominal_times(self._brief, iteration)
        rows = [
            occurrences(times, kinds, self._brief.steps, nominal) for times, kinds in self.series(iteration).values()
        ]
        return np.array(rows)

    def learn(self, iteration: int) -> tuple[bool, ...]:
        """Turn an iteration's events into the schedule of the next one.

        A step that fewer than two dancers did together (or, in a group of one, that nobody did) keeps its last
        time.

        Returns:
            for each step whether its time is new.

        Source: iqbal2016, section III-B.
        """
        ideal = ideal_times(self.times(iteration), self._epsilon_s, min(2, len(self._brief.cast)))
        fresh = np.isfinite(ideal)
        self.schedule = np.where(fresh, ideal, self.schedule)
        return tuple(bool(new) for new in fresh)
