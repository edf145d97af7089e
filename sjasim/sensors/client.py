"""The computer behind one sensor: takes frames, detects events, reports status, answers clock exchanges."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..choreography.layout import Mount
from ..config import DetectorConfig, SensorConfig
from ..core import (
    ClientOrder,
    ClientStatus,
    DeviceEvent,
    IntArray,
    PersonStatus,
    SceneView,
    SkeletonFrame,
    Skeletons,
    SyncReply,
    SyncRequest,
)
from ..core.clock import DeviceClock, Task, Ticks
from .events.detectors import Detectors
from .events.frame_features import report
from .events.side_view_claps import AsideDetectors

ROUNDING_S = 1e-9
"""How much later than its time an output still counts as on time [s]."""


class Sensing(Protocol):
    """A way to get skeletons from the stage, such as `joints.JointSensing`.

    ``dancers`` (P,) and ``visible`` (P, 25), who is behind each row (-1 for nobody) and what the last frame could
    see, are for the record only; no client reads them.
    """

    @property
    def dancers(self) -> IntArray:
        """(P,) index of the dancer behind each row, -1 for nobody."""
        ...

    @property
    def visible(self) -> NDArray[np.bool_]:
        """(P, 25) what the last frame could see of them."""
        ...

    def sample(self, view: SceneView) -> Skeletons | None:
        """See the stage at this instant; None if the frame was lost."""
        ...


class _Capture(NamedTuple):
    t_s: float
    skeletons: Skeletons | None
    watched: bool
    assisted: bool
    report: bool


class Client:
    """One sensor's client.

    A frame captured at t is ready ``latency_frames`` / ``rate_hz`` later; what it shows is stamped with the device
    clock of that moment, never back-dated. On request to watch, the client takes every frame and sends events; told to
    assist, it takes every frame and sends only claps that it sees from the side; idle, it takes ``standby_hz`` frames a
    second, at moments when a status report is due, and its other reports are mere signs of life. A status that is due
    with a lost frame goes out with the next one taken. Going from idle to watching, its detectors begin anew: everyone
    must first be seen standing and facing the sensor, so that a hand-over amid a turn gives no event of its own. Events
    of frames taken before the order, or ready after an order to idle, are not sent.

    Args:
        mount: where the sensor is; with it, statuses are in world coordinates.
        sensing: where skeletons come from.
        detector_config: the detectors' thresholds.
        sensor_config: rates and latency.
        clock: the device's own clock.
        dead_from_s: session time from which the client neither takes, sends nor answers anything.

    Attributes:
        name: the sensor's name.
        watching: whether it detects.
        assisting: whether it looks for claps from the side.
        latest: the last frame that was processed, or None before the first; idle, a client processes few.
        next_capture_s: session time from which it may want a frame.
        next_output_s: session time at which the next frame will have been processed; infinite when none is under way.
    """

    def __init__(
        self,
        mount: Mount,
        sensing: Sensing,
        detector_config: DetectorConfig,
        sensor_config: SensorConfig,
        clock: DeviceClock,
        *,
        dead_from_s: float = math.inf,
    ) -> None:
        self.name = mount.name
        self.watching = self.assisting = False
        self._mount = mount
        self._sensing = sensing
        self._clock = clock
        self._dead_from_s = dead_from_s
        self._detectors = Detectors(detector_config, sensor_config.rate_hz)
        self._helpers = AsideDetectors(detector_config)
        self._latency_s = sensor_config.latency_frames / sensor_config.rate_hz
        self._pending: deque[_Capture] = deque()
        self.next_capture_s, self.next_output_s = 0.0, math.inf
        self.latest: SkeletonFrame | None = None
        self._rate_hz = sensor_config.rate_hz
        ticks = Ticks(self._rate_hz)
        self._reports, self._looks = Task(ticks, sensor_config.status_hz), Task(ticks, sensor_config.standby_hz)
        self._report_due = self._look_due = False
        self._t_first_s = math.nan
        towards = -mount.world_from_sensor[:, 2]
        self._bearing_rad = math.atan2(towards[1], towards[0])
        self._pose = np.column_stack([mount.world_from_sensor, mount.position])

    def watches(self, t_s: float) -> bool:
        """Whether it is told to watch and alive."""
        return self.watching and t_s < self._dead_from_s

    def capture(self, t_s: float, view: SceneView) -> Skeletons | None:
        """A frame tick: take the frame, if it is wanted.

        Args:
            t_s: session time, at every tick of the frame rate in order, but for those before ``next_capture_s``.
            view: the stage at that time.

        Returns:
            what it saw, for the record; None if it took no frame or lost it.
        """
        if t_s >= self._dead_from_s:
            return None
        tick = math.floor(t_s * self._rate_hz + ROUNDING_S)
        if report := tick >= self._reports.due:
            self._reports.advance()
            self._report_due = True
            self._plan()
        while tick >= self._looks.due:
            self._looks.advance()
            self._look_due = True
        if self.watching or self.assisting or (report and self._look_due):
            skeletons = self._sensing.sample(view)
            if skeletons is None:
                return None
            self._look_due = False
            if math.isnan(self._t_first_s):
                self._t_first_s = t_s
        elif report:
            skeletons = None
        else:
            return None
        if not self._pending:
            self.next_output_s = t_s + self._latency_s
        self._pending.append(_Capture(t_s, skeletons, self.watching, self.assisting, self._report_due))
        self._report_due = False
        return skeletons

    def outputs(self, t_s: float) -> list[DeviceEvent | ClientStatus]:
        """Everything from frames whose processing is over by session time ``t_s``, oldest first."""
        messages: list[DeviceEvent | ClientStatus] = []
        while self.next_output_s <= t_s + ROUNDING_S:
            ready_s, capture = self.next_output_s, self._pending.popleft()
            self.next_output_s = self._pending[0].t_s + self._latency_s if self._pending else math.inf
            if ready_s < self._dead_from_s:
                messages.extend(self._process(capture, ready_s))
        return messages

    def receive(self, t_arrival_s: float, message: SyncRequest | ClientOrder, t_s: float) -> SyncReply | None:
        """A message from the server; an order repeated changes nothing.

        Args:
            t_arrival_s: session time at which it arrived, and was stamped.
            message: what arrived.
            t_s: session time at which it is dealt with, not before ``t_arrival_s``.

        Returns:
            the answer to a clock exchange, at once, unless the client is dead.
        """
        if t_s >= self._dead_from_s:
            return None
        if isinstance(message, SyncRequest):
            received_s, sent_s = self._clock.reading(t_arrival_s), self._clock.reading(t_s)
            return SyncReply(self.name, message.t_server_send_s, received_s, sent_s)
        if message.watch and not self.watching:
            self._detectors.reset()
            self._detectors.learn(message.durations)
        if message.assist and not self.assisting:
            self._helpers.reset()
        self.watching, self.assisting = message.watch, message.assist
        self._plan()
        return None

    def _plan(self) -> None:
        """Idle, it needs no frame before the next report."""
        self.next_capture_s = 0.0 if self.watching or self.assisting else self._reports.due / self._rate_hz

    def _process(self, capture: _Capture, ready_s: float) -> list[DeviceEvent | ClientStatus]:
        t_device_s = self._clock.reading(ready_s)
        if capture.skeletons is None:
            return [ClientStatus(self.name, t_device_s, None)]
        messages: list[DeviceEvent | ClientStatus] = []
        t_capture_device_s = self._clock.reading(capture.t_s)
        frame = self.latest = SkeletonFrame(
            self.name, t_device_s, t_capture_device_s, capture.t_s - self._t_first_s, capture.skeletons
        )
        if capture.watched and self.watching:
            messages.extend(self._detectors.update(frame))
        if capture.assisted and self.assisting:
            messages.extend(self._helpers.update(frame))
        if capture.report:
            messages.append(self._status(t_device_s, capture.skeletons))
        return messages

    def _status(self, t_device_s: float, skeletons: Skeletons) -> ClientStatus:
        """Report everyone whose SpineBase and hips are known; others are left out."""
        found = np.empty((len(skeletons.joints), 5))
        report(skeletons.joints, skeletons.state, self._pose, self._bearing_rad, found)
        rows = zip(skeletons.persons.tolist(), found.tolist(), strict=True)
        persons = tuple(PersonStatus(person, *row) for person, row in rows if math.isfinite(row[0] + row[1] + row[2]))
        return ClientStatus(self.name, t_device_s, persons)
