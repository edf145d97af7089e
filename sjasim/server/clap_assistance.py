"""Which clients help with claps: people whose hands the active client does not see are looked at from the side."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Sequence

from ..choreography.timetable import Timetable
from ..core import Kind

UNSEEN_S = 1.0
"""Hands count as unseen for so long after a report of the active client that lacks them: five reports. Hanging hands
may be hidden where raised ones are not, and the other way round (assumed)."""


class ClapAssistance:
    """The one exception to "only the active client's events count".

    A clap that another client reports counts if it lies within ``side_clap_window_s`` of a beat on which the score has a clap
    and the active client, in a report of the last `UNSEEN_S` before it, did not see both hands of that person. With
    ``side_clap_window_s`` 0 none does.

    Args:
        cast: names of the dancers.
        timetable: when claps are due.
        side_clap_window_s: half the width of the window around each.
    """

    def __init__(self, cast: Sequence[str], timetable: Timetable, side_clap_window_s: float) -> None:
        self._cast = tuple(cast)
        beats = [step.beat for step in timetable.choreography.steps() if step.kind is Kind.CLAP]
        span = range(timetable.first, timetable.last + 1) if side_clap_window_s > 0.0 else ()
        self._due_s = sorted(timetable.time_s(iteration, beat) for iteration in span for beat in beats)
        self._assist_s = side_clap_window_s
        self._unseen_s = dict.fromkeys(self._cast, -math.inf)

    def saw(self, t_s: float, hands: Iterable[str]) -> None:
        """The active client's report of session time ``t_s``: of whom it sees both hands."""
        for name in set(self._cast).difference(hands):
            self._unseen_s[name] = t_s

    def window(self, t_s: float) -> bool:
        """Whether a clap is due about session time ``t_s``."""
        after = bisect_left(self._due_s, t_s - self._assist_s)
        return after < len(self._due_s) and self._due_s[after] <= t_s + self._assist_s

    def unseen(self, t_s: float) -> list[str]:
        """Whose hands the active client did not see lately; nobody's outside the windows."""
        if not self.window(t_s):
            return []
        return [name for name, since_s in self._unseen_s.items() if t_s - since_s <= UNSEEN_S]

    def counts(self, name: str, t_s: float) -> bool:
        """Whether a clap of session time ``t_s`` counts that a client other than the active one reports."""
        return name in self.unseen(t_s)
