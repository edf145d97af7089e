"""Selection of the active sensor: the client that the dancers face, among those that are alive."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from ..assets.names import CARDINALS
from ..choreography.layout import Layout
from ..choreography.timetable import Timetable
from ..core import PersonStatus
from ..core.session_log import Notice

OVERLAP_BEAT = 34.0
"""Beat of an iteration from which the next iteration's client detects as well: the dancers begin to turn to it."""

SILENCE_S = 1.0
"""A client that has sent nothing for longer than this is dead: five status reports are missing [s]."""

PRIOR = 0.5
"""Score bonus of the sensor that the iteration faces, in units of a full frontal view of all dancers (assumed).

Dancers who forget to turn are still assigned to the client that they face.
"""

HYSTERESIS = 0.1
"""Lead in score that another client needs to replace the active one, so that noise does not switch clients."""

BACK_VIEW_WEIGHT = 0.5
"""Weight of a person seen from behind, relative to a frontal view.

Moves towards the sensor and away from it show from behind, but not from the side.
"""

STALE_S = 1.25
"""Age from which a status report no longer counts [s]: a client on standby has then lost two frames in a row."""

_ROUNDING_S = 1e-6
"""Margin by which a change over time is expected early, so that rounding cannot skip it [s]."""


@dataclass(slots=True)
class _Client:
    """State of one sensor's client, as known to the server.

    Attributes:
        bearing_rad: direction from the middle of the dancers' slots to the sensor, in the world.
        last_message_s: session time of the last message.
        alive: whether the client has sent a message lately.
        view: quality of its view in the last report; 1 if it sees all dancers completely from the front.
        person_count: persons in the last report.
        reported_s: session time of the last report.
        facing: sensor's identity of a person -> cosine between their heading and the direction of the sensor.
    """

    bearing_rad: float
    last_message_s: float = 0.0
    alive: bool = True
    view: float = 0.0
    person_count: int = 0
    reported_s: float = -math.inf
    facing: dict[int, float] = field(default_factory=dict)


class ActiveSensorSelector:
    """Selects the active sensor and monitors which clients are alive.

    Each client has a score: the quality of its view (how completely it sees the dancers, and how frontally), plus
    `PRIOR` if the iteration faces its sensor. At the end of an iteration two sensors have this bonus, from
    `OVERLAP_BEAT` until the next iteration's beat 0. The client with the highest score becomes active if it leads by
    more than `HYSTERESIS`. A client that sees nobody and is not expected is no candidate. Without any candidate the
    active sensor stays.

    Args:
        timetable: when the iterations begin, and which way they face.
        layout: where the sensors and the dancers' slots are.
        dancers: number of dancers.
        continuous: whether the clients report all the time. Without, silence means nothing: no client counts as dead,
            and reports do not become stale.

    Attributes:
        name: the active sensor.
    """

    def __init__(self, timetable: Timetable, layout: Layout, dancers: int, *, continuous: bool = True) -> None:
        centre = layout.dancers.mean(axis=0)
        self._clients = {
            mount.name: _Client(math.atan2(mount.position[1] - centre[1], mount.position[0] - centre[0]))
            for mount in layout.mounts
        }
        self._dancers = max(dancers, 1)
        self._silence_s = SILENCE_S if continuous else math.inf
        self._stale_s = STALE_S if continuous else math.inf

        iterations = range(timetable.first, timetable.last + 1)
        faced = [self._sensor_towards(timetable.heading_rad(iteration)) for iteration in iterations]
        # For each iteration the expected sensors before and after the next client joins.
        self._expected = [
            (frozenset([own]), frozenset([own, following])) for own, following in pairwise([*faced, faced[-1]])
        ]
        self._starts_s = [timetable.start_s(iteration) for iteration in iterations]
        self._overlaps_s = [timetable.time_s(iteration, OVERLAP_BEAT) for iteration in iterations]
        self._valid_until_s = -math.inf
        self.name = faced[0]

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of all sensors."""
        return tuple(self._clients)

    def expected(self, t_s: float) -> frozenset[str]:
        """Sensors that the dance faces at a session time: one, or two around a turn."""
        index = max(bisect_right(self._starts_s, t_s) - 1, 0)
        return self._expected[index][t_s >= self._overlaps_s[index]]

    def detecting(self, t_s: float) -> frozenset[str]:
        """Sensors that should detect at full rate: the expected ones and the active one."""
        expected = self.expected(t_s)
        return expected if self.name in expected else expected | {self.name}

    def facing(self, sensor: str, person: int) -> float:
        """Cosine between a person's heading and the direction of the sensor: 1 face to face, 0 if unknown."""
        return self._clients[sensor].facing.get(person, 0.0)

    def is_alive(self, sensor: str) -> bool:
        """Whether a client has sent a message within the last `SILENCE_S`, as of the last `select`."""
        return self._clients[sensor].alive

    def mark_alive(self, t_s: float, sensor: str) -> list[Notice]:
        """Record that a client has sent a message at session time ``t_s``; a notice if it was dead."""
        client = self._clients[sensor]
        client.last_message_s = max(client.last_message_s, t_s)
        if client.alive:
            return []

        client.alive = True
        self._valid_until_s = -math.inf
        return [Notice(t_s, sensor, "client is back")]

    def update(self, t_s: float, sensor: str, persons: Sequence[PersonStatus]) -> None:
        """Record a client's status report: how well it sees whom, and how they face it.

        Args:
            t_s: session time of the report [s].
            sensor: the client's sensor.
            persons: everyone it sees.
        """
        client = self._clients[sensor]
        client.facing = {}
        view = 0.0
        for person in persons:
            angle_rad = person.yaw_rad - client.bearing_rad
            facing = math.cos(angle_rad) if math.isfinite(angle_rad) else 0.0
            client.facing[person.person] = facing
            view += person.tracked * (facing if facing > 0.0 else -BACK_VIEW_WEIGHT * facing)

        client.view = view / self._dancers
        client.person_count = len(persons)
        client.reported_s = t_s
        self._valid_until_s = -math.inf

    def select(self, t_s: float) -> list[Notice]:
        """Update the active sensor as of session time ``t_s``.

        Returns:
            notices of clients that have died, and of the client that takes over from a dead one.
        """
        # Between reports only time changes the choice, at instants known beforehand; this runs at every control step.
        if t_s < self._valid_until_s:
            return []

        notices: list[Notice] = []
        for name, client in self._clients.items():
            if client.alive and t_s - client.last_message_s > self._silence_s:
                client.alive = False
                notices.append(Notice(t_s, name, f"client is dead: silent for more than {SILENCE_S:g} s"))

        best, best_score, active_score = self._best_client(t_s)
        if best_score != -math.inf and best_score > active_score + HYSTERESIS:
            if not self._clients[self.name].alive:
                notices.append(Notice(t_s, best, f"client takes over from {self.name}"))
            self.name = best

        self._valid_until_s = self._next_change_s(t_s)
        return notices

    def _best_client(self, t_s: float) -> tuple[str, float, float]:
        """Sensor with the highest score, its score, and the active sensor's score.

        The score of a client that is no candidate is minus infinity.
        """
        expected = self.expected(t_s)
        best = ""
        best_score = -math.inf
        active_score = -math.inf

        for name, client in self._clients.items():
            is_expected = name in expected
            is_fresh = t_s - client.reported_s <= self._stale_s
            if client.alive and (is_expected or (is_fresh and client.person_count)):
                score = (client.view if is_fresh else 0.0) + (PRIOR if is_expected else 0.0)
                if score > best_score:
                    best = name
                    best_score = score
                if name == self.name:
                    active_score = score

        return best, best_score, active_score

    def _next_change_s(self, t_s: float) -> float:
        """Session time at which the choice may change without a new report [s].

        This is when a client will have been silent for too long, when a report becomes stale, or when the expected
        sensors change.
        """
        next_s = math.inf
        for client in self._clients.values():
            if client.alive:
                next_s = min(next_s, client.last_message_s + self._silence_s)
            if client.reported_s + self._stale_s >= t_s:
                next_s = min(next_s, client.reported_s + self._stale_s)

        for changes_s in (self._starts_s, self._overlaps_s):
            index = bisect_right(changes_s, t_s)
            if index < len(changes_s):
                next_s = min(next_s, changes_s[index])

        return next_s - _ROUNDING_S

    def _sensor_towards(self, heading_rad: float) -> str:
        """The sensor nearest to a heading; of equally near ones the first in the order of `CARDINALS`."""
        names = [name for name in CARDINALS if name in self._clients] or list(self._clients)
        return max(names, key=lambda name: math.cos(heading_rad - self._clients[name].bearing_rad))
