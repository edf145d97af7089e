"""Who dances: a member of the cast of whom an iteration, or the rest of one, shows nothing is reported."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..choreography.timetable import Timetable
from ..core import Event
from ..core.session_log import Notice

WAIT_S = 0.5
"""How long after the window's end its last events may arrive: some 20 times the network's delay (assumed)."""


BEHIND_S = 1.5
"""So long after the music a dancer may do a step before it counts as left out (assumed)."""

LEFT_OUT = 3
"""With so many steps left out at its end a window is reported: somebody's last phrase is hidden now and then, the clap
after it rarely (three are left out in one of some 400 windows with the default layout)."""


class AttendanceMonitor:
    """Counts everybody's regular events, iteration by iteration.

    Args:
        cast: names of the dancers.
        timetable: when the windows close, and when which step is due.
    """

    def __init__(self, cast: Sequence[str], timetable: Timetable) -> None:
        self._cast = tuple(cast)
        self._timetable = timetable
        self._steps = timetable.choreography.steps()
        self._closes = [(timetable.close_s(i) + WAIT_S, i) for i in range(timetable.first, timetable.last + 1)]
        self._seen: dict[tuple[int, str], tuple[int, float]] = {}
        self.next_due_s = self._closes[0][0]
        """Session time of the next call; infinite after the last."""

    def saw(self, event: Event) -> None:
        """Somebody did something; early events do not count."""
        if not event.early:
            key = (event.iteration, event.person)
            count, last_s = self._seen.get(key, (0, event.t_s))
            self._seen[key] = (count + 1, max(last_s, event.t_s))

    def judge(self, t_s: float) -> list[Notice]:
        """Who was missing in the windows that have closed by session time ``t_s``, or missing from some time on."""
        notices: list[Notice] = []
        while self.next_due_s <= t_s:
            _, iteration = self._closes.pop(0)
            self.next_due_s = self._closes[0][0] if self._closes else math.inf
            for name in self._cast:
                if what := self._absence(iteration, name):
                    notices.append(Notice(t_s, name, what))
        return notices

    def _absence(self, iteration: int, name: str) -> str:
        """What to report of one dancer in a closed window, or ""."""
        if (iteration, name) not in self._seen:
            return f"no event seen in iteration {iteration}"
        count, last_s = self._seen[iteration, name]
        due_s = (self._timetable.time_s(iteration, step.beat) for step in self._steps)
        if sum(time > last_s + BEHIND_S for time in due_s) < LEFT_OUT:
            return ""
        return f"no event seen in iteration {iteration} after {count} of {len(self._steps)}"
