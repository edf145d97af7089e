"""Reports dancers with no events in an iteration, or with none after some step of it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..choreography.timetable import Timetable
from ..core import Event
from ..core.session_log import Notice

ARRIVAL_MARGIN_S = 0.5
"""Time after the end of an iteration's window in which its last events may still arrive [s].

About 20 times the default delay of the network (assumed).
"""

LATE_STEP_S = 1.5
"""Delay behind the music up to which a dancer's step is late rather than left out [s] (assumed)."""

MIN_LEFT_OUT = 3
"""Number of steps left out at the end of an iteration from which it is reported.

The last phrase of a dancer is sometimes hidden from the sensor, the clap after it rarely: with the default layout
three steps are missing in about one of 400 iterations in which the dancer did them.
"""


class AttendanceMonitor:
    """Counts the regular events of each dancer and reports dancers who are missing from an iteration.

    Args:
        cast: names of the dancers.
        timetable: when the windows of the iterations end, and when each step is due.

    Attributes:
        next_due_s: session time at which `check` is to be called next [s]; infinite after the last iteration.
    """

    def __init__(self, cast: Sequence[str], timetable: Timetable) -> None:
        self._cast = tuple(cast)
        self._timetable = timetable
        self._steps = timetable.choreography.steps()
        self._open = [
            (timetable.close_s(iteration) + ARRIVAL_MARGIN_S, iteration)
            for iteration in range(timetable.first, timetable.last + 1)
        ]
        self._attended: dict[tuple[int, str], tuple[int, float]] = {}
        """(iteration, dancer) -> number of events and session time of the last one [s]."""
        self.next_due_s = self._open[0][0]

    def add(self, event: Event) -> None:
        """Count an event. Early events are left out, because a regular event follows them."""
        if event.early:
            return
        key = (event.iteration, event.person)
        count, last_s = self._attended.get(key, (0, event.t_s))
        self._attended[key] = (count + 1, max(last_s, event.t_s))

    def check(self, t_s: float) -> list[Notice]:
        """Notices of dancers missing from the iterations that have ended by session time ``t_s``.

        Each iteration is checked once.
        """
        notices: list[Notice] = []
        while self.next_due_s <= t_s:
            _, iteration = self._open.pop(0)
            self.next_due_s = self._open[0][0] if self._open else math.inf

            for name in self._cast:
                absence = self._absence(iteration, name)
                if absence:
                    notices.append(Notice(t_s, name, absence))
        return notices

    def _absence(self, iteration: int, name: str) -> str:
        """Text of the notice for one dancer in an iteration that has ended, or "" if there is nothing to report."""
        if (iteration, name) not in self._attended:
            return f"no event seen in iteration {iteration}"

        count, last_s = self._attended[iteration, name]
        due_s = (self._timetable.time_s(iteration, step.beat) for step in self._steps)
        left_out = sum(time_s > last_s + LATE_STEP_S for time_s in due_s)
        if left_out < MIN_LEFT_OUT:
            return ""
        return f"no event seen in iteration {iteration} after {count} of {len(self._steps)}"
