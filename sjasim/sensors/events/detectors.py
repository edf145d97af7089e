"""Detection of events in the skeleton frames of one sensor.

The events of each person are (iqbal2016, section II-B):

* **Start.** SpineBase moves along the sensor's z axis faster than a threshold: ``start_forward`` towards the sensor,
  ``start_backward`` away from it.
* **Stop.** SpineBase becomes slower than a second, lower threshold: ``stop_forward`` or ``stop_backward``, after the
  move that was started.
* **Clap.** The distance of the hands over the distance of the shoulders, in the sensor's x-y plane, has a local minimum
  below a threshold.
* **Early start and early stop.** At least half of SpineMid, Neck and the shoulders start to move, or cease to move,
  from frame to frame, while SpineBase has not crossed its threshold yet. There is no early clap.

Rules and thresholds are in `move_detection` and `clap_detection`; the values are fields of `DetectorConfig`. Nothing
here depends on the choreography. The conditions under which events are detected are:

* **Facing.** Starts and stops are detected while the person faces the sensor, or turns the back to it, within
  `FACING_RAD`. Claps are detected only while the person faces it. A person who stands sideways has no events, and a
  move during which a person turns away has no stop. The kinds refer to the sensor: a person who is seen from behind
  and walks away from the sensor starts *backward*. A caller who knows where people face has to exchange the kinds.
* **First seen standing.** After a reset, after turning towards the sensor, and after `LOST_S` out of sight, a person
  must first be seen standing. A move that is under way then has no events. A person who comes back into sight in the
  same move continues it. Events that occur out of sight are never reported, because their times are unknown.
* **Turns.** While a person turns faster than `TURNING_RAD_S`, the times that arm the start events are restarted.
* **Inferred joints.** Regular events accept an inferred SpineBase. Early events count tracked joints only, because
  errors of inferred joints exceed the floor of a step. A clap needs both hands tracked until shortly before they meet,
  where they occlude each other: the error of an occluded hand is about 10 cm, and a false clap does more harm than a
  missed one.
* **Persons are independent.** A person who appears or disappears does not change the events of the others.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...config import DetectorConfig
from ...core import Array, DeviceEvent, IntArray, Kind, MoveDuration, SkeletonFrame
from ...core.compiled import compiled_entry, compiled_inner
from .clap_detection import clap_time_s, initial_clap_states, may_be_clapping
from .frame_features import extract_features, initial_features
from .move_detection import FACING_RAD, KIND_OF_CODE, NO_EVENT, detect_motion, initial_motion_states
from .thresholds import REFERENCE_RATE_HZ, Record, Records, threshold_row

LONGEST_INFERRED_S = 0.1
"""How long the hands may be inferred as they meet (assumed)."""

CLAP = 3
"""Event code of a clap."""

KINDS = {**KIND_OF_CODE, CLAP: Kind.CLAP}
"""Event code to kind."""

DETECTION = np.dtype([
    ("row", np.int64),  # row of the person in the frame
    ("code", np.int64),  # key of KINDS
    ("early", np.bool_),  # whether it is an early event
    ("t_onset_s", np.float64),  # estimated time of the onset on the sensor's clock; NaN for early events
])  # fmt: skip
"""An event that the last frame shows."""

EVENTS_PER_FRAME = 3
"""Largest number of events of one person in one frame: a clap, an early event and a regular one."""

_DURATION_COLUMN = {Kind.START_FORWARD: "forward_s", Kind.START_BACKWARD: "backward_s"}
"""Column of `MOTION_STATE` with the duration of the last move, by the kind that starts the move."""

_START_OF_STOP = {Kind.STOP_FORWARD: Kind.START_FORWARD, Kind.STOP_BACKWARD: Kind.START_BACKWARD}


class _State(NamedTuple):
    """State of the detection of P persons; F frames are kept in ring buffers.

    Attributes:
        t_frames_s: (F,) times of the last frames on the sensor's clock.
        features: (F, P) `FRAME_FEATURES` of these frames.
        hands: (P,) `CLAP_STATE`.
        motions: (P,) `MOTION_STATE`.
        detections: (3 P,) `DETECTION`, output of a frame.
    """

    t_frames_s: Array
    features: Records
    hands: Records
    motions: Records
    detections: Records


class EventDetector:
    """Detector of the events of all persons in one sensor's frames.

    Args:
        config: thresholds.
        rate_hz: nominal frame rate.
    """

    def __init__(self, config: DetectorConfig, rate_hz: float) -> None:
        self._thresholds = threshold_row(config, rate_hz)
        self._durations_s: dict[tuple[int, Kind], float] = {}
        self._persons: IntArray | None = None
        self._names: list[int] = []
        self._state: _State
        self._frame = 0
        self._set_persons(np.zeros(0, dtype=np.int64))
        self.reset()

    def reset(self) -> None:
        """Forget what was seen: each person must be seen standing again. Durations of moves are kept."""
        self._persons = None

    def set_durations(self, durations: Iterable[MoveDuration]) -> None:
        """Set durations of last moves that other sensors detected; they arm the early stops."""
        for move in durations:
            self._durations_s[move.person, move.start] = move.duration_s
        self._apply_durations()

    def update(self, frame: SkeletonFrame) -> list[DeviceEvent]:
        """Return the events that a frame shows.

        Args:
            frame: skeletons of all persons. Frames come in the order of their times; some may be missing. The state of
                a person who was not in the last frame is initialised.

        Returns:
            the events in the order of the persons, with the time at which the frame had been processed.
        """
        persons, joints, tracking = frame.skeletons
        if persons is not self._persons:
            self._set_persons(persons)

        count = _detect_events(joints, tracking, frame.t_sensor_s, self._frame, self._thresholds, *self._state)
        self._frame += 1
        if not count:
            return []
        return [self._device_event(frame, *row) for row in self._state.detections[:count].tolist()]

    def _device_event(self, frame: SkeletonFrame, row: int, code: int, early: bool, t_onset_s: float) -> DeviceEvent:
        """Return the event of one `DETECTION`; keep the duration of a move that has stopped."""
        person = self._names[row]
        kind = KINDS[code]
        if kind in _START_OF_STOP and not early:
            start = _START_OF_STOP[kind]
            self._durations_s[person, start] = float(self._state.motions[row][_DURATION_COLUMN[start]])

        onset_s = None if early else frame.t_capture_device_s + t_onset_s - frame.t_sensor_s
        return DeviceEvent(frame.sensor, person, kind, frame.t_device_s, early, onset_s)

    def _set_persons(self, persons: IntArray) -> None:
        """Set the person of each row; initialise the state of new persons and keep that of the others."""
        names = persons.tolist()
        if self._persons is not None and names == self._names:
            self._persons = persons
            return

        previous_names = [] if self._persons is None else self._names
        ring_frames = int(self._thresholds["difference_frames"][0]) + 1
        count = len(names)
        state = _State(
            np.zeros(ring_frames),
            initial_features(ring_frames, count),
            initial_clap_states(count),
            initial_motion_states(count),
            np.zeros(EVENTS_PER_FRAME * count, dtype=DETECTION),
        )

        kept = [name for name in names if name in previous_names]
        if kept:
            new_rows = [names.index(name) for name in kept]
            old_rows = [previous_names.index(name) for name in kept]
            state.features[:, new_rows] = self._state.features[:, old_rows]
            state.hands[new_rows] = self._state.hands[old_rows]
            state.motions[new_rows] = self._state.motions[old_rows]
            # The ring buffers go on, so the frame counter does too.
            state = state._replace(t_frames_s=self._state.t_frames_s)
        else:
            self._frame = 0

        self._names = names
        self._state = state
        self._apply_durations()
        self._persons = persons

    def _apply_durations(self) -> None:
        """Write the known durations of last moves to the state of the persons in the frame."""
        for (person, start), duration_s in self._durations_s.items():
            if person in self._names:
                self._state.motions[_DURATION_COLUMN[start]][self._names.index(person)] = duration_s


@compiled_entry
def _detect_events(
    joints: Array,
    tracking: NDArray[np.int8],
    t_s: float,
    frame: int,
    threshold_rows: Records,
    t_frames_s: Array,
    features: Records,
    hands: Records,
    motions: Records,
    detections: Records,
) -> int:
    """Detect the events of all persons in one frame.

    Args:
        joints: (P, 25, 3) joints in the sensor's frame [m].
        tracking: (P, 25) tracking states.
        t_s: time of the frame on the sensor's clock.
        frame: number of frames before this one.
        threshold_rows: (1,) `THRESHOLDS`.
        t_frames_s: (F,) times of the last frames; this frame is at ``frame`` modulo F; changed.
        features: (F, P) `FRAME_FEATURES` of these frames; changed.
        hands: (P,) `CLAP_STATE`; changed.
        motions: (P,) `MOTION_STATE`; changed.
        detections: (3 P,) `DETECTION`, output.

    Returns:
        the number of events.
    """
    thresholds: Record = threshold_rows[0]

    # Places in the ring buffers of this frame and of those that it is compared with.
    ring_frames = len(t_frames_s)
    now = frame % ring_frames
    step_reference = (frame - min(thresholds.step_frames, frame)) % ring_frames
    speed_reference = (frame - thresholds.difference_frames) % ring_frames
    t_frames_s[now] = t_s

    # The floor of a step grows with the time that the step took.
    floor_m = thresholds.early_displacement_m * REFERENCE_RATE_HZ * (t_s - t_frames_s[step_reference])
    span_s = t_s - t_frames_s[speed_reference] if frame >= thresholds.difference_frames else 0.0

    count = 0
    for p in range(len(joints)):
        person = features[now, p]
        extract_features(
            joints[p], tracking[p], features[step_reference, p], features[speed_reference, p], floor_m, span_s, person
        )

        ratio = person.hand_ratio if abs(person.yaw_rad) <= FACING_RAD else math.nan
        t_clap_s = clap_time_s(hands[p], t_s, ratio, person.hands_tracked == 2, LONGEST_INFERRED_S, thresholds)
        clapping = may_be_clapping(hands[p], t_s, thresholds)
        early, regular = detect_motion(motions[p], t_s, person, clapping, thresholds)

        if not math.isnan(t_clap_s):
            count = _append(detections, count, p, CLAP, False, t_clap_s)
        if early != NO_EVENT:
            count = _append(detections, count, p, early, True, math.nan)
        if regular != NO_EVENT:
            # The speed is a mean over span_s, which lags behind the onset by half of that time.
            count = _append(detections, count, p, regular, False, t_s - span_s / 2)
    return count


@compiled_inner
def _append(detections: Records, count: int, row: int, code: int, early: bool, t_onset_s: float) -> int:
    """Write a `DETECTION` at index ``count`` and return the new count."""
    detection = detections[count]
    detection.row = row
    detection.code = code
    detection.early = early
    detection.t_onset_s = t_onset_s
    return count + 1
