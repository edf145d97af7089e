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
"""Interval at which orders are repeated to every client, so that the loss of one has no lasting effect [s]."""

MAX_REPORT_AGE_S = 1.0
"""Age of a report, beyond the link's round trip, from which its clock is assumed to have jumped [s]."""

SYNC_BURST = 4
"""Factor on the rate of clock requests until the clock has settled, a few seconds after the start or a jump."""

MIN_FACING = 0.5
"""Smallest cosine of the facing angle (60 degrees) at which events of an expected, inactive client are accepted."""

BACK_VIEW = -0.5
"""Cosine of the facing angle below which a client sees the person from behind."""

MIN_SIDE_VIEW = math.cos(math.radians(110.0))
"""Smallest cosine of the facing angle at which a client is ordered to detect claps of a person from the side.

This angle uses the bearing of the whole group. The detector in the client uses the bearing of the person and accepts
angles up to 100 degrees.
"""

ClientMessage = DeviceEvent | ClientStatus | SyncReply
"""Messages that a sensor client sends to the server."""


class Server:
    """Merges the sensor clients into one stream of events in session time.

    Events are accepted from the active client. During a hand-over they are also accepted from the other expected
    client, if the person faces it. An event that both clients report is accepted once, so that the overlap neither
    loses nor duplicates events. If the client that replaces a dead one sees a person from behind, the kinds forward and
    backward of its events are exchanged. Around the beat of a clap, claps are also accepted from clients at the side,
    for dancers whose hands the active client does not see; see `ClapAssistance`.

    The caller passes each message on arrival to `receive`, and calls `due_messages` at `next_due_s`.

    Args:
        timetable: session times of the iterations.
        layout: poses of the sensors, and initial positions of the dancers and the robot.
        config: configuration of the session, of which the network and the clap detection are used.
        continuous: whether the clients report all the time. Without, the server exchanges no clocks, because device
            times are session times, and sends no orders.

    Attributes:
        notices: problems so far: dead clients, clock jumps, links that lose packets, events of unknown persons, dancers
            without events.
        next_due_s: session time at which `due_messages` is to be called next [s].
    """

    def __init__(self, timetable: Timetable, layout: Layout, config: SessionConfig, *, continuous: bool = True) -> None:
        dancers = len(layout.dancers)
        cast = [dancer_name(index) for index in range(dancers)]
        self._selector = ActiveSensorSelector(timetable, layout, dancers, continuous=continuous)
        self._identities = IdentityAssigner(cast, layout.dancers)
        self._attendance = AttendanceMonitor(cast, timetable)
        self._assistance = ClapAssistance(cast, timetable, config.detectors.side_clap_window_s)
        self._merger = EventMerger(timetable, config.detectors.clap_refractory_s)
        self._clocks = {sensor: ClockSync() for sensor in self._selector.sensors}
        self._links = {sensor: LinkMonitor(sensor) for sensor in self._clocks}

        self._continuous = continuous
        # Spread the requests to the clients over the interval, so that the exchanges do not delay one another.
        self._sync_interval_s = 1.0 / config.network.sync_hz
        count = len(self._clocks)
        self._sync_due_s = {sensor: index * self._sync_interval_s / count for index, sensor in enumerate(self._clocks)}
        self._next_sync_s = 0.0

        self._order_due_s = 0.0
        self._assistants: frozenset[str] = frozenset()
        self._ordered: tuple[frozenset[str], frozenset[str]] = (frozenset(), frozenset())
        """Sensors that the last orders told to detect, and to assist."""

        self._unknown: set[tuple[str, int]] = set()
        """(sensor, person) of unknown persons for which a notice exists."""
        self._started: dict[str, Event] = {}
        """Dancer -> regular start of the move in progress."""
        self._durations_s: dict[tuple[str, Kind], float] = {}
        """(dancer, starting event) -> duration of the last such move [s]."""

        self.notices: list[Notice] = []
        self.next_due_s = 0.0 if continuous else self._attendance.next_due_s

    @property
    def active(self) -> str:
        """Name of the active client's sensor."""
        return self._selector.name

    def session_time(self, sensor: str, t_device_s: float) -> float:
        """Convert a sensor's device time to session time with the present estimate of its clock [s].

        Before the first clock exchange the device time is returned unchanged.
        """
        return self._clocks[sensor].session_time(t_device_s)

    def cast_indices(self, sensor: str) -> Mapping[int, int]:
        """Return the mapping from a sensor's person identities to dancer indices.

        The mapping is not modified later; a change of identities creates a new one.
        """
        return self._identities.cast_indices(sensor)

    def receive(self, t_arrival_s: float, message: ClientMessage) -> list[Event]:
        """Process a client's message.

        Args:
            t_arrival_s: session time of arrival [s].
            message: an event, a status report or a clock reply.

        Returns:
            the resulting events: at most one.
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
        """Return the messages to the clients that are due by session time ``t_s``: clock requests and orders."""
        self.notices += self._selector.select(t_s)
        if self._attendance.next_due_s <= t_s:
            self.notices += self._attendance.check(t_s)
        if not self._continuous:
            self.next_due_s = self._attendance.next_due_s
            return []

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
        """Return the clock requests that are due, and check their links for packet loss."""
        requests: list[SyncRequest | ClientOrder] = []
        for sensor, due_s in self._sync_due_s.items():
            if due_s > t_s:
                continue
            requests.append(SyncRequest(sensor, t_s))
            link = self._links[sensor]
            self.notices += link.check_loss(t_s, alive=self._selector.is_alive(sensor))
            link.request_sent(t_s)

            # Keep due times on a fixed grid: a late call skips requests instead of shifting all later ones.
            interval_s = self._sync_interval_s if self._clocks[sensor].settled else self._sync_interval_s / SYNC_BURST
            missed = int((t_s - due_s) / interval_s)
            self._sync_due_s[sensor] = due_s + (missed + 1) * interval_s

        self._next_sync_s = min(self._sync_due_s.values())
        return requests

    def _orders(self, detecting: frozenset[str]) -> list[ClientOrder]:
        """Return one order for each client: whether to detect events, and whether to detect claps from the side."""
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
        """Names of the dancers whose hands are both tracked by a client."""
        names = (self._identities.name(sensor, person.person) for person in persons if person.hands == 1.0)
        return [name for name in names if name is not None]

    def _select_assistants(self, t_s: float) -> frozenset[str]:
        """Select the sensors that detect claps from the side; each stays selected until the window ends."""
        if not self._assistance.in_window(t_s):
            return frozenset()
        unseen = self._assistance.unseen(t_s)
        able = (sensor for sensor in self._clocks for name in unseen if self._has_side_view(sensor, name))
        return (self._assistants | frozenset(able)) - {self.active}

    def _has_side_view(self, sensor: str, name: str) -> bool:
        """Whether a client is alive and sees a dancer from the front or the side."""
        person = self._identities.person_id(sensor, name)
        if person is None or not self._selector.is_alive(sensor):
            return False
        return self._selector.facing(sensor, person) >= MIN_SIDE_VIEW

    def _known_durations(self, sensor: str) -> tuple[MoveDuration, ...]:
        """Durations of the dancers' last moves, for the persons that a sensor has identified.

        A client that becomes active needs them to detect early stops, see `DetectorConfig.early_move_share`.
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
        """Convert a client's report to an event; None if the report is rejected or a duplicate."""
        sensor = report.sensor
        name = self._identities.name(sensor, report.person)
        if name is None:
            self._report_unknown(t_arrival_s, sensor, report.person)
            return None

        t_s = self._to_session_time(sensor, report.t_device_s, t_arrival_s)
        facing = self._selector.facing(sensor, report.person)
        if sensor != self.active:
            is_faced = facing >= MIN_FACING and sensor in self._selector.expected(t_s)
            assists = report.kind is Kind.CLAP and self._assistance.accepts(name, t_s)
            if not (is_faced or assists):
                return None

        # Only a client that replaces a dead one faces the dancers' backs. An expected sensor sees a back only while the
        # dancer turns, so its kinds are not exchanged.
        mirrored = facing < BACK_VIEW and sensor not in self._selector.expected(t_s)
        return self._merger.merge(report, name, t_s, t_arrival_s, mirrored=mirrored)

    def _report_unknown(self, t_s: float, sensor: str, person: int) -> None:
        """Add a notice of an event of an unknown person, once for each person."""
        if (sensor, person) in self._unknown:
            return
        self._unknown.add((sensor, person))
        self.notices.append(Notice(t_s, sensor, f"event of unknown person {person}"))

    def _to_session_time(self, sensor: str, t_device_s: float, t_arrival_s: float) -> float:
        """Session time of a report [s], estimated from its arrival if the clock is unknown or has evidently jumped."""
        if not self._continuous:
            return t_device_s
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
