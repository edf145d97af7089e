"""Inputs and outputs of the physics: cues, states of the dancers, and the scene that sensors see."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import NamedTuple, Protocol

from .vocabulary import Array, IntArray, Kind, Move


@dataclass(frozen=True, slots=True)
class Cue:
    """One planned move of a dancer, with the session time at which it is to happen.

    Attributes:
        dancer: name of the dancer.
        move: FORWARD, BACKWARD, CLAP or TURN.
        iteration: 0 for the rehearsal, then 1, 2, ...
        ordinal: place of the move's first event among the iteration's events, from 0.
        beat: nominal beat of the move inside its iteration.
        t_s: session time at which the speed of SpineBase rises above the onset speed (forward and backward moves), the
            palms meet (claps), or the turn begins.
        duration_s: time until the speed falls below the onset speed again, or until the turn ends; 0 for a clap.
    """

    dancer: str
    move: Move
    iteration: int
    ordinal: int
    beat: float
    t_s: float
    duration_s: float

    def events(self) -> tuple[tuple[Kind, float], ...]:
        """Return the kinds and times of the move's events; none for a turn, which always follows a clap."""
        if self.move is Move.FORWARD:
            return ((Kind.START_FORWARD, self.t_s), (Kind.STOP_FORWARD, self.t_s + self.duration_s))
        if self.move is Move.BACKWARD:
            return ((Kind.START_BACKWARD, self.t_s), (Kind.STOP_BACKWARD, self.t_s + self.duration_s))
        return ((Kind.CLAP, self.t_s),) if self.move is Move.CLAP else ()

    def delayed(self, by_s: float) -> Cue:
        """Return a copy of the cue that is ``by_s`` later."""
        return replace(self, t_s=self.t_s + by_s)


class StateColumn(IntEnum):
    """First column of each part of a dancer's state in `DancerStates.rows`."""

    COM = 0
    """Centre of mass x, y, z [m]."""
    COM_VELOCITY = 3
    """Velocity of the centre of mass x, y, z [m/s]."""
    ROOT = 6
    """Pelvis x, y, z [m], yaw, pitch (forward positive), roll [rad]."""
    ROOT_VELOCITY = 12
    """Rates of the six coordinates of `ROOT` [m/s, rad/s]."""
    ANKLES = 18
    """Left and right ankle, x, y, z each [m]."""
    HANDS = 24
    """Left and right hand, x, y, z each [m]."""
    TETHER = 30
    """Forces x, y [N] and torques yaw, pitch, roll [Nm] of the balance support; 0 without one."""
    LOAD = 35
    """Vertical force of the floor on the feet [N]."""


DANCER_STATE_WIDTH = 36
"""Number of columns of `DancerStates.rows`."""


class DancerStates(NamedTuple):
    """State of every dancer at one tick, for the balance controller and the ground truth.

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
        """(D, 5) force x, y [N] and torque yaw, pitch, roll [Nm] of the balance support."""
        return self.rows[:, StateColumn.TETHER : StateColumn.LOAD]

    @property
    def load(self) -> Array:
        """(D,) vertical force of the floor on the feet of each dancer [N]; see `Physics.measure_load`."""
        return self.rows[:, StateColumn.LOAD]


@dataclass(frozen=True, slots=True)
class Servos:
    """Properties of the dancers' actuators that the balance controller needs.

    Attributes:
        stiffness: (D, 25) stiffness of the hinge servos [Nm/rad].
        lead: (D, 25) ratio of damping to stiffness [s]. A target advanced by this time compensates the damping.
        root_lead: (D, 5) ratio of damping to stiffness of the balance support; 0 without one [s].
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
    """All geoms of the scene that a depth camera can see, at one instant.

    Attributes:
        form: (G,) MuJoCo's geom type: 0 plane, 2 sphere, 3 capsule, 4 ellipsoid, 5 cylinder, 6 box.
        size_m: (G, 3) sizes as in MuJoCo: radius and half length (sphere, capsule, cylinder), semi-axes (ellipsoid), or
            half edges (box, plane).
        position_m: (G, 3) centres in the world.
        rotation: (G, 3, 3) rotation matrices from geom to world. The third column is the normal of a plane, or the axis
            of a capsule or cylinder.
        owner: (G,) index of the dancer to which the geom belongs; -1 for the floor and the robot.
    """

    form: IntArray
    size_m: Array
    position_m: Array
    rotation: Array
    owner: IntArray


class Solids(NamedTuple):
    """Geoms that can occlude something, as arrays for compiled code.

    ``position_m`` and ``rotation`` are views of the state of the physics: they change with every step, and readers must
    not write to them.

    Attributes:
        rows: (G, 3) for each geom its row in ``position_m`` and ``rotation``, its owner and its form, see `Geoms`.
        shape: (G, 7) size as in MuJoCo (3), half edges of a box with the orientation of the geom (3), and the radius of
            a sphere (1) [m]. The union of such spheres around all points of the box contains the geom.
        position_m: (A, 3) centres of all A geoms of the model in the world.
        rotation: (A, 9) rotation matrices from geom to world, row-major.
    """

    rows: IntArray
    shape: Array
    position_m: Array
    rotation: Array


class SceneView(Protocol):
    """Protocol of a scene that sensors can observe. `Physics` implements it, and tests use scripted scenes."""

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
