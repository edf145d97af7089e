"""What the physics takes and gives: cues, states of the dancers, and the scene that sensors see."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import NamedTuple, Protocol

from .vocabulary import Array, IntArray, Kind, Move


@dataclass(frozen=True, slots=True)
class Cue:
    """One move that a dancer is going to perform, with the true time at which it will happen.

    Attributes:
        dancer: name of the dancer.
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
        """Kinds and times of the events that the move causes. A turn follows a clap and causes none."""
        if self.move is Move.FORWARD:
            return ((Kind.START_FORWARD, self.t_s), (Kind.STOP_FORWARD, self.t_s + self.duration_s))
        if self.move is Move.BACKWARD:
            return ((Kind.START_BACKWARD, self.t_s), (Kind.STOP_BACKWARD, self.t_s + self.duration_s))
        return ((Kind.CLAP, self.t_s),) if self.move is Move.CLAP else ()

    def delayed(self, by_s: float) -> Cue:
        """A copy of the cue that is later by this time."""
        return replace(self, t_s=self.t_s + by_s)


class StateColumn(IntEnum):
    """First column of each part of a dancer's state in `DancerStates.rows`."""

    COM = 0
    """Centre of mass x, y, z [m]."""
    COM_VELOCITY = 3
    """Its velocity [m/s]."""
    ROOT = 6
    """Pelvis x, y, z [m], yaw, pitch (forward positive), roll [rad]."""
    ROOT_VELOCITY = 12
    """Rates of the same [m/s, rad/s]."""
    ANKLES = 18
    """Left and right ankle [m]."""
    HANDS = 24
    """Left and right hand [m]."""
    TETHER = 30
    """Forces x, y [N] and torques yaw, pitch, roll [Nm] of the balance support; 0 without one."""
    LOAD = 35
    """What the floor carries [N]."""


DANCER_STATE_WIDTH = 36
"""Number of columns of `DancerStates.rows`."""


class DancerStates(NamedTuple):
    """State of every dancer at one tick: what the balance controller uses, and what is logged beside it.

    Attributes:
        rows: (D, `DANCER_STATE_WIDTH`) states, see `StateColumn`.
    """

    rows: Array

    @property
    def root(self) -> Array:
        """(D, 6) pelvis x, y, z [m], yaw, pitch, roll [rad]."""
        return self.rows[:, StateColumn.ROOT : StateColumn.ROOT_VELOCITY]

    @property
    def ankles(self) -> Array:
        """(D, 2, 3) left and right ankle [m]."""
        return self.rows[:, StateColumn.ANKLES : StateColumn.HANDS].reshape(-1, 2, 3)

    @property
    def hands(self) -> Array:
        """(D, 2, 3) centres of the left and the right hand [m]."""
        return self.rows[:, StateColumn.HANDS : StateColumn.TETHER].reshape(-1, 2, 3)

    @property
    def tether(self) -> Array:
        """(D, 5) force x, y [N] and torque yaw, pitch, roll [Nm]."""
        return self.rows[:, StateColumn.TETHER : StateColumn.LOAD]

    @property
    def load(self) -> Array:
        """(D,) what the floor carries of each [N]; see `Physics.measure_load`."""
        return self.rows[:, StateColumn.LOAD]


@dataclass(frozen=True, slots=True)
class Servos:
    """Properties of the dancers' actuators that the balance controller needs.

    Attributes:
        stiffness: (D, 25) stiffness of the hinge servos [Nm/rad].
        lead: (D, 25) damping over stiffness, which is the feed-forward time of a target's rate [s].
        root_lead: (D, 5) the same for the balance support; 0 without one [s].
        weight: (D,) body weight [N].
        leg: (D,) length of thigh and shank together [m].
    """

    stiffness: Array
    lead: Array
    root_lead: Array
    weight: Array
    leg: Array


@dataclass(frozen=True, slots=True)
class Geoms:
    """The geoms of the scene at one instant: everything that a depth camera can see.

    Attributes:
        form: (G,) 0 plane, 2 sphere, 3 capsule, 4 ellipsoid, 5 cylinder, 6 box, as MuJoCo numbers them.
        size_m: (G, 3) sizes as in MuJoCo: radius, then half the length; semi-axes; half edges.
        position_m: (G, 3) centres in the world.
        rotation: (G, 3, 3) world from geom; the third axis is a plane's normal, a capsule's and cylinder's axis.
        owner: (G,) index of the dancer; -1 for the floor and the robot.
    """

    form: IntArray
    size_m: Array
    position_m: Array
    rotation: Array
    owner: IntArray


class Solids(NamedTuple):
    """Geoms that can occlude something, as compiled code reads them.

    The last two arrays belong to the physics and always hold the present; readers must not write to them.

    Attributes:
        rows: (G, 3) row of each geom in the last two arrays, its owner, its form.
        shape: (G, 7) size as in MuJoCo; then the half edges of a box with the geom's orientation and the radius of a
            ball: the geom lies within the union of such balls around all points of the box [m].
        position_m: (all, 3) centres in the world.
        rotation: (all, 9) world from geom, row-major.
    """

    rows: IntArray
    shape: Array
    position_m: Array
    rotation: Array


class SceneView(Protocol):
    """What sensors may read of the physics. Tests give them a scripted scene without physics."""

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
        """(D,) true headings of the pelvises, 0 along world x, counter-clockwise [rad]."""
        ...

    @property
    def geoms(self) -> Geoms:
        """All geoms at this instant."""
        ...

    @property
    def solids(self) -> Solids:
        """All geoms that can occlude something."""
        ...
