"""Acceptance of claps from sensors at the side, for dancers whose hands the active sensor does not see."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Sequence

from ..choreography.timetable import Timetable
from ..core import Kind

UNSEEN_S = 1.0
"""How long hands count as unseen after a report of the active client without them [s]: five reports (assumed).

Hands that hang may be occluded where raised hands are not, and the other way round.
"""


class ClapAssistance:
    """Selects the dancers for whom clients at the side detect claps, and decides which of these claps are accepted.

    All other events are accepted from the active client only. A clap from another client is accepted if it lies within
    ``side_clap_window_s`` of the beat of a clap in the score, and if the active client has reported the dancer without
    both hands within the last `UNSEEN_S` before it.

    Args:
        cast: names of the dancers.
        timetable: when claps are due.
        side_clap_window_s: half the width of the window around each clap's beat [s]; 0 turns the assistance off.
    """

    def __init__(self, cast: Sequence[str], timetable: Timetable, side_clap_window_s: float) -> None:
        self._cast = tuple(cast)
        self._half_width_s = side_clap_window_s
        self._unseen_since_s = dict.fromkeys(self._cast, -math.inf)

        beats = [step.beat for step in timetable.choreography.steps() if step.kind is Kind.CLAP]
        iterations = range(timetable.first, timetable.last + 1) if side_clap_window_s > 0.0 else ()
        self._claps_s = sorted(timetable.time_s(iteration, beat) for iteration in iterations for beat in beats)

    def update(self, t_s: float, visible: Iterable[str]) -> None:
        """Record a report of the active client.

        Args:
            t_s: session time of the report [s].
            visible: dancers of whom it sees both hands.
        """
        # A dancer whom the client does not see at all counts as unseen as well.
        for name in set(self._cast).difference(visible):
            self._unseen_since_s[name] = t_s

    def in_window(self, t_s: float) -> bool:
        """Whether a session time lies in the window around a clap's beat."""
        index = bisect_left(self._claps_s, t_s - self._half_width_s)
        return index < len(self._claps_s) and self._claps_s[index] <= t_s + self._half_width_s

    def unseen(self, t_s: float) -> list[str]:
        """Dancers whose hands the active client has not seen lately; empty outside the windows."""
        if not self.in_window(t_s):
            return []
        return [name for name, since_s in self._unseen_since_s.items() if t_s - since_s <= UNSEEN_S]

    def accepts(self, name: str, t_s: float) -> bool:
        """Whether a clap of this dancer at session time ``t_s`` counts though the active client did not report it."""
        return name in self.unseen(t_s)
