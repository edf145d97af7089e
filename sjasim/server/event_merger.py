"""Merges the reports of several clients into one stream of events: session time, dancers' names, each event once."""

from __future__ import annotations

from bisect import bisect_left

from ..choreography.timetable import Timetable
from ..core import DeviceEvent, Event, Kind

SAME_MOVE_S = 0.4
"""Two reports of one kind and person closer than this are one event [s]: half of the shortest move (.8 s)."""

_KEPT_TIMES = 4
"""Latest event times kept for each person and kind. Reports of one event arrive within a few frames of each other."""

_MIRRORED = {
    Kind.START_FORWARD: Kind.START_BACKWARD,
    Kind.START_BACKWARD: Kind.START_FORWARD,
    Kind.STOP_FORWARD: Kind.STOP_BACKWARD,
    Kind.STOP_BACKWARD: Kind.STOP_FORWARD,
}
"""Kind of a move as a sensor behind the person sees it -> what the person does."""


class EventMerger:
    """Turns accepted reports into events and drops duplicates; around a hand-over two clients report each event.

    Args:
        timetable: windows of the iterations.
        clap_refractory_s: shortest time between two claps of a person [s]; closer reports are one clap.
    """

    def __init__(self, timetable: Timetable, clap_refractory_s: float) -> None:
        self._clap_refractory_s = clap_refractory_s
        self._first = timetable.first
        self._closes_s = [timetable.close_s(i) for i in range(timetable.first, timetable.last + 1)]
        self._latest_s: dict[tuple[str, Kind, bool], list[float]] = {}
        """(person, kind, early) -> session times of the latest events [s]."""

    def merge(
        self, report: DeviceEvent, person: str, t_s: float, t_arrival_s: float, *, mirrored: bool = False
    ) -> Event | None:
        """Turn a client's report into an event.

        Args:
            report: as the client sent it.
            person: the dancer's name.
            t_s: session time of the report [s].
            t_arrival_s: session time of its arrival [s].
            mirrored: whether the client sees the person from behind and therefore confuses forward and backward.

        Returns:
            the event, or None if an earlier report of the same event has been merged already.
        """
        # Corrected before the comparison: the client that sees the front reports the true kind.
        kind = _MIRRORED.get(report.kind, report.kind) if mirrored else report.kind
        merged_s = self._latest_s.setdefault((person, kind, report.early), [])
        min_gap_s = self._clap_refractory_s if kind is Kind.CLAP else SAME_MOVE_S
        for earlier_s in merged_s:
            if abs(t_s - earlier_s) < min_gap_s:
                return None

        merged_s.append(t_s)
        del merged_s[:-_KEPT_TIMES]
        return Event(person, kind, t_s, t_arrival_s, report.early, self._iteration_at(t_s), report.sensor)

    def _iteration_at(self, t_s: float) -> int:
        """The iteration whose window holds a session time, as `Timetable.iteration_at` but faster."""
        return self._first + min(bisect_left(self._closes_s, t_s), len(self._closes_s) - 1)
