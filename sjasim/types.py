"""Plain data that crosses doors between rooms: frozen values, SI units, one clock named per field.

World z is up, quaternions are wxyz. A time field's name says its clock: ``t_s`` is session time (true
simulation time for what the world logs, the server's estimate of it for an `Event`), ``t_device_s`` is an
uncorrected device clock, ``t_arrival_s`` is session time at the receiver.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

ROBOT = "robot"
"""The robot's name wherever an agent is named; dancers are ``dancer_1``, ``dancer_2``, ..."""


def dancer_name(index: int) -> str:
    """Name of the dancer with this index, counted from 0: ``dancer_name(0) == "dancer_1"``."""
    return f"dancer_{index + 1}"


class Move(StrEnum):
    """What a dancer or the robot can be asked to do."""

    FORWARD = "forward"
    BACKWARD = "backward"
    STOP = "stop"
    CLAP = "clap"
    TURN = "turn"
    DRIVE = "drive"
    """The robot only, and only from outside the score: a speed and a yaw rate of the driver's choice."""


class Kind(StrEnum):
    """What can be seen to happen. A robot's turn counts as its clap in every synchrony measure.

    Source: iqbal2016, section IV-B.
    """

    START_FORWARD = "start_forward"
    STOP_FORWARD = "stop_forward"
    START_BACKWARD = "start_backward"
    STOP_BACKWARD = "stop_backward"
    CLAP = "clap"
    TURN = "turn"


SYNCHRONY_KINDS = (
    Kind.START_FORWARD,
    Kind.STOP_FORWARD,
    Kind.START_BACKWARD,
    Kind.STOP_BACKWARD,
    Kind.CLAP,
)
"""The five kinds that enter the synchrony measures."""


class TrackingState(StrEnum):
    """How a skeleton's joint is known; the numbers in `Skeletons.state` are the codes below, in this order."""

    NOT_TRACKED = "not_tracked"
    INFERRED = "inferred"
    TRACKED = "tracked"


NOT_TRACKED, INFERRED, TRACKED = 0, 1, 2


@dataclass(frozen=True, slots=True)
class Cue:
    """One move that a dancer is going to perform, at the time it will really happen.

    Attributes:
        dancer: who.
        move: FORWARD, BACKWARD, CLAP or TURN.
        iteration: 0 for the rehearsal, then 1, 2, ...
        ordinal: place of the move's first event among the iteration's events, from 0.
        beat: nominal beat of the move inside its iteration.
        t_s: when SpineBase's speed crosses the onset speed (moves), the palms meet (clap), or the turn begins.
        duration_s: until the speed falls through the onset speed again; 0 for a clap.
    """

    dancer: str
    move: Move
    iteration: int
    ordinal: int
    beat: float
    t_s: float
    duration_s: float

    def events(self) -> tuple[tuple[Kind, float], ...]:
        """The events that the move gives rise to, with their times; a turn follows a clap and gives none."""
        if self.move is Move.FORWARD:
            return ((Kind.START_FORWARD, self.t_s), (Kind.STOP_FORWARD, self.t_s + self.duration_s))
        if self.move is Move.BACKWARD:
            return ((Kind.START_BACKWARD, self.t_s), (Kind.STOP_BACKWARD, self.t_s + self.duration_s))
        return ((Kind.CLAP, self.t_s),) if self.move is Move.CLAP else ()

    def delayed(self, by_s: float) -> Cue:
        """The same cue, later."""
        return replace(self, t_s=self.t_s + by_s)


class JointTargets(NamedTuple):
    """Actuator targets of all dancers for one control tick (in the order of the cast).

    Attributes:
        joints: (D, 25) hinge targets with velocity feed-forward included [rad].
        root: (D, 5) tether targets x, y [m], yaw, pitch, roll [rad], feed-forward included.
    """

    joints: Array
    root: Array


class DancerStates(NamedTuple):
    """The state of every dancer at one tick: what the balance controller feels, and what is logged beside it.

    Attributes:
        rows: (D, 36) centre of mass [m] and its velocity [m/s]; pelvis x, y, z [m], yaw, pitch (forward positive),
            roll [rad], and their rates; left and right ankle [m]; left and right hand [m]; the tether's force x, y [N]
            and torque yaw, pitch, roll [Nm], 0 without one; what the floor carries [N].
    """

    rows: Array

    @property
    def root(self) -> Array:
        """(D, 6) pelvis x, y, z [m], yaw, pitch, roll [rad]."""
        return self.rows[:, 6:12]

    @property
    def ankles(self) -> Array:
        """(D, 2, 3) left and right ankle [m]."""
        return self.rows[:, 18:24].reshape(-1, 2, 3)

    @property
    def hands(self) -> Array:
        """(D, 2, 3) centres of the left and the right hand [m]."""
        return self.rows[:, 24:30].reshape(-1, 2, 3)

    @property
    def tether(self) -> Array:
        """(D, 5) force x, y [N] and torque yaw, pitch, roll [Nm]."""
        return self.rows[:, 30:35]

    @property
    def load(self) -> Array:
        """(D,) what the floor carries of each [N]; see `Stage.feel`."""
        return self.rows[:, 35]


@dataclass(frozen=True, slots=True)
class Servos:
    """The dancers' actuators as the balance controller needs to know them.

    Attributes:
        stiffness: (D, 25) of the hinge servos [Nm/rad].
        lead: (D, 25) damping over stiffness: the feed-forward time of a target's rate [s].
        root_lead: (D, 5) the same for the tether; 0 without one [s].
        weight: (D,) body weight [N].
        leg: (D,) thigh and shank together [m].
    """

    stiffness: Array
    lead: Array
    root_lead: Array
    weight: Array
    leg: Array


@dataclass(frozen=True, slots=True)
class Geoms:
    """The primitives that a stage consists of, at one instant: all that light would meet.

    Attributes:
        form: (G,) 0 plane, 2 sphere, 3 capsule, 4 ellipsoid, 5 cylinder, 6 box, as MuJoCo numbers them.
        size_m: (G, 3) as MuJoCo means it: radius, then half the length; semi-axes; half edges.
        position_m: (G, 3) centres in the world.
        rotation: (G, 3, 3) world from geom; the third axis is a plane's normal, a capsule's and cylinder's axis.
        owner: (G,) the dancer's index; -1 for anything else: floor, robot.
    """

    form: IntArray
    size_m: Array
    position_m: Array
    rotation: Array
    owner: IntArray


class StageView(Protocol):
    """Read-only sight of the stage that sensors get; a scripted one tests them without physics."""

    @property
    def time_s(self) -> float:
        """True simulation time [s]."""
        ...

    @property
    def joints_m(self) -> Array:
        """(D, 25, 3) true positions of the dancers' joints, in the order of `assets.names.JOINTS` [m]."""
        ...

    @property
    def yaw_rad(self) -> Array:
        """(D,) true headings of the pelvises [rad], 0 along world x, counter-clockwise."""
        ...

    @property
    def geoms(self) -> Geoms:
        """Everything that can be seen, at this instant."""
        ...

    def hidden(self, origin: Array, points: Array, whose: IntArray, flesh_m: Array) -> BoolArray:
        """Which points something hides from an eye.

        Args:
            origin: (3,) the eye [m].
            points: (N, 3) world points [m].
            whose: (N,) index of the dancer that each point belongs to.
            flesh_m: (N,) how deep under its own dancer's surface a point may lie and still be seen [m].

        Returns:
            (N,) True where a surface lies before the point.
        """
        ...


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
    """A client's regular report (5 Hz) of the persons it sees; the server matches persons with it."""

    sensor: str
    t_device_s: float
    persons: tuple[PersonStatus, ...]


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


@dataclass(frozen=True, slots=True)
class MoveCommand:
    """An order to the robot. Repeated copies carry the same number and are executed once.

    Attributes:
        number: counts commands of a session from 1; a higher number replaces a lower one.
        move: FORWARD, BACKWARD, STOP, TURN or DRIVE.
        t_start_s: session time when the server sent it first.
        speed_m_s: cruise speed of a forward or backward move; of DRIVE its speed, negative for backwards.
        heading_rad: absolute odometry heading at which a turn ends, or that a move or a stop takes up meanwhile.
        iteration: the iteration it belongs to.
        ordinal: place of its event among the iteration's events, from 0.
        why: method and evidence in words.
        yaw_rate_rad_s: of DRIVE; other moves set their own.
    """

    number: int
    move: Move
    t_start_s: float
    speed_m_s: float
    heading_rad: float
    iteration: int
    ordinal: int
    why: str
    yaw_rate_rad_s: float = 0.0


class WheelCommand(NamedTuple):
    """Wheel speeds for the base [rad/s]."""

    left_rad_s: float
    right_rad_s: float


class WheelReading(NamedTuple):
    """What the base's own sensors say: wheel angles since power-up [rad], yaw rate [rad/s]."""

    left_rad: float
    right_rad: float
    yaw_rate_rad_s: float


class RobotState(NamedTuple):
    """The robot's own belief, from odometry; session clock (its computer runs the server's clock).

    Attributes:
        t_s: when the sample was taken.
        x_m: dead-reckoned position.
        y_m: the same.
        heading_rad: dead-reckoned heading, unwrapped.
        step_m: displacement along the heading since the last sample.
        yaw_rate_rad_s: the gyro's rate.
    """

    t_s: float
    x_m: float
    y_m: float
    heading_rad: float
    step_m: float
    yaw_rate_rad_s: float
