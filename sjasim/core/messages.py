"""Skeletons that sensors deliver, and the messages between sensor clients and the server."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .vocabulary import Array, IntArray, Kind


class Skeletons(NamedTuple):
    """Skeletons of all persons in one frame, without times, as a `SkeletonSource` returns them.

    Attributes:
        persons: (P,) identities local to the sensor. The order of rows is constant until a person appears or
            disappears.
        joints: (P, 25, 3) positions in the sensor's frame: x to the sensor's left, y up, z away from the sensor
            (the Kinect's camera space) [m]; NaN where a joint is not tracked.
        state: (P, 25) `NOT_TRACKED`, `INFERRED` or `TRACKED`.
    """

    persons: IntArray
    joints: Array
    state: NDArray[np.int8]


class SkeletonFrame(NamedTuple):
    """One processed frame: the skeletons of all persons, and the time of the frame on the clocks of the sensor.

    Attributes:
        sensor: name of the sensor.
        t_device_s: device clock at the end of the frame's processing.
        t_capture_device_s: device clock at the capture of the frame.
        t_sensor_s: frame time on the sensor's own clock (the Kinect's relative time). Its origin is arbitrary and it
            never jumps. Use it to compute intervals between frames.
        skeletons: the skeletons of the frame.
    """

    sensor: str
    t_device_s: float
    t_capture_device_s: float
    t_sensor_s: float
    skeletons: Skeletons


class RecordedJoints(NamedTuple):
    """Recorded skeletons over time.

    Attributes:
        t_s: (T,) strictly increasing times of the frames [s].
        joints_m: (T, P, 25, 3) joints in the Kinect's camera space [m]; NaN where unknown.
        state: (T, P, 25) `TRACKED`, `INFERRED` or `NOT_TRACKED`.
        persons: (P,) names of the persons as in the recording, numbers or strings.
    """

    t_s: Array
    joints_m: Array
    state: NDArray[np.int8]
    persons: NDArray[np.generic]


@dataclass(frozen=True, slots=True)
class DeviceEvent:
    """An event as reported by a client, with the time of the client's uncorrected clock.

    Attributes:
        sensor: name of the client's sensor.
        person: identity local to that sensor.
        kind: kind of the event; of the announced event if ``early``.
        t_device_s: device clock at the end of processing of the frame in which the event was detected.
        early: whether this is an early event.
        t_onset_device_s: the client's estimate of the physical onset on the same clock, or None.
    """

    sensor: str
    person: int
    kind: Kind
    t_device_s: float
    early: bool
    t_onset_device_s: float | None = None


class PersonStatus(NamedTuple):
    """Estimated position of a person, as a client reports it.

    Attributes:
        person: identity local to the sensor.
        x_m: position along world x, computed with the known pose of the sensor.
        y_m: position along world y.
        yaw_rad: heading in the world.
        tracked: fraction of the 25 joints that are tracked, 0 to 1.
        hands: fraction of the two hands that are tracked: 0, .5 or 1.
    """

    person: int
    x_m: float
    y_m: float
    yaw_rad: float
    tracked: float
    hands: float


class ClientStatus(NamedTuple):
    """Periodic report of a client (by default 5 Hz). The server identifies persons and detects dead clients with it.

    Attributes:
        sensor: name of the client's sensor.
        t_device_s: device clock at the sending of the report.
        persons: persons in the client's last frame; None if it has captured no frame since its last report.
    """

    sensor: str
    t_device_s: float
    persons: tuple[PersonStatus, ...] | None


class SyncRequest(NamedTuple):
    """Request of a clock exchange, with the session time at which the server sent it."""

    sensor: str
    t_server_send_s: float


class SyncReply(NamedTuple):
    """Reply of a clock exchange, with the device clock at the reception of the request and the sending of the reply."""

    sensor: str
    t_server_send_s: float
    t_device_receive_s: float
    t_device_send_s: float


@dataclass(frozen=True, slots=True)
class MoveDuration:
    """Duration of a person's last forward or backward move. A client needs it to detect the early stop of the next one.

    Attributes:
        person: identity local to the sensor that receives the message.
        start: kind of the event that starts the move, START_FORWARD or START_BACKWARD.
        duration_s: time from the regular start event to the regular stop event.
    """

    person: int
    start: Kind
    duration_s: float


@dataclass(frozen=True, slots=True)
class ClientOrder:
    """The server's order to a client: detect all events, detect claps only, or only report its status.

    Attributes:
        sensor: name of the client's sensor.
        watch: whether to detect all events at the full frame rate.
        durations: durations of moves that other clients observed before the hand-over. Without them the client cannot
            detect an early stop in the first move of each kind.
        assist: whether to detect claps from the side, of persons whose hands the active client does not see.
    """

    sensor: str
    watch: bool
    durations: tuple[MoveDuration, ...] = ()
    assist: bool = False


@dataclass(frozen=True, slots=True)
class Event:
    """An event in session time that is assigned to a dancer.

    Attributes:
        person: name of the dancer, ``dancer_1``...
        kind: kind of the event; of the announced event if ``early``.
        t_s: session time of the event, computed with the server's estimate of the client's clock.
        t_arrival_s: session time at which the server received it.
        early: whether this is an early event.
        iteration: the iteration whose window contains ``t_s``.
        sensor: name of the sensor whose client reported it.
    """

    person: str
    kind: Kind
    t_s: float
    t_arrival_s: float
    early: bool
    iteration: int
    sensor: str
