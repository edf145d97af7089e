"""What a method remembers: who did what when, by iteration, relative to the music."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from ..core import Array, Event, Kind
from ..core.method_io import MethodContext
from .synchrony import Series
from .timing_appropriateness import ideal_times, match_to_steps


def nominal_times(context: MethodContext, iteration: int) -> Array:
    """(K,) times of the context's steps after beat 0 of an iteration, by the music alone [s]."""
    start_s = context.iteration_start_s[iteration]
    return np.array([context.time_s(iteration, step.beat) - start_s for step in context.steps])


class EventHistory:
    """Regular events of the cast by iteration and person, and the schedule that follows from them.

    Early events and persons outside the cast are not kept. Times are relative to beat 0 of their iteration.

    Args:
        context: the dance.
        epsilon_s: width of a cluster's links [s].
    """

    def __init__(self, context: MethodContext, epsilon_s: float) -> None:
        self._context = context
        self._epsilon_s = epsilon_s
        self._events: dict[int, dict[str, list[tuple[float, Kind]]]] = defaultdict(
            lambda: {person: [] for person in context.cast}
        )
        self.schedule = nominal_times(context, 0)
        """(K,) the last schedule, after beat 0 [s]; nominal beats until an iteration has been learnt."""

    def add(self, event: Event) -> None:
        """Remember an event."""
        if event.early or event.person not in self._context.cast:
            return
        after = event.t_s - self._context.iteration_start_s[event.iteration]
        self._events[event.iteration][event.person].append((after, event.kind))

    def series(self, iteration: int) -> dict[str, Series]:
        """Times after beat 0 [s] and kinds of every member of the cast; empty where nothing was seen."""
        return {
            person: ([time for time, _ in events], [kind for _, kind in events])
            for person, events in self._events[iteration].items()
        }

    def times(self, iteration: int) -> Array:
        """(D, K) time of each step by each member of the cast, after beat 0 [s], NaN where missing."""
        nominal = nominal_times(self._context, iteration)
        rows = [
            match_to_steps(times, kinds, self._context.steps, nominal)
            for times, kinds in self.series(iteration).values()
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
        ideal = ideal_times(self.times(iteration), self._epsilon_s, min(2, len(self._context.cast)))
        fresh = np.isfinite(ideal)
        self.schedule = np.where(fresh, ideal, self.schedule)
        return tuple(bool(new) for new in fresh)
