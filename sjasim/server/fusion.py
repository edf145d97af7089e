"""The server's ear: clocks, persons and clients behind one door, device messages in, events out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ..choreography.layout import Layout
from ..choreography.timetable import Timetable
from ..config import SessionConfig
from ..core import (
    ClientOrder,
    ClientStatus,
    DeviceEvent,
    Event,
    Kind,
    MoveDuration,
    PersonStatus,
    SyncReply,
    SyncRequest,
    dancer_name,
)
from ..core.session_log import Notice
from .active_sensor import ActiveSensorSelector
from .attendance import AttendanceMonitor
from .clap_assistance import ClapAssistance
from .clock_sync import MARGIN_S, ClockSync
from .event_merger import EventMerger
from .identity_assignment import IdentityAssigner
from .link_monitor import LinkMonitor

_STOP_OF = {Kind.START_FORWARD: Kind.STOP_FORWARD, Kind.START_BACKWARD: Kind.STOP_BACKWARD}

ORDER_S = 0.5
"""How often every client is told anew whether to watch, so that a lost order does no harm."""

LATE_S = 1.0
"""A report that seems older than this beyond its link's round trip bears a time of a clock that has jumped."""

BURST = 4
"""So many times as often a clock is asked until it has settled: within seconds of its start or its jump."""

FACED = 0.5
"""Least cosine at which a client that is not the active one counts at a hand-over: 60 degrees."""

BEHIND = -0.5
"""Cosine below which a client sees a back."""

ASIDE = math.cos(math.radians(110.0))
"""Least cosine at which a client is asked to help with a person's clap. Its bearing is the whole group's; whether this
person can be judged from there its detector finds out, which allows 100 degrees."""

ClientMessage = DeviceEvent | ClientStatus | SyncReply


class Server:
    """Merges the clients into one stream of events in session time.

    The active client's events count. At a hand-over those of the other client concerned count as well, if the
    person faces it; what both report counts once, so that the overlap loses none and doubles none. A client that
    stands in for a dead one and sees a person's back has forward and backward exchanged. Claps have an exception of
    their own, `ClapAssistance`: around their beat the clients at the side help with hands that the active one lacks.

    Everything is event-driven: `receive` for what arrives, `due_messages` for what is to be sent, `next_due_s` for when to
    ask again. ``notices`` grows by what went wrong: dead clients, jumped clocks, links that lose packets, reports of
    unknown persons, dancers of whom nothing is seen.

    Args:
        timetable: when the iterations are.
        layout: where everyone stands at the start, and the sensors.
        config: network rates.
    """

    def __init__(self, timetable: Timetable, layout: Layout, config: SessionConfig) -> None:
        group = len(layout.dancers)
        self._active = ActiveSensorSelector(timetable, layout, group)
        cast = [dancer_name(index) for index in range(group)]
        self._persons = IdentityAssigner(cast, layout.dancers)
        self._roll_call = AttendanceMonitor(cast, timetable)
        self._assistance = ClapAssistance(cast, timetable, config.detectors.side_clap_window_s)
        self._helpers: frozenset[str] = frozenset()
        self._merger = EventMerger(timetable, config.detectors.clap_refractory_s)
        self._clocks = {sensor: ClockSync() for sensor in self._active.sensors}
        self._exchanges = {sensor: LinkMonitor(sensor) for sensor in self._clocks}
        self._sync_s = 1.0 / config.network.sync_hz
        # Spread over the interval, so that the exchanges do not queue behind one another.
        count = len(self._clocks)
        self._sync_due_s = {sensor: place * self._sync_s / count for place, sensor in enumerate(self._clocks)}
        self._sync_next_s = 0.0
        self._order_due_s = 0.0
        self._ordered: tuple[frozenset[str], frozenset[str]] = frozenset(), frozenset()
        self._nameless: set[tuple[str, int]] = set()
        self._started: dict[str, Event] = {}
        self._logged: dict[tuple[str, Kind], float] = {}
        self.notices: list[Notice] = []
        self.next_due_s = 0.0
        """Session time at which `due_messages` has something to do."""

    @property
    def active(self) -> str:
        """Sensor of the active client."""
        return self._active.name

    def session_time(self, sensor: str, t_device_s: float) -> float:
        """Session time of a sensor's device time, by the present estimate of its clock [s].

        Before the first exchange nothing is known of the clock, and the device time itself is returned.
        """
        return self._clocks[sensor].session_time(t_device_s)

    def cast_indices(self, sensor: str) -> Mapping[int, int]:
        """A sensor's persons by their places in the cast; once somebody is another one, in another mapping."""
        return self._persons.known(sensor)

    def receive(self, t_arrival_s: float, message: ClientMessage) -> list[Event]:
        """Take in a client's message.

        Args:
            t_arrival_s: session time of arrival.
            message: an event, a status report or a clock exchange.

        Returns:
            the events that follow from it, at most one.
        """
        sensor = message.sensor
        if back := self._active.heard(t_arrival_s, sensor):
            self.notices += back
        if isinstance(message, DeviceEvent):
            event = self._event(t_arrival_s, message)
            if event is None:
                return []
            self._learn(event)
            self._roll_call.saw(event)
            return [event]
        if isinstance(message, SyncReply):
            self._exchanges[sensor].answered(message.t_server_send_s)
            jump = self._clocks[sensor].add(message, t_arrival_s)
            if jump:
                self.notices.append(Notice(t_arrival_s, sensor, f"clock jumped by {jump:+.3f} s"))
            return []
        if message.persons is not None:
            self._look(t_arrival_s, message, message.persons)
        return []

    def due_messages(self, t_s: float) -> list[SyncRequest | ClientOrder]:
        """What is to be sent to the clients by ``t_s``: clock exchanges, and who watches."""
        self.notices += self._active.choose(t_s)
        if self._roll_call.next_due_s <= t_s:
            self.notices += self._roll_call.judge(t_s)
        out: list[SyncRequest | ClientOrder] = []
        if self._sync_next_s <= t_s:
            self._synchronise(t_s, out)
        watching = self._active.watching(t_s)
        if self._helpers or self._assistance.window(t_s):
            self._helpers = self._helping(t_s)
        if t_s >= self._order_due_s or watching != self._ordered[0] or self._helpers != self._ordered[1]:
            out += [
                ClientOrder(sensor, sensor in watching, self._durations(sensor) if sensor in watching else (),
                            sensor in self._helpers)
                for sensor in self._clocks
            ]  # fmt: skip
            self._order_due_s = t_s + ORDER_S
            self._ordered = watching, self._helpers
        self.next_due_s = min(self._order_due_s, self._roll_call.next_due_s, self._sync_next_s)
        return out

    def _synchronise(self, t_s: float, out: list[SyncRequest | ClientOrder]) -> None:
        """Ask the clients whose turn it is what their clocks show."""
        for sensor, due_s in self._sync_due_s.items():
            if due_s <= t_s:
                out.append(SyncRequest(sensor, t_s))
                exchanges = self._exchanges[sensor]
                self.notices += exchanges.judge(t_s, alive=self._active.lives(sensor))
                exchanges.asked(t_s)
                pause_s = self._sync_s if self._clocks[sensor].settled else self._sync_s / BURST
                missed = int((t_s - due_s) / pause_s)
                self._sync_due_s[sensor] = due_s + (missed + 1) * pause_s
        self._sync_next_s = min(self._sync_due_s.values())

    def _look(self, t_arrival_s: float, status: ClientStatus, persons: Sequence[PersonStatus]) -> None:
        """Take in whom a client sees."""
        t_s = self._plausible(status.sensor, status.t_device_s, t_arrival_s)
        self._persons.update(status.sensor, t_s, persons)
        self._active.report(t_arrival_s, status.sensor, persons)
        self.notices += self._active.choose(t_arrival_s)
        if status.sensor == self.active:
            self._assistance.saw(t_s, self._hands(status.sensor, persons))

    def _hands(self, sensor: str, persons: Sequence[PersonStatus]) -> list[str]:
        """Of whom a client sees both hands."""
        names = (self._persons.name(sensor, one.person) for one in persons if one.hands == 1.0)
        return [name for name in names if name is not None]

    def _helping(self, t_s: float) -> frozenset[str]:
        """Sensors that are to look for claps from the side: whoever has begun goes on until the window is over."""
        if not self._assistance.window(t_s):
            return frozenset()
        unseen = self._assistance.unseen(t_s)
        able = (sensor for sensor in self._clocks for name in unseen if self._sees_aside(sensor, name))
        return (self._helpers | frozenset(able)) - {self.active}

    def _sees_aside(self, sensor: str, name: str) -> bool:
        person = self._persons.local(sensor, name)
        if person is None or not self._active.lives(sensor):
            return False
        return self._active.facing(sensor, person) >= ASIDE

    def _durations(self, sensor: str) -> tuple[MoveDuration, ...]:
        """What the other clients logged of everybody, in the terms of one sensor."""
        return tuple(
            MoveDuration(person, start, duration_s)
            for (name, start), duration_s in self._logged.items()
            if (person := self._persons.local(sensor, name)) is not None
        )

    def _learn(self, event: Event) -> None:
        """Keep the duration of a move from its logged events."""
        if event.early:
            return
        if event.kind in _STOP_OF:
            self._started[event.person] = event
        else:
            start = self._started.pop(event.person, None)
            if start is not None and _STOP_OF[start.kind] is event.kind:
                self._logged[event.person, start.kind] = event.t_s - start.t_s

    def _event(self, t_arrival_s: float, report: DeviceEvent) -> Event | None:
        person = self._persons.name(report.sensor, report.person)
        if person is None:
            key = (report.sensor, report.person)
            if key not in self._nameless:
                self._nameless.add(key)
                self.notices.append(Notice(t_arrival_s, report.sensor, f"event of unknown person {report.person}"))
            return None
        t_s = self._plausible(report.sensor, report.t_device_s, t_arrival_s)
        facing = self._active.facing(report.sensor, report.person)
        expected = self._active.expected(t_s)
        faced = report.sensor == self._active.name or (report.sensor in expected and facing >= FACED)
        helps = report.kind is Kind.CLAP and self._assistance.counts(person, t_s)
        if not (faced or helps):
            return None
        mirrored = report.sensor not in expected and facing < BEHIND
        return self._merger.merge(report, person, t_s, t_arrival_s, mirrored=mirrored)

    def _plausible(self, sensor: str, t_device_s: float, t_arrival_s: float) -> float:
        """Session time of a report; by its arrival while the clock is unknown or has visibly jumped."""
        clock = self._clocks[sensor]
        if not clock.locked:
            return t_arrival_s
        t_s = clock.session_time(t_device_s)
        delay_s = clock.round_trip_s
        if t_s > t_arrival_s + delay_s / 2 + MARGIN_S or t_s < t_arrival_s - delay_s - LATE_S:
            return t_arrival_s - delay_s / 2
        return t_s
