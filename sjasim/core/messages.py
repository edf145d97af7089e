"""What sensors see, and what their clients and the server tell each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .vocabulary import Array, IntArray, Kind


class Skeletons(NamedTuple):
    """All persons' skeletons in one frame, as a sensing method delivers them; no clock yet.

    Attributes:
        persons: (P,) identities local to the sensor; the same rows in every frame while nobody comes or goes.
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
        t_sensor_s: the sensor's own frame time (the Kinect's relative time): its origin means nothing, but it
            never jumps, so intervals are taken from it.
        skeletons: what was seen.
    """

    sensor: str
    t_device_s: float
    t_capture_device_s: float
    t_sensor_s: float
    skeletons: Skeletons


class RecordedJoints(NamedTuple):
    """Skeletons over time, from a recording.

    Attributes:
        t_s: (T,) rising times of the frames [s].
        joints_m: (T, P, 25, 3) joints in the Kinect's camera space; NaN where unknown [m].
        state: (T, P, 25) 2 tracked, 1 inferred, 0 not tracked.
        persons: (P,) who is in which row, as the recording names them: numbers or words.
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
        kind: what happened, or for an early event what is about to.
        t_device_s: device clock when the frame that shows it had been processed; never back-dated.
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
    """Where a client believes a person is.

    Attributes:
        person: identity local to the sensor.
        x_m: world position on the floor, from the sensor's known mounting.
        y_m: the same.
        yaw_rad: world heading.
        tracked: share of the 25 joints that are tracked, 0 to 1.
        hands: share of the two hands that is tracked, 0, .5 or 1.
    """

    person: int
    x_m: float
    y_m: float
    yaw_rad: float
    tracked: float
    hands: float


class ClientStatus(NamedTuple):
    """A client's regular report (5 Hz) of the persons it sees; the server matches persons with it.

    ``persons`` is None where the client has taken no frame since its last report: it lives, and that is all.
    """

    sensor: str
    t_device_s: float
    persons: tuple[PersonStatus, ...] | None


class SyncRequest(NamedTuple):
    """First half of a clock exchange: the server's time when it asked."""

    sensor: str
    t_server_send_s: float


class SyncReply(NamedTuple):
    """Second half of a clock exchange, with the device clock at reception and at sending."""

    sensor: str
    t_server_send_s: float
    t_device_receive_s: float
    t_device_send_s: float


@dataclass(frozen=True, slots=True)
class MoveDuration:
    """How long a person's last move of one kind took, by its logged events; it arms the early stop of the next.

    Attributes:
        person: identity local to the sensor that is told.
        start: the move's starting event, START_FORWARD or START_BACKWARD.
        duration_s: from the regular start to the regular stop.
    """

    person: int
    start: Kind
    duration_s: float


@dataclass(frozen=True, slots=True)
class ClientOrder:
    """The server's word to a client: detect at full rate, look out for claps only, or idle and only report status.

    Attributes:
        sensor: name of the client's sensor.
        watch: whether to detect.
        durations: what the other clients logged before the hand-over; without it a client has no early stop
            for the first move of each kind that it sees.
        assist: whether to look, from the side, for claps of people whose hands the active client does not see.
    """

    sensor: str
    watch: bool
    durations: tuple[MoveDuration, ...] = ()
    assist: bool = False


@dataclass(frozen=True, slots=True)
class Event:
    """An event in session time, attributed to a member of the cast.

    Attributes:
        person: cast name, ``dancer_1``...
        kind: what happened, or for an early event what is about to.
        t_s: session time by the server's estimate of the client's clock.
        t_arrival_s: session time when the server received it.
        early: whether this is an early event.
        iteration: the iteration whose window holds ``t_s``.
        sensor: the client it came from.
    """

    person: str
    kind: Kind
    t_s: float
    t_arrival_s: float
    early: bool
    iteration: int
    sensor: str
