"""A scripted hall: four clients with their own clocks, dancers who stand and turn, and the server."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from sjasim.assets.names import CARDINALS
from sjasim.choreography.layout import layout
from sjasim.choreography.paper import paper
from sjasim.choreography.timetable import Timetable
from sjasim.config import SessionConfig
from sjasim.core import ClientOrder, ClientStatus, DeviceEvent, Kind, PersonStatus, SyncReply, SyncRequest
from sjasim.core.clock import DeviceClock
from sjasim.core.tempo import TempoMap
from sjasim.server import Server

CONFIG = SessionConfig()
LAYOUT = layout(CONFIG)
TIMETABLE = Timetable(paper(), TempoMap.steady(118), 4.0, 0, 4)
DELAY_S = 0.02


class Hall:
    """Runs a server on a grid of 10 ms with clients that report, answer and detect as told.

    Attributes:
        yaw: (t_s, dancer) -> heading of a dancer; by default they turn from beat 32.5 to 36.
        silent: sensor -> session time from which it sends nothing.
        hidden: (sensor, t_s) -> whether the sensor sees nobody.
        hands: (sensor, t_s, dancer) -> share of the dancer's hands that the sensor sees.
    """

    def __init__(self, clocks=None):
        self.server = Server(TIMETABLE, LAYOUT, CONFIG)
        offsets = clocks or {name: DeviceClock(0.3 - 0.2 * i, 40e-6) for i, name in enumerate(CARDINALS)}
        self.clocks = offsets
        self.silent = {}
        self.hidden = lambda sensor, t_s: False
        self.hands = lambda sensor, t_s, dancer: 1.0
        self.yaw = self.turning
        self.orders = []
        self.actives = []
        self.events = []
        self._inbox = []
        self._tick = 0

    @staticmethod
    def turning(t_s, dancer):
        """Heading of a dancer who turns to the music."""
        iteration = 0
        while iteration < 4 and t_s >= TIMETABLE.time_s(iteration, 36.0):
            iteration += 1
        share = (t_s - TIMETABLE.time_s(iteration, 32.5)) / (3.5 * 60 / 118)
        return TIMETABLE.heading_rad(iteration) + math.pi / 2 * min(max(share, 0.0), 1.0)

    @property
    def notices(self):
        """The server's, without the dancers of whom the script has no events."""
        return [notice for notice in self.server.notices if not notice.what.startswith("no event seen")]

    def send(self, sensor, t_s, message):
        """Send a message from a sensor that is not silent."""
        if t_s < self.silent.get(sensor, math.inf):
            self._inbox.append((t_s + DELAY_S, message))

    def detect(self, sensor, t_s, dancer, kind, early=False):
        """A client detects an event at session time ``t_s``; local identities are 10 x sensor + dancer."""
        person = 10 * CARDINALS.index(sensor) + dancer
        self.send(sensor, t_s, DeviceEvent(sensor, person, Kind(kind), self.clocks[sensor].reading(t_s), early))

    def run(self, until_s):
        """Let time pass; returns the events of that time."""
        first = len(self.events)
        while self._tick * 0.01 < until_s:
            t_s = self._tick * 0.01
            if self._tick % 20 == 0:
                for sensor in CARDINALS:
                    self.send(sensor, t_s, self._status(sensor, t_s))
            for message in self.server.due_messages(t_s) if t_s >= self.server.next_due_s - 1e-9 else ():
                if isinstance(message, ClientOrder):
                    self.orders.append((t_s, message))
                elif isinstance(message, SyncRequest):
                    reading = self.clocks[message.sensor].reading(t_s + DELAY_S)
                    reply = SyncReply(message.sensor, message.t_server_send_s, reading, reading)
                    self.send(message.sensor, t_s + DELAY_S, reply)
            arrived = sorted((item for item in self._inbox if item[0] <= t_s), key=lambda item: item[0])
            self._inbox = [item for item in self._inbox if item[0] > t_s]
            for at, message in arrived:
                self.events += self.server.receive(at, message)
            if not self.actives or self.actives[-1][1] != self.server.active:
                self.actives.append((t_s, self.server.active))
            self._tick += 1
        return self.events[first:]

    def _status(self, sensor, t_s):
        base = 10 * CARDINALS.index(sensor)
        people = tuple(
            PersonStatus(base + i, float(x), float(y), self.yaw(t_s, i), 0.9, self.hands(sensor, t_s, i))
            for i, (x, y) in enumerate(LAYOUT.dancers)
        )
        return ClientStatus(sensor, self.clocks[sensor].reading(t_s), () if self.hidden(sensor, t_s) else people)


@pytest.fixture
def hall():
    """A fresh hall."""
    return Hall()


@pytest.fixture
def world():
    """The music, the layout and the configuration."""
    return SimpleNamespace(timetable=TIMETABLE, layout=LAYOUT, config=CONFIG, np=np, Hall=Hall)
