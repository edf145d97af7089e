"""Fusion of all sensor clients into one stream of events in session time."""

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
"""Starting event of a move -> the event that ends it."""

ORDER_INTERVAL_S = 0.5
"""Interval at which every client is told again whether to detect, so that a lost order does no harm [s]."""

MAX_REPORT_AGE_S = 1.0
"""Age beyond the link's round trip from which a report's time stamp is wrong: its clock has jumped [s]."""

SYNC_BURST = 4
"""Factor by which clock requests are more frequent until the clock has settled: a few seconds after start or jump."""

MIN_FACING = 0.5
"""Least cosine of facing at which events of an expected but not active client count: 60 degrees off."""

BACK_VIEW = -0.5
"""Cosine of facing below which a client sees the person from behind."""

MIN_SIDE_VIEW = math.cos(math.radians(110.0))
"""Least cosine of facing at which a client is asked for claps of a person.

The bearing that the cosine is taken from is that of the whole group. The client's own detector decides with the bearing
of the person, and accepts up to 100 degrees.
"""

ClientMessage = DeviceEvent | ClientStatus | SyncReply
"""What a sensor client sends to the server."""


class Server:
    """Merges the sensor clients into one stream of events in session time.

    Events of the active client count. At a hand-over events of the other expected client count as well if the person
    faces it. An event that both report counts once, so that the overlap neither loses nor doubles events. A client
    that replaces a dead one and sees a person from behind has forward and backward exchanged. Claps are an exception,
    see `ClapAssistance`: around their beat, clients at the side help with hands that the active client does not see.

    The caller passes messages on arrival (`receive`) and asks for outgoing ones (`due_messages`) at `next_due_s`.

    Args:
        timetable: when the iterations are.
        layout: the sensors, and where everyone stands at the start.
        config: rates of the network, and the options of clap detection.

    Attributes:
        notices: what has gone wrong so far: dead clients, jumped clocks, links that lose packets, events of unknown
            persons, dancers without events.
        next_due_s: session time at which `due_messages` has something to do [s].
    """

    def __init__(self, timetable: Timetable, layout: Layout, config: SessionConfig) -> None:
        dancers = len(layout.dancers)
        cast = [dancer_name(index) for index in range(dancers)]
        self._selector = ActiveSensorSelector(timetable, layout, dancers)
        self._identities = IdentityAssigner(cast, layout.dancers)
        self._attendance = AttendanceMonitor(cast, timetable)
        self._assistance = ClapAssistance(cast, timetable, config.detectors.side_clap_window_s)
        self._merger = EventMerger(timetable, config.detectors.clap_refractory_s)
        self._clocks = {sensor: ClockSync() for sensor in self._selector.sensors}
        self._links = {sensor: LinkMonitor(sensor) for sensor in self._clocks}

        # Requests to the clients are spread over the interval, so that the exchanges do not queue behind one another.
        self._sync_interval_s = 1.0 / config.network.sync_hz
        count = len(self._clocks)
        self._sync_due_s = {sensor: index * self._sync_interval_s / count for index, sensor in enumerate(self._clocks)}
        self._next_sync_s = 0.0

        self._order_due_s = 0.0
        self._assistants: frozenset[str] = frozenset()
        self._ordered: tuple[frozenset[str], frozenset[str]] = (frozenset(), frozenset())
        """Detecting and assisting sensors of the last orders."""

        self._unknown: set[tuple[str, int]] = set()
        """(sensor, person) of unknown persons that have been reported."""
        self._started: dict[str, Event] = {}
        """Dancer -> start of the move that has not ended."""
        self._durations_s: dict[tuple[str, Kind], float] = {}
        """(dancer, starting event) -> duration of the last such move [s]."""

        self.notices: list[Notice] = []
        self.next_due_s = 0.0

    @property
    def active(self) -> str:
        """Name of the active client's sensor."""
        return self._selector.name

    def session_time(self, sensor: str, t_device_s: float) -> float:
        """Session time of a sensor's device time, by the present estimate of its clock [s].

        Before the first exchange the clock is unknown, and the device time itself is returned.
        """
        return self._clocks[sensor].session_time(t_device_s)

    def cast_indices(self, sensor: str) -> Mapping[int, int]:
        """A sensor's identities of persons -> indices of dancers. A change of identities gives a new mapping."""
        return self._identities.cast_indices(sensor)

    def receive(self, t_arrival_s: float, message: ClientMessage) -> list[Event]:
        """Process a client's message.

        Args:
            t_arrival_s: session time of arrival [s].
            message: an event, a status report or a clock reply.

        Returns:
            the events that follow from it, at most one.
        """
        sensor = message.sensor
        self.notices += self._selector.mark_alive(t_arrival_s, sensor)

        if isinstance(message, DeviceEvent):
            event = self._merge_event(t_arrival_s, message)
            if event is None:
                return []
            self._update_durations(event)
            self._attendance.add(event)
            return [event]

        if isinstance(message, SyncReply):
            self._links[sensor].reply_received(message.t_server_send_s)
            jump_s = self._clocks[sensor].add(message, t_arrival_s)
            if jump_s:
                self.notices.append(Notice(t_arrival_s, sensor, f"clock jumped by {jump_s:+.3f} s"))
            return []

        if message.persons is not None:
            self._update_persons(t_arrival_s, message, message.persons)
        return []

    def due_messages(self, t_s: float) -> list[SyncRequest | ClientOrder]:
        """Messages to the clients that are due by session time ``t_s``: clock requests, and orders to detect."""
        self.notices += self._selector.select(t_s)
        if self._attendance.next_due_s <= t_s:
            self.notices += self._attendance.check(t_s)

        messages: list[SyncRequest | ClientOrder] = []
        if self._next_sync_s <= t_s:
            messages += self._clock_requests(t_s)

        detecting = self._selector.detecting(t_s)
        if self._assistants or self._assistance.in_window(t_s):
            self._assistants = self._select_assistants(t_s)
        if t_s >= self._order_due_s or (detecting, self._assistants) != self._ordered:
            messages += self._orders(detecting)
            self._order_due_s = t_s + ORDER_INTERVAL_S
            self._ordered = (detecting, self._assistants)

        self.next_due_s = min(self._order_due_s, self._attendance.next_due_s, self._next_sync_s)
        return messages

    def _clock_requests(self, t_s: float) -> list[SyncRequest | ClientOrder]:
        """Clock requests to the clients for which one is due; each link is checked for packet loss on this occasion."""
        requests: list[SyncRequest | ClientOrder] = []
        for sensor, due_s in self._sync_due_s.items():
            if due_s > t_s:
                continue
            requests.append(SyncRequest(sensor, t_s))
            link = self._links[sensor]
            self.notices += link.check_loss(t_s, alive=self._selector.is_alive(sensor))
            link.request_sent(t_s)

            # Due times stay on their grid: a late call skips requests instead of shifting all later ones.
            interval_s = self._sync_interval_s if self._clocks[sensor].settled else self._sync_interval_s / SYNC_BURST
            missed = int((t_s - due_s) / interval_s)
            self._sync_due_s[sensor] = due_s + (missed + 1) * interval_s

        self._next_sync_s = min(self._sync_due_s.values())
        return requests

    def _orders(self, detecting: frozenset[str]) -> list[ClientOrder]:
        """One order for each client: whether to detect, and whether to look out for claps from the side."""
        return [
            ClientOrder(
                sensor,
                sensor in detecting,
                self._known_durations(sensor) if sensor in detecting else (),
                sensor in self._assistants,
            )
            for sensor in self._clocks
        ]

    def _update_persons(self, t_arrival_s: float, status: ClientStatus, persons: Sequence[PersonStatus]) -> None:
        """Update identities, active sensor and visible hands with a client's status report."""
        sensor = status.sensor
        t_s = self._to_session_time(sensor, status.t_device_s, t_arrival_s)
        self._identities.update(sensor, t_s, persons)
        self._selector.update(t_arrival_s, sensor, persons)
        self.notices += self._selector.select(t_arrival_s)

        if sensor == self.active:
            self._assistance.update(t_s, self._with_both_hands(sensor, persons))

    def _with_both_hands(self, sensor: str, persons: Sequence[PersonStatus]) -> list[str]:
        """Dancers of whom a client sees both hands."""
        names = (self._identities.name(sensor, person.person) for person in persons if person.hands == 1.0)
        return [name for name in names if name is not None]

    def _select_assistants(self, t_s: float) -> frozenset[str]:
        """Sensors that look out for claps from the side; a sensor that has begun goes on to the end of the window."""
        if not self._assistance.in_window(t_s):
            return frozenset()
        unseen = self._assistance.unseen(t_s)
        able = (sensor for sensor in self._clocks for name in unseen if self._has_side_view(sensor, name))
        return (self._assistants | frozenset(able)) - {self.active}

    def _has_side_view(self, sensor: str, name: str) -> bool:
        """Whether a client is alive and sees a dancer at least from the side."""
        person = self._identities.person_id(sensor, name)
        if person is None or not self._selector.is_alive(sensor):
            return False
        return self._selector.facing(sensor, person) >= MIN_SIDE_VIEW

    def _known_durations(self, sensor: str) -> tuple[MoveDuration, ...]:
        """Durations of the dancers' last moves, for the persons that a sensor knows.

        A client that becomes active needs them to detect the early end of a move.
        """
        return tuple(
            MoveDuration(person, start, duration_s)
            for (name, start), duration_s in self._durations_s.items()
            if (person := self._identities.person_id(sensor, name)) is not None
        )

    def _update_durations(self, event: Event) -> None:
        """Update the duration of a dancer's last move when its regular stop follows its regular start."""
        if event.early:
            return
        if event.kind in _STOP_OF:
            self._started[event.person] = event
            return
        start = self._started.pop(event.person, None)
        if start is not None and _STOP_OF[start.kind] is event.kind:
            self._durations_s[event.person, start.kind] = event.t_s - start.t_s

    def _merge_event(self, t_arrival_s: float, report: DeviceEvent) -> Event | None:
        """The event that a client's report gives rise to; None if the report does not count or is a duplicate."""
        sensor = report.sensor
        name = self._identities.name(sensor, report.person)
        if name is None:
            self._report_unknown(t_arrival_s, sensor, report.person)
            return None

        t_s = self._to_session_time(sensor, report.t_device_s, t_arrival_s)
        facing = self._selector.facing(sensor, report.person)
        expected = self._selector.expected(t_s)
        is_faced = sensor == self.active or (sensor in expected and facing >= MIN_FACING)
        assists = report.kind is Kind.CLAP and self._assistance.accepts(name, t_s)
        if not (is_faced or assists):
            return None

        # Only a replacement sees the dancers from behind; an expected sensor that does so sees them in a turn.
        mirrored = sensor not in expected and facing < BACK_VIEW
        return self._merger.merge(report, name, t_s, t_arrival_s, mirrored=mirrored)

    def _report_unknown(self, t_s: float, sensor: str, person: int) -> None:
        """Add a notice of an event of an unknown person, once for each person."""
        if (sensor, person) in self._unknown:
            return
        self._unknown.add((sensor, person))
        self.notices.append(Notice(t_s, sensor, f"event of unknown person {person}"))

    def _to_session_time(self, sensor: str, t_device_s: float, t_arrival_s: float) -> float:
        """Session time of a report [s]; from its arrival while the clock is unknown or has obviously jumped."""
        clock = self._clocks[sensor]
        if not clock.locked:
            return t_arrival_s

        t_s = clock.session_time(t_device_s)
        round_trip_s = clock.round_trip_s
        is_future = t_s > t_arrival_s + round_trip_s / 2 + MARGIN_S
        is_old = t_s < t_arrival_s - round_trip_s - MAX_REPORT_AGE_S
        if is_future or is_old:
            return t_arrival_s - round_trip_s / 2
        return t_s
