"""`SensorClient`: the computer behind one sensor.

It captures frames, detects events in them, reports where persons are, and answers clock exchanges of the server.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from ..choreography.layout import Mount
from ..config import DetectorConfig, SensorConfig
from ..core import (
    ClientOrder,
    ClientStatus,
    DeviceEvent,
    SceneView,
    SkeletonFrame,
    Skeletons,
    SyncReply,
    SyncRequest,
)
from ..core.clock import DeviceClock, Task, Ticks
from .events.detectors import EventDetector
from .events.side_view_claps import SideClapDetector
from .person_status import person_statuses, sensor_pose
from .skeleton_source import SkeletonSource

ROUNDING_S = 1e-9
"""Tolerance within which two session times count as equal [s]."""


class _PendingFrame(NamedTuple):
    """A frame that is being processed.

    Attributes:
        t_s: session time at which it was captured.
        skeletons: what it shows; None if a report is due and no frame was captured for it.
        detect: whether the client detected events when it captured the frame.
        assist: whether the client detected claps from the side then.
        report: whether a status report goes out with it.
    """

    t_s: float
    skeletons: Skeletons | None
    detect: bool
    assist: bool
    report: bool


class SensorClient:
    """The client of one sensor.

    The client is in one of three modes, which the server orders. It detects all events and captures every frame; or it
    assists, which means that it captures every frame and detects only claps of persons whom it sees from the side; or
    it is on standby and captures ``standby_hz`` frames a second, at times when a status report is due. A report for
    which a client on standby captures no frame names no persons.

    A frame that is captured at t is processed ``latency_frames`` / ``rate_hz`` later. Its events carry the device time
    of that later moment. If a frame is lost, the report that is due with it goes out with the next frame. Events of
    frames that were captured before the order to detect, or that are processed after an order to stop, are not sent.

    When detection starts, the detectors are reset: a person must first be seen standing and facing the sensor. A
    hand-over during a turn therefore creates no event.

    Args:
        mount: pose of the sensor in the world; statuses are in world coordinates.
        source: source of the skeletons.
        detector_config: thresholds of the detectors.
        sensor_config: frame rate, report rate and latency.
        clock: clock of the device.
        dead_from_s: session time from which the client neither captures nor sends nor answers anything.

    Attributes:
        name: name of the sensor.
        detecting: whether the client is ordered to detect all events.
        assisting: whether the client is ordered to detect claps from the side.
        latest_frame: the frame that was processed last, or None before the first one.
        next_capture_s: session time from which `capture_frame` has to be called.
        next_output_s: session time at which the next frame has been processed; infinite if none is in process.
    """

    def __init__(
        self,
        mount: Mount,
        source: SkeletonSource,
        detector_config: DetectorConfig,
        sensor_config: SensorConfig,
        clock: DeviceClock,
        *,
        dead_from_s: float = math.inf,
    ) -> None:
        self.name = mount.name
        self.detecting = False
        self.assisting = False
        self.latest_frame: SkeletonFrame | None = None
        self.next_capture_s = 0.0
        self.next_output_s = math.inf

        self._source = source
        self._clock = clock
        self._dead_from_s = dead_from_s
        self._pose = sensor_pose(mount)
        self._detector = EventDetector(detector_config, sensor_config.rate_hz)
        self._side_detector = SideClapDetector(detector_config)
        self._pending: deque[_PendingFrame] = deque()
        self._t_first_s = math.nan

        # Both tasks count in ticks of the frame rate.
        self._rate_hz = sensor_config.rate_hz
        self._latency_s = sensor_config.latency_frames / sensor_config.rate_hz
        ticks = Ticks(self._rate_hz)
        self._report_task = Task(ticks, sensor_config.status_hz)
        self._standby_task = Task(ticks, sensor_config.standby_hz)
        self._report_due = False
        self._standby_frame_due = False

    def is_detecting(self, t_s: float) -> bool:
        """Return whether the client is ordered to detect events and is alive at session time ``t_s``."""
        return self.detecting and t_s < self._dead_from_s

    def capture_frame(self, t_s: float, view: SceneView) -> Skeletons | None:
        """Capture a frame if one is wanted.

        Args:
            t_s: session time. Call this at every tick of the frame rate, in order; ticks before ``next_capture_s`` may
                be left out.
            view: the scene at that time.

        Returns:
            the skeletons of the frame, for the session's tables; None if no frame was wanted or it was lost.
        """
        if t_s >= self._dead_from_s:
            return None
        report = self._advance_tasks(t_s)

        if self.detecting or self.assisting or (report and self._standby_frame_due):
            skeletons = self._source.sample(view)
            if skeletons is None:
                return None
            self._standby_frame_due = False
            if math.isnan(self._t_first_s):
                self._t_first_s = t_s
        elif report:
            skeletons = None
        else:
            return None

        if not self._pending:
            self.next_output_s = t_s + self._latency_s
        self._pending.append(_PendingFrame(t_s, skeletons, self.detecting, self.assisting, self._report_due))
        self._report_due = False
        return skeletons

    def pop_messages(self, t_s: float) -> list[DeviceEvent | ClientStatus]:
        """Return the messages of all frames that have been processed by session time ``t_s``, oldest first."""
        messages: list[DeviceEvent | ClientStatus] = []
        while self.next_output_s <= t_s + ROUNDING_S:
            ready_s = self.next_output_s
            frame = self._pending.popleft()
            self.next_output_s = self._pending[0].t_s + self._latency_s if self._pending else math.inf
            if ready_s < self._dead_from_s:
                messages.extend(self._process(frame, ready_s))
        return messages

    def handle_message(self, t_arrival_s: float, message: SyncRequest | ClientOrder, t_s: float) -> SyncReply | None:
        """Answer a clock exchange or follow an order; a repeated order changes nothing.

        Args:
            t_arrival_s: session time at which the message arrived.
            message: the server's message.
            t_s: session time at which it is handled, not before ``t_arrival_s``.

        Returns:
            the answer to a clock exchange; None after an order, or if the client is dead.
        """
        if t_s >= self._dead_from_s:
            return None
        if isinstance(message, SyncRequest):
            received_s = self._clock.reading(t_arrival_s)
            sent_s = self._clock.reading(t_s)
            return SyncReply(self.name, message.t_server_send_s, received_s, sent_s)

        if message.watch and not self.detecting:
            self._detector.reset()
            self._detector.set_durations(message.durations)
        if message.assist and not self.assisting:
            self._side_detector.reset()
        self.detecting = message.watch
        self.assisting = message.assist
        self._plan_next_capture()
        return None

    def _advance_tasks(self, t_s: float) -> bool:
        """Note which tasks are due at a frame tick; return whether a report becomes due."""
        tick = math.floor(t_s * self._rate_hz + ROUNDING_S)
        report = tick >= self._report_task.due
        if report:
            self._report_task.advance()
            self._report_due = True
            self._plan_next_capture()
        while tick >= self._standby_task.due:
            self._standby_task.advance()
            self._standby_frame_due = True
        return report

    def _plan_next_capture(self) -> None:
        """Set the time of the next frame: on standby, none is needed before the next report."""
        every_frame = self.detecting or self.assisting
        self.next_capture_s = 0.0 if every_frame else self._report_task.due / self._rate_hz

    def _process(self, pending: _PendingFrame, ready_s: float) -> list[DeviceEvent | ClientStatus]:
        """Return events and status of one frame."""
        t_device_s = self._clock.reading(ready_s)
        if pending.skeletons is None:
            return [ClientStatus(self.name, t_device_s, None)]

        t_capture_device_s = self._clock.reading(pending.t_s)
        t_sensor_s = pending.t_s - self._t_first_s
        frame = SkeletonFrame(self.name, t_device_s, t_capture_device_s, t_sensor_s, pending.skeletons)
        self.latest_frame = frame

        messages: list[DeviceEvent | ClientStatus] = []
        if pending.detect and self.detecting:
            messages.extend(self._detector.update(frame))
        if pending.assist and self.assisting:
            messages.extend(self._side_detector.update(frame))
        if pending.report:
            persons = person_statuses(pending.skeletons, self._pose)
            messages.append(ClientStatus(self.name, t_device_s, persons))
        return messages
