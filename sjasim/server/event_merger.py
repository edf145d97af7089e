"""One stream of events from several clients: each event of the dance once, in session time, by name."""

from __future__ import annotations

from bisect import bisect_left

from ..choreography.timetable import Timetable
from ..core import DeviceEvent, Event, Kind

SAME_S = 0.4
"""Two reports of one person's move this close are one event: less than the shortest move (.8 s)."""

_MIRRORED = {
    Kind.START_FORWARD: Kind.START_BACKWARD,
    Kind.START_BACKWARD: Kind.START_FORWARD,
    Kind.STOP_FORWARD: Kind.STOP_BACKWARD,
    Kind.STOP_BACKWARD: Kind.STOP_FORWARD,
}


class EventMerger:
    """Turns device events that count into events, each once: two clients overlap at a hand-over.

    Args:
        timetable: whose windows divide the events into iterations.
        clap_refractory_s: shortest time between two claps of one person: two reports closer than that are one.
    """

    def __init__(self, timetable: Timetable, clap_refractory_s: float) -> None:
        self._clap_rest_s = clap_refractory_s
        self._first = timetable.first
        self._closes_s = [timetable.close_s(i) for i in range(timetable.first, timetable.last + 1)]
        self._latest_s: dict[tuple[str, Kind, bool], list[float]] = {}

    def iteration_at(self, t_s: float) -> int:
        """The iteration whose window holds this session time (`Timetable.iteration_at`, looked up)."""
        return self._first + min(bisect_left(self._closes_s, t_s), len(self._closes_s) - 1)

    def merge(
        self, report: DeviceEvent, person: str, t_s: float, t_arrival_s: float, *, mirrored: bool = False
    ) -> Event | None:
        """Take in one report of a client that counts.

        Args:
            report: as the client sent it.
            person: cast name of whom it is about.
            t_s: session time of the report.
            t_arrival_s: session time of its arrival.
            mirrored: whether the client sees the person's back, and takes forward for backward.

        Returns:
            the event, or None if it has been counted already.
        """
        kind = _MIRRORED.get(report.kind, report.kind) if mirrored else report.kind
        counted = self._latest_s.setdefault((person, kind, report.early), [])
        same_s = self._clap_rest_s if kind is Kind.CLAP else SAME_S
        if any(abs(t_s - before) < same_s for before in counted):
            return None
        counted.append(t_s)
        del counted[:-4]
        return Event(person, kind, t_s, t_arrival_s, report.early, self.iteration_at(t_s), report.sensor)
