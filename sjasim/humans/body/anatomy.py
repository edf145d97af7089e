"""Tables that describe a body: segments, hinges, shapes and Kinect joints of one build.

`mjcf` makes a MuJoCo model of the tables and `kinematics` fast functions, so that both agree by construction.
`proportions` fills the tables for a stature and a mass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...assets.names import ACTUATED_INDEX, JOINTS
from ...core import Array, IntArray
from ...core.errors import ConfigError

Vector = tuple[float, float, float]
"""x, y, z in a segment's frame: x forward, y left, z up in the upright posture."""


@dataclass(frozen=True, slots=True)
class Build:
    """Stature [m] and mass [kg] of a person."""

    stature_m: float = 1.75
    mass_kg: float = 75.0

    def __post_init__(self) -> None:
        if not 1.50 <= self.stature_m <= 1.95:
            raise ConfigError("build.stature_m", self.stature_m, "1.50 to 1.95 m")
        if not 50.0 <= self.mass_kg <= 100.0:
            raise ConfigError("build.mass_kg", self.mass_kg, "50 to 100 kg")


@dataclass(frozen=True, slots=True)
class Hinge:
    """One hinge joint: its name, its axis (0 x, 1 y, 2 z), the sign of the axis, and its range [rad]."""

    name: str
    axis: int
    sign: int
    low_rad: float
    high_rad: float


@dataclass(frozen=True, slots=True)
class Shape:
    """One geometric primitive of a segment, in the segment's frame.

    Attributes:
        name: unique in the body.
        form: ``capsule`` (from ``a`` to ``b``, radius ``size[0]``), ``ellipsoid``, ``box`` or ``sphere`` (at ``a``).
        a: first end or centre [m].
        b: second end of a capsule [m].
        size: radius, or semi-axes [m].
        mass: [kg].
        role: which contacts it has: ``body`` (other dancers and the robot), ``hand`` (also the dancer's other hand) or
            ``sole`` (the floor, and nothing else).
    """

    name: str
    form: str
    a: Vector
    b: Vector
    size: tuple[float, ...]
    mass: float
    role: str = "body"


@dataclass(frozen=True, slots=True)
class Segment:
    """One rigid segment.

    Attributes:
        name: unique in the body.
        parent: row of the parent segment, -1 for the pelvis.
        offset: origin in the parent's frame [m].
        hinges: joints between parent and segment, in order.
        shapes: what the segment consists of.
    """

    name: str
    parent: int
    offset: Vector
    hinges: tuple[Hinge, ...]
    shapes: tuple[Shape, ...]


@dataclass(frozen=True, slots=True)
class Anatomy:
    """The tables of one build.

    Attributes:
        build: stature and mass.
        segments: the pelvis first, every parent before its children.
        joints: name of a Kinect joint -> (segment, offset in it [m]).
        thigh_m: hip to knee.
        shank_m: knee to ankle.
        ankle_m: height of the ankle over the sole.
        hip_m: half the distance between the hips.
        sole_m: (heel, toe): how far the sole extends behind and before the ankle.
        hand_half_m: half the thickness of a hand.
        model: name of the body model that these tables describe.
    """

    build: Build
    segments: tuple[Segment, ...]
    joints: dict[str, tuple[int, Vector]]
    thigh_m: float
    shank_m: float
    ankle_m: float
    hip_m: float
    sole_m: tuple[float, float]
    hand_half_m: float
    model: str = "sjasim"

    @property
    def standing_m(self) -> float:
        """Height of the pelvis when the dancer stands, with slightly bent knees [m]."""
        return self.ankle_m + 0.957 * (self.thigh_m + self.shank_m)

    def index(self, name: str) -> int:
        """Row of the segment with this name."""
        return next(row for row, segment in enumerate(self.segments) if segment.name == name)

    def chains(self) -> Chains:
        """The tables as arrays, for compiled functions."""
        hinges = [(row, hinge) for row, segment in enumerate(self.segments) for hinge in segment.hinges]
        points = [
            (row, place, mass)
            for row, segment in enumerate(self.segments)
            for shape in segment.shapes
            for place, mass in _mass_points(shape)
        ]

        return Chains(
            parent=np.array([segment.parent for segment in self.segments], dtype=np.int64),
            offset=np.array([segment.offset for segment in self.segments]),
            mass=np.array([sum(shape.mass for shape in segment.shapes) for segment in self.segments]),
            centre=np.array([_centre_of_mass(segment) for segment in self.segments]),
            hinge_segment=np.array([row for row, _ in hinges], dtype=np.int64),
            hinge_column=np.array([ACTUATED_INDEX[hinge.name] for _, hinge in hinges], dtype=np.int64),
            hinge_axis=np.array([hinge.axis for _, hinge in hinges], dtype=np.int64),
            hinge_sign=np.array([hinge.sign for _, hinge in hinges], dtype=float),
            joint_segment=np.array([self.joints[name][0] for name in JOINTS], dtype=np.int64),
            joint_offset=np.array([self.joints[name][1] for name in JOINTS]),
            feet=np.array([self.index("foot_L"), self.index("foot_R")], dtype=np.int64),
            point_segment=np.array([row for row, _, _ in points], dtype=np.int64),
            point_offset=np.array([place for _, place, _ in points]),
            point_mass=np.array([mass for _, _, mass in points]),
            leg=np.array([self.thigh_m, self.shank_m, self.hip_m, self.ankle_m]),
        )


@dataclass(frozen=True, slots=True)
class Chains:
    """An anatomy as kinematic chains in arrays: S segments, 25 hinges sorted by segment, 25 joints, P mass points.

    Attributes:
        parent: (S,) row of the parent, -1 for the pelvis.
        offset: (S, 3) origin in the parent [m].
        mass: (S,) [kg].
        centre: (S, 3) centre of mass in the segment [m].
        hinge_segment: (25,) the segment that a hinge moves.
        hinge_column: (25,) its column in an array of joint targets.
        hinge_axis: (25,) 0 x, 1 y, 2 z.
        hinge_sign: (25,) +1 or -1.
        joint_segment: (25,) the segment to which a Kinect joint belongs.
        joint_offset: (25, 3) its place in the segment [m].
        feet: (2,) rows of the left and the right foot.
        point_segment: (P,) the segment to which a mass point belongs.
        point_offset: (P, 3) its place in the segment [m].
        point_mass: (P,) [kg].
        leg: (4,) thigh, shank, half hip distance, ankle height [m].
    """

    parent: IntArray
    offset: Array
    mass: Array
    centre: Array
    hinge_segment: IntArray
    hinge_column: IntArray
    hinge_axis: IntArray
    hinge_sign: Array
    joint_segment: IntArray
    joint_offset: Array
    feet: IntArray
    point_segment: IntArray
    point_offset: Array
    point_mass: Array
    leg: Array


def _mass_points(shape: Shape) -> list[tuple[Array, float]]:
    """Mass points that stand for a shape: two for a capsule, at the radius of gyration of a rod, one for the others."""
    a = np.array(shape.a, dtype=np.float64)
    if shape.form != "capsule":
        return [(a, shape.mass)]

    b = np.array(shape.b, dtype=np.float64)
    # A rod of length L has the moment m L^2 / 12, as two halves of its mass at L / sqrt(12) from the middle.
    middle = (a + b) / 2
    half = (b - a) / 2 / np.sqrt(3.0)
    return [(middle - half, shape.mass / 2), (middle + half, shape.mass / 2)]


def _centre_of_mass(segment: Segment) -> Array:
    """(3,) centre of mass of a segment in its frame [m]."""
    centres = np.array([(np.array(s.a) + np.array(s.b)) / 2 if s.form == "capsule" else s.a for s in segment.shapes])
    masses = np.array([s.mass for s in segment.shapes])
    return np.asarray(masses @ centres / masses.sum())
