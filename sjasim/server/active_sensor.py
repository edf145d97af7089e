"""Which client counts: the one the dancers face, while it lives."""

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
"""Beat of an iteration from which the next client watches too: while people turn to it."""

SILENCE_S = 1.0
"""A client that says nothing for so long is dead: five reports missed."""

PRIOR = 0.5
"""What the iteration's own client has ahead of the others, in units of a full view of everyone (assumed): dancers
who forget to turn are still seen by the client they face."""

HYSTERESIS = 0.1
"""What a client must have ahead of the active one to take over."""

FROM_BEHIND = 0.5
"""Worth of seeing somebody's back: better than a side, from which no move is seen, worse than a face."""

STALE_S = 1.25
"""Age at which a report says nothing any more: an idle client has then lost two frames running."""


@dataclass(slots=True)
class _Client:
    bearing_rad: float
    heard_s: float = 0.0
    alive: bool = True
    view: float = 0.0
    seen: int = 0
    viewed_s: float = -math.inf
    facing: dict[int, float] = field(default_factory=dict)


class ActiveSensorSelector:
    """Choice of the active client, and knowledge of which clients live.

    The iteration is the prior: each has a sensor that its heading points to, the next one's joining at
    `OVERLAP_BEAT` and the last one's leaving at beat 0. Within it, and against it if the evidence is strong, counts
    who is faced and how well they see.

    Args:
        timetable: when the iterations are.
        layout: where the sensors are; bearings are taken from the middle of everyone's slots.
        group: number of dancers.
    """

    def __init__(self, timetable: Timetable, layout: Layout, group: int) -> None:
        centre = layout.dancers.mean(axis=0)
        self._clients = {
            mount.name: _Client(math.atan2(mount.position[1] - centre[1], mount.position[0] - centre[0]))
            for mount in layout.mounts
        }
        self._group = max(group, 1)
        span = range(timetable.first, timetable.last + 1)
        faced = [self._sensor_at(timetable.heading_rad(iteration)) for iteration in span]
        # Who is likely in each iteration, before and after the next client joins.
        self._likely = [(frozenset([own]), frozenset([own, then])) for own, then in pairwise([*faced, faced[-1]])]
        self._starts_s = [timetable.start_s(iteration) for iteration in span]
        self._joins_s = [timetable.time_s(iteration, OVERLAP_BEAT) for iteration in span]
        self._settled_until_s = -math.inf
        self.name = faced[0]
        """The active client's sensor."""

    @property
    def sensors(self) -> tuple[str, ...]:
        """All sensors."""
        return tuple(self._clients)

    def expected(self, t_s: float) -> frozenset[str]:
        """Sensors that the iteration makes likely: one, or at a turn two."""
        index = max(bisect_right(self._starts_s, t_s) - 1, 0)
        return self._likely[index][t_s >= self._joins_s[index]]

    def watching(self, t_s: float) -> frozenset[str]:
        """Sensors that should detect at full rate: the active one, and at a hand-over both concerned."""
        expected = self.expected(t_s)
        return expected if self.name in expected else expected | {self.name}

    def facing(self, sensor: str, person: int) -> float:
        """Cosine between a person's heading and the direction of the sensor: 1 face to face; 0 if not known."""
        return self._clients[sensor].facing.get(person, 0.0)

    def lives(self, sensor: str) -> bool:
        """Whether a client has been heard lately."""
        return self._clients[sensor].alive

    def heard(self, t_s: float, sensor: str) -> list[Notice]:
        """A client has given a sign of life at session time ``t_s``."""
        client = self._clients[sensor]
        client.heard_s = max(client.heard_s, t_s)
        if client.alive:
            return []
        client.alive = True
        self._settled_until_s = -math.inf
        return [Notice(t_s, sensor, "client is back")]

    def report(self, t_s: float, sensor: str, persons: Sequence[PersonStatus]) -> None:
        """Take in whom a client sees, and how they stand."""
        client = self._clients[sensor]
        view = 0.0
        client.facing = {}
        for person in persons:
            turned = person.yaw_rad - client.bearing_rad
            facing = math.cos(turned) if math.isfinite(turned) else 0.0
            client.facing[person.person] = facing
            view += person.tracked * (facing if facing > 0.0 else -FROM_BEHIND * facing)
        client.view = view / self._group
        client.seen = len(persons)
        client.viewed_s = t_s
        self._settled_until_s = -math.inf

    def choose(self, t_s: float) -> list[Notice]:
        """Bring the choice up to date; the notices say which client died and who took over for it.

        Between two reports nothing changes it but time, which does so at known instants: until the next of them there
        is nothing to do.
        """
        if t_s < self._settled_until_s:
            return []
        notices: list[Notice] = []
        for name, client in self._clients.items():
            if client.alive and t_s - client.heard_s > SILENCE_S:
                client.alive = False
                notices.append(Notice(t_s, name, f"client is dead: silent for more than {SILENCE_S:g} s"))
        best, best_score, own_score = self._best(t_s)
        if best_score != -math.inf and best_score > own_score + HYSTERESIS:
            if not self._clients[self.name].alive:
                notices.append(Notice(t_s, best, f"client takes over from {self.name}"))
            self.name = best
        self._settled_until_s = self._next_change_s(t_s)
        return notices

    def _best(self, t_s: float) -> tuple[str, float, float]:
        """Who sees the dance best, how well, and how well the active client does; minus infinity for not at all."""
        expected = self.expected(t_s)
        best, best_score, own_score = "", -math.inf, -math.inf
        for name, client in self._clients.items():
            prior, fresh = name in expected, t_s - client.viewed_s <= STALE_S
            if client.alive and (prior or (fresh and client.seen)):
                score = (client.view if fresh else 0.0) + (PRIOR if prior else 0.0)
                if score > best_score:
                    best, best_score = name, score
                if name == self.name:
                    own_score = score
        return best, best_score, own_score

    def _next_change_s(self, t_s: float) -> float:
        """When the choice may change without a report: a client falls silent, its view goes stale, another is expected.

        A microsecond early, for rounding's sake.
        """
        limit_s = math.inf
        for client in self._clients.values():
            if client.alive:
                limit_s = min(limit_s, client.heard_s + SILENCE_S)
            if client.viewed_s + STALE_S >= t_s:
                limit_s = min(limit_s, client.viewed_s + STALE_S)
        for marks_s in (self._starts_s, self._joins_s):
            after = bisect_right(marks_s, t_s)
            if after < len(marks_s):
                limit_s = min(limit_s, marks_s[after])
        return limit_s - 1e-6

    def _sensor_at(self, heading_rad: float) -> str:
        order = [name for name in CARDINALS if name in self._clients] or list(self._clients)
        return max(order, key=lambda name: math.cos(heading_rad - self._clients[name].bearing_rad))
