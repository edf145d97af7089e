"""A dancer's anatomy as plain tables: segments, hinges, shapes and joints for a build, from published fractions.

`body.py` turns the tables into a MuJoCo model and `kinematics.py` into fast functions, so that both agree by
construction.

Source: winter2009, table 4.1 (segment lengths after drillis1966 and segment masses). Radii, the shape of the
feet and the split of the trunk's length are assumed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...assets.names import ACTUATED_INDEX, JOINTS
from ...core import Array, IntArray
from ...core.errors import ConfigError

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Build:
    """A person's stature [m] and mass [kg]."""

    stature_m: float = 1.75
    mass_kg: float = 75.0

    def __post_init__(self) -> None:
        if not 1.50 <= self.stature_m <= 1.95:
            raise ConfigError("build.stature_m", self.stature_m, "1.50 to 1.95 m")
        if not 50.0 <= self.mass_kg <= 100.0:
            raise ConfigError("build.mass_kg", self.mass_kg, "50 to 100 kg")


@dataclass(frozen=True, slots=True)
class Hinge:
    """One hinge: its name, the axis (0 x, 1 y, 2 z), its sign, and its range [rad]."""

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
        role: ``flesh``, ``hand`` (meets the other hand) or ``sole`` (carries the weight).
    """

    name: str
    form: str
    a: Vector
    b: Vector
    size: tuple[float, ...]
    mass: float
    role: str = "flesh"


@dataclass(frozen=True, slots=True)
class Segment:
    """One rigid segment: where its origin sits in the parent, its hinges in order, its shapes."""

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
        sole_m: (heel, toe): how far the sole reaches behind and before the ankle.
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
        """Height of the pelvis with the knees a little bent [m]."""
        return self.ankle_m + 0.957 * (self.thigh_m + self.shank_m)

    def index(self, name: str) -> int:
        """Row of the segment with this name."""
        return next(row for row, segment in enumerate(self.segments) if segment.name == name)

    def chains(self) -> Chains:
        """The same tables as arrays, for `kinematics`."""
        masses = np.array([sum(shape.mass for shape in segment.shapes) for segment in self.segments])
        centres = np.array([_centre(segment) for segment in self.segments])
        points = [
            (row, *point) for row, segment in enumerate(self.segments) for shape in segment.shapes
            for point in _points(shape)
        ]  # fmt: skip
        hinges = [(row, hinge) for row, segment in enumerate(self.segments) for hinge in segment.hinges]
        return Chains(
            parent=np.array([segment.parent for segment in self.segments], dtype=np.int64),
            offset=np.array([segment.offset for segment in self.segments]),
            mass=masses,
            centre=centres,
            hinge_segment=np.array([row for row, _ in hinges], dtype=np.int64),
            hinge_column=np.array([ACTUATED_INDEX[hinge.name] for _, hinge in hinges], dtype=np.int64),
            hinge_axis=np.array([hinge.axis for _, hinge in hinges], dtype=np.int64),
            hinge_sign=np.array([hinge.sign for _, hinge in hinges], dtype=float),
            joint_segment=np.array([self.joints[name][0] for name in JOINTS], dtype=np.int64),
            joint_offset=np.array([self.joints[name][1] for name in JOINTS]),
            feet=np.array([self.index("foot_L"), self.index("foot_R")], dtype=np.int64),
            point_segment=np.array([row for row, _, _ in points], dtype=np.int64),
            point_offset=np.array([offset for _, offset, _ in points]),
            point_mass=np.array([mass for _, _, mass in points]),
            leg=np.array([self.thigh_m, self.shank_m, self.hip_m, self.ankle_m]),
        )


@dataclass(frozen=True, slots=True)
class Chains:
    """An anatomy as arrays: S segments, 25 hinges sorted by segment, 25 joints.

    Attributes:
        parent: (S,) row of the parent, -1 for the pelvis.
        offset: (S, 3) origin in the parent [m].
        mass: (S,) [kg].
        centre: (S, 3) centre of mass in the segment [m].
        hinge_segment: (25,) the segment that a hinge moves.
        hinge_column: (25,) its column in an array of joint targets.
        hinge_axis: (25,) 0 x, 1 y, 2 z.
        hinge_sign: (25,) +1 or -1.
        joint_segment: (25,) the segment that a Kinect joint is fixed to.
        joint_offset: (25, 3) where [m].
        feet: (2,) the left and the right foot.
        point_segment: (P,) the segment that a mass point is fixed to.
        point_offset: (P, 3) where [m].
        point_mass: (P,) [kg].
        leg: thigh, shank, half hip distance, ankle height [m].
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


def _points(shape: Shape) -> list[tuple[Array, float]]:
    """Mass points of a shape: two for a capsule, which keep a rod's moment of inertia, one for anything else."""
    a, b = np.array(shape.a, dtype=np.float64), np.array(shape.b, dtype=np.float64)
    if shape.form != "capsule":
        return [(a, shape.mass)]
    middle, half = (a + b) / 2, (b - a) / 2 / np.sqrt(3.0)
    return [(middle - half, shape.mass / 2), (middle + half, shape.mass / 2)]


def _centre(segment: Segment) -> Array:
    centres = np.array([(np.array(s.a) + np.array(s.b)) / 2 if s.form == "capsule" else s.a for s in segment.shapes])
    masses = np.array([s.mass for s in segment.shapes])
    return np.asarray(masses @ centres / masses.sum())


def anatomy(build: Build) -> Anatomy:
    """Tables for a build; lengths scale with stature, masses with mass, girths with the root of mass over stature."""
    h, m = build.stature_m, build.mass_kg
    girth = float(np.sqrt((m / 75.0) / (h / 1.75)))
    segments: list[Segment] = []
    joints: dict[str, tuple[int, Vector]] = {}
    _trunk(segments, joints, h, m, girth)
    for side, sign in (("L", 1), ("R", -1)):
        _arm(segments, joints, (side, sign), h, m, girth)
    for side, sign in (("L", 1), ("R", -1)):
        _leg(segments, joints, (side, sign), h, m, girth)
    return Anatomy(
        build,
        tuple(segments),
        joints,
        thigh_m=0.245 * h,
        shank_m=0.246 * h,
        ankle_m=0.039 * h,
        hip_m=0.052 * h,
        sole_m=(0.032 * h, 0.104 * h),
        hand_half_m=0.010 * h,
    )


def _degrees(low: float, high: float) -> tuple[float, float]:
    return float(np.radians(low)), float(np.radians(high))


def _across(name: str, z: float, half: float, radius: float, mass: float) -> Shape:
    return Shape(name, "capsule", (0.0, -half, z), (0.0, half, z), (radius,), mass)


def _trunk(segments: list[Segment], joints: dict[str, tuple[int, Vector]], h: float, m: float, girth: float) -> None:
    waist, shoulders = 0.06 * h, 0.288 * h
    pelvis = (_across("pelvis", 0.0, 0.040 * h, 0.056 * h * girth, 0.142 * m),)
    segments.append(Segment("pelvis", -1, (0.0, 0.0, 0.0), (), pelvis))
    chest = (
        _across("belly", 0.035 * h, 0.036 * h, 0.057 * h * girth, 0.139 * m),
        _across("chest", 0.155 * h, 0.050 * h, 0.067 * h * girth, 0.216 * m),
    )
    abdomen = (
        Hinge("abdomen_z", 2, 1, *_degrees(-40, 40)),
        Hinge("abdomen_y", 1, 1, *_degrees(-30, 60)),
        Hinge("abdomen_x", 0, 1, *_degrees(-30, 30)),
    )
    segments.append(Segment("torso", 0, (0.0, 0.0, waist), abdomen, chest))
    head = (
        Shape("neck", "capsule", (0.0, 0.0, 0.0), (0.0, 0.0, 0.05 * h), (0.030 * h,), 0.011 * m),
        Shape(
            "head", "ellipsoid", (0.006 * h, 0.0, 0.099 * h), (0, 0, 0), (0.054 * h, 0.044 * h, 0.063 * h), 0.070 * m
        ),
    )
    neck = (Hinge("neck_y", 1, 1, *_degrees(-40, 40)), Hinge("neck_z", 2, 1, *_degrees(-70, 70)))
    segments.append(Segment("head", 1, (0.0, 0.0, shoulders + 0.022 * h - waist), neck, head))
    joints["SpineBase"] = (0, (0.0, 0.0, 0.0))
    joints["SpineMid"] = (1, (0.0, 0.0, 0.150 * h - waist))
    joints["SpineShoulder"] = (1, (0.0, 0.0, shoulders - waist))
    joints["Neck"] = (2, (0.0, 0.0, 0.020 * h))
    joints["Head"] = (2, (0.0, 0.0, 0.099 * h))


def _arm(
    segments: list[Segment],
    joints: dict[str, tuple[int, Vector]],
    limb: tuple[str, int],
    h: float,
    m: float,
    girth: float,
) -> None:
    side, sign = limb
    upper, fore = 0.186 * h, 0.146 * h
    word = "Left" if side == "L" else "Right"
    shoulder = (
        Hinge(f"shoulder_y_{side}", 1, 1, *_degrees(-170, 60)),
        Hinge(f"shoulder_x_{side}", 0, sign, *_degrees(-30, 150)),
        Hinge(f"shoulder_z_{side}", 2, sign, *_degrees(-100, 60)),
    )
    flesh = Shape(f"upper_arm_{side}", "capsule", (0, 0, 0), (0, 0, -upper + 0.03), (0.023 * h * girth,), 0.028 * m)
    row = len(segments)
    segments.append(
        Segment(f"upper_arm_{side}", 1, (0.0, sign * 0.110 * h, (0.288 - 0.06 - 0.012) * h), shoulder, (flesh,))
    )
    elbow = (Hinge(f"elbow_{side}", 1, 1, *_degrees(-150, 0)),)
    shapes = (
        Shape(f"forearm_{side}", "capsule", (0, 0, 0), (0, 0, -fore + 0.02), (0.019 * h * girth,), 0.016 * m),
        Shape(
            f"hand_{side}",
            "ellipsoid",
            (0.0, 0.0, -fore - 0.048 * h),
            (0, 0, 0),
            (0.024 * h, 0.010 * h, 0.051 * h),
            0.006 * m,
            "hand",
        ),
    )
    segments.append(Segment(f"forearm_{side}", row, (0.0, 0.0, -upper), elbow, shapes))
    joints[f"Shoulder{word}"] = (row, (0.0, 0.0, 0.0))
    joints[f"Elbow{word}"] = (row + 1, (0.0, 0.0, 0.0))
    joints[f"Wrist{word}"] = (row + 1, (0.0, 0.0, -fore))
    joints[f"Hand{word}"] = (row + 1, (0.0, 0.0, -fore - 0.046 * h))
    joints[f"HandTip{word}"] = (row + 1, (0.0, 0.0, -fore - 0.097 * h))
    joints[f"Thumb{word}"] = (row + 1, (0.028 * h, 0.0, -fore - 0.034 * h))


def _leg(
    segments: list[Segment],
    joints: dict[str, tuple[int, Vector]],
    limb: tuple[str, int],
    h: float,
    m: float,
    girth: float,
) -> None:
    side, sign = limb
    thigh, shank, ankle = 0.245 * h, 0.246 * h, 0.039 * h
    word = "Left" if side == "L" else "Right"
    row = len(segments)
    hip = (
        Hinge(f"hip_z_{side}", 2, 1, *_degrees(-60, 60)),
        Hinge(f"hip_x_{side}", 0, 1, *_degrees(-45, 45)),
        Hinge(f"hip_y_{side}", 1, 1, *_degrees(-120, 40)),
    )
    flesh = Shape(f"thigh_{side}", "capsule", (0, 0, -0.02), (0, 0, 0.03 - thigh), (0.038 * h * girth,), 0.100 * m)
    segments.append(Segment(f"thigh_{side}", 0, (0.0, sign * 0.052 * h, 0.0), hip, (flesh,)))
    knee = (Hinge(f"knee_{side}", 1, 1, *_degrees(-2, 150)),)
    flesh = Shape(f"shank_{side}", "capsule", (0, 0, -0.02), (0, 0, 0.04 - shank), (0.027 * h * girth,), 0.0465 * m)
    segments.append(Segment(f"shank_{side}", row, (0.0, 0.0, -thigh), knee, (flesh,)))
    ankles = (Hinge(f"ankle_y_{side}", 1, 1, *_degrees(-50, 50)), Hinge(f"ankle_x_{side}", 0, 1, *_degrees(-35, 35)))
    segments.append(Segment(f"foot_{side}", row + 1, (0.0, 0.0, -shank), ankles, _sole(side, h, 0.0145 * m, -ankle)))
    joints[f"Hip{word}"] = (row, (0.0, 0.0, 0.0))
    joints[f"Knee{word}"] = (row + 1, (0.0, 0.0, 0.0))
    joints[f"Ankle{word}"] = (row + 2, (0.0, 0.0, 0.0))
    joints[f"Foot{word}"] = (row + 2, (0.090 * h, 0.0, 0.018 * h - ankle))


SOLE_RADIUS_M = 0.015
"""Radius of the spheres that a foot stands on [m] (assumed)."""


def _sole(side: str, h: float, mass: float, floor: float) -> tuple[Shape, ...]:
    z, each = floor + SOLE_RADIUS_M, 0.001
    flesh = Shape(
        f"foot_{side}", "box", (0.036 * h, 0.0, floor + 0.020 * h), (0, 0, 0), (0.074 * h, 0.026 * h, 0.016 * h),
        mass - 4 * each,
    )  # fmt: skip
    corners = (
        ("heel_out", -0.032, 0.017),
        ("heel_in", -0.032, -0.017),
        ("toe_out", 0.104, 0.021),
        ("toe_in", 0.104, -0.021),
    )
    return (
        flesh,
        *(
            Shape(f"{name}_{side}", "sphere", (x * h, y * h, z), (0, 0, 0), (SOLE_RADIUS_M,), each, "sole")
            for name, x, y in corners
        ),
    )
