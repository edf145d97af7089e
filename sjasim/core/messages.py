"""Skeletons that sensors deliver, and the messages between sensor clients and the server."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .vocabulary import Array, IntArray, Kind


class Skeletons(NamedTuple):
    """Skeletons of all persons in one frame, as a sensing route delivers them, without times.

    Attributes:
        persons: (P,) identities local to the sensor; the rows stay the same as long as nobody appears or disappears.
        joints: (P, 25, 3) positions in the sensor's frame: x to the sensor's left, y up, z away from the sensor
            (the Kinect's camera space) [m]; NaN where a joint is not tracked.
        state: (P, 25) `NOT_TRACKED`, `INFERRED` or `TRACKED`.
    """

    persons: IntArray
    joints: Array
    state: NDArray[np.int8]


class SkeletonFrame(NamedTuple):
    """One processed frame: the skeletons of all persons with the clocks of their sensor.

    Attributes:
        sensor: name of the sensor.
        t_device_s: device clock when the frame had been processed.
        t_capture_device_s: device clock when the frame was captured.
        t_sensor_s: frame time of the sensor itself (the Kinect's relative time). Its origin is arbitrary, but it
            never jumps, so intervals are computed from it.
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
        t_s: (T,) rising times of the frames [s].
        joints_m: (T, P, 25, 3) joints in the Kinect's camera space; NaN where unknown [m].
        state: (T, P, 25) 2 tracked, 1 inferred, 0 not tracked.
        persons: (P,) names of the persons, one for each row, as the recording gives them: numbers or words.
    """

    t_s: Array
    joints_m: Array
    state: NDArray[np.int8]
    persons: NDArray[np.generic]


@dataclass(frozen=True, slots=True)
class DeviceEvent:
    """An event as a client reports it, on that client's uncorrected clock.

    Attributes:
        sensor: name of the client's sensor.
        person: identity local to that sensor.
        kind: what happened, or what is about to happen in an early event.
        t_device_s: device clock when the frame that shows the event had been processed; never earlier.
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
        x_m: position on the floor along world x, by the sensor's known mounting.
        y_m: position along world y.
        yaw_rad: heading in the world.
        tracked: share of the 25 joints that are tracked, 0 to 1.
        hands: share of the two hands that are tracked: 0, .5 or 1.
    """

    person: int
    x_m: float
    y_m: float
    yaw_rad: float
    tracked: float
    hands: float


class ClientStatus(NamedTuple):
    """Periodic report of a client (5 Hz), by which the server matches persons and notices dead clients.

    Attributes:
        sensor: name of the client's sensor.
        t_device_s: device clock when the report was sent.
        persons: the persons that the client sees; None if it has taken no frame since its last report.
    """

    sensor: str
    t_device_s: float
    persons: tuple[PersonStatus, ...] | None


class SyncRequest(NamedTuple):
    """First half of a clock exchange, with the server's time of sending."""

    sensor: str
    t_server_send_s: float


class SyncReply(NamedTuple):
    """Second half of a clock exchange, with the device clock at reception and at sending of the reply."""

    sensor: str
    t_server_send_s: float
    t_device_receive_s: float
    t_device_send_s: float


@dataclass(frozen=True, slots=True)
class MoveDuration:
    """Duration of a person's last move of one kind, by its logged events. It arms the early stop of the next one.

    Attributes:
        person: identity local to the sensor that receives the message.
        start: the event that starts such a move, START_FORWARD or START_BACKWARD.
        duration_s: from the regular start to the regular stop.
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
        durations: durations of moves that the other clients logged before the hand-over. Without them a client has no
            early stop for the first move of each kind that it sees.
        assist: whether to detect, from the side, claps of persons whose hands the active client does not see.
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
        kind: what happened, or what is about to happen in an early event.
        t_s: session time, by the server's estimate of the client's clock.
        t_arrival_s: session time when the server received it.
        early: whether this is an early event.
        iteration: the iteration whose window holds ``t_s``.
        sensor: name of the sensor whose client reported it.
    """

    person: str
    kind: Kind
    t_s: float
    t_arrival_s: float
    early: bool
    iteration: int
    sensor: str
