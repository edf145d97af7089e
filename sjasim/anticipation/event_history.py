"""Events of past iterations by dancer, relative to the music, and the schedule that ECA predicts from them."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from ..core import Array, Event, Kind
from ..core.method_io import MethodContext
from .coincidences import Series
from .timing_appropriateness import ideal_times, match_to_steps


def nominal_times(context: MethodContext, iteration: int) -> Array:
    """(K,) times of the steps by the music alone, after beat 0 of the iteration [s]."""
    start_s = context.iteration_start_s[iteration]
    return np.array([context.time_s(iteration, step.beat) - start_s for step in context.steps])


class EventHistory:
    """Regular events of the dancers by iteration and person, and the schedule predicted from them.

    Early events and events of persons outside the cast are not kept. Times are relative to beat 0 of their iteration.

    Args:
        context: the dance.
        epsilon_s: largest gap between neighbouring times of one cluster [s].

    Attributes:
        schedule: (K,) predicted time of each step after beat 0 [s]; the music's beats until an iteration has been used
            by `update_schedule`.
    """

    def __init__(self, context: MethodContext, epsilon_s: float) -> None:
        self._context = context
        self._epsilon_s = epsilon_s
        self._events: dict[int, dict[str, list[tuple[float, Kind]]]] = defaultdict(
            lambda: {person: [] for person in context.cast}
        )
        self.schedule = nominal_times(context, 0)

    def add(self, event: Event) -> None:
        """Add an event; early ones and those of unknown persons are ignored."""
        if event.early or event.person not in self._context.cast:
            return
        after_s = event.t_s - self._context.iteration_start_s[event.iteration]
        self._events[event.iteration][event.person].append((after_s, event.kind))

    def series(self, iteration: int) -> dict[str, Series]:
        """Times after beat 0 [s] and kinds of the events of each dancer; empty for a dancer without events."""
        return {
            person: ([time for time, _ in events], [kind for _, kind in events])
            for person, events in self._events[iteration].items()
        }

    def step_times(self, iteration: int) -> Array:
        """(D, K) time of each step by each dancer after beat 0 [s], NaN where missing."""
        nominal = nominal_times(self._context, iteration)
        steps = self._context.steps
        rows = [match_to_steps(times, kinds, steps, nominal) for times, kinds in self.series(iteration).values()]
        return np.array(rows)

    def update_schedule(self, iteration: int) -> tuple[bool, ...]:
        """Update the schedule with an iteration's events.

        A step gets the mean time of the main cluster of the dancers' events. It keeps its last time if the cluster has
        fewer than two members (fewer than one if the cast is a single dancer).

        Args:
            iteration: the iteration that has ended.

        Returns:
            K booleans: whether each step has a new time.

        Source: iqbal2016, section III-B; the mean is taken over those who were detected, where the paper divides by 3.
        """
        min_members = min(2, len(self._context.cast))
        ideal = ideal_times(self.step_times(iteration), self._epsilon_s, min_members)
        updated = np.isfinite(ideal)
        # Keep the last time of a step without a new one: it predicts the dancers better than the beat of the music.
        self.schedule = np.where(updated, ideal, self.schedule)
        return tuple(bool(item) for item in updated)
