"""Who dances: a member of the cast of whom a whole iteration shows nothing is reported."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..choreography.score import Timetable
from ..logs import Notice
from ..types import Event

WAIT_S = 0.5
"""How long after the window's end its last events may arrive: some 20 times the network's delay (assumed)."""


class RollCall:
    """Counts everybody's regular events, iteration by iteration.

    Args:
        cast: names of the dancers.
        timetable: when the windows close.
    """

    def __init__(self, cast: Sequence[str], timetable: Timetable) -> None:
        self._cast = tuple(cast)
        self._closes = [(timetable.close_s(i) + WAIT_S, i) for i in range(timetable.first, timetable.last + 1)]
        self._seen: set[tuple[int, str]] = set()
        self.next_due_s = self._closes[0][0]
        """Session time of the next call; infinite after the last."""

    def saw(self, event: Event) -> None:
        """Somebody did something; early events do not count."""
        if not event.early:
            self._seen.add((event.iteration, event.person))

    def judge(self, t_s: float) -> list[Notice]:
        """Who was missing in the windows that have closed by session time ``t_s``."""
        notices: list[Notice] = []
        while self.next_due_s <= t_s:
            _, iteration = self._closes.pop(0)
            missing = [name for name in self._cast if (iteration, name) not in self._seen]
            self.next_due_s = self._closes[0][0] if self._closes else math.inf
            notices += [Notice(t_s, name, f"no event seen in iteration {iteration}") for name in missing]
        return notices
