"""The standard proportions of the human body: anatomy tables for a stature and a mass.

Source: winter2009, table 4.1 (segment lengths after drillis1966, and segment masses). Radii, the shape of the feet and
the split of the trunk's length are assumed.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .anatomy import Anatomy, Build, Hinge, Segment, Shape, Vector

SOLE_RADIUS_M = 0.015
"""Radius of the spheres on which a foot stands [m] (assumed)."""

SOLE_SPHERE_KG = 0.001
"""Mass of each of these spheres, taken from the mass of the foot [kg] (assumed)."""

_ORIGIN: Vector = (0.0, 0.0, 0.0)
_SIDES = (("L", "Left", 1), ("R", "Right", -1))
"""Suffix of hinges, suffix of Kinect joints, and sign of y."""


@dataclass(slots=True)
class _Tables:
    """Segments and joints as they are collected.

    Attributes:
        h: stature, of which all lengths are fractions [m].
        m: mass, of which all masses are fractions [kg].
        girth: factor of the radii.
        segments: the segments so far.
        joints: Kinect joint -> (segment, offset in it [m]).
    """

    h: float
    m: float
    girth: float
    segments: list[Segment] = field(default_factory=list)
    joints: dict[str, tuple[int, Vector]] = field(default_factory=dict)


def scaled_anatomy(build: Build) -> Anatomy:
    """Anatomy of standard proportions for a build.

    Lengths scale with stature, masses with mass, and radii with the square root of mass over stature.
    """
    h = build.stature_m
    girth = float(np.sqrt((build.mass_kg / 75.0) / (h / 1.75)))
    tables = _Tables(h, build.mass_kg, girth)

    _add_trunk(tables)
    for side in _SIDES:
        _add_arm(tables, *side)
    for side in _SIDES:
        _add_leg(tables, *side)

    return Anatomy(
        build,
        tuple(tables.segments),
        tables.joints,
        thigh_m=0.245 * h,
        shank_m=0.246 * h,
        ankle_m=0.039 * h,
        hip_m=0.052 * h,
        sole_m=(0.032 * h, 0.104 * h),
        hand_half_m=0.010 * h,
    )


def _degrees(low: float, high: float) -> tuple[float, float]:
    """A range of degrees in radians."""
    return float(np.radians(low)), float(np.radians(high))


def _capsule_across(name: str, z: float, half: float, radius: float, mass: float) -> Shape:
    """A capsule from right to left at a height in the segment."""
    return Shape(name, "capsule", (0.0, -half, z), (0.0, half, z), (radius,), mass)


def _add_trunk(tables: _Tables) -> None:
    """Add pelvis, torso and head, in this order, with rows 0 to 2."""
    h = tables.h
    m = tables.m
    girth = tables.girth
    waist = 0.06 * h
    shoulders = 0.288 * h

    pelvis = (_capsule_across("pelvis", 0.0, 0.040 * h, 0.056 * h * girth, 0.142 * m),)
    tables.segments.append(Segment("pelvis", -1, _ORIGIN, (), pelvis))

    chest = (
        _capsule_across("belly", 0.035 * h, 0.036 * h, 0.057 * h * girth, 0.139 * m),
        _capsule_across("chest", 0.155 * h, 0.050 * h, 0.067 * h * girth, 0.216 * m),
    )
    abdomen = (
        Hinge("abdomen_z", 2, 1, *_degrees(-40, 40)),
        Hinge("abdomen_y", 1, 1, *_degrees(-30, 60)),
        Hinge("abdomen_x", 0, 1, *_degrees(-30, 30)),
    )
    tables.segments.append(Segment("torso", 0, (0.0, 0.0, waist), abdomen, chest))

    skull_size = (0.054 * h, 0.044 * h, 0.063 * h)
    head = (
        Shape("neck", "capsule", _ORIGIN, (0.0, 0.0, 0.05 * h), (0.030 * h,), 0.011 * m),
        Shape("head", "ellipsoid", (0.006 * h, 0.0, 0.099 * h), _ORIGIN, skull_size, 0.070 * m),
    )
    neck = (Hinge("neck_y", 1, 1, *_degrees(-40, 40)), Hinge("neck_z", 2, 1, *_degrees(-70, 70)))
    tables.segments.append(Segment("head", 1, (0.0, 0.0, shoulders + 0.022 * h - waist), neck, head))

    tables.joints["SpineBase"] = (0, _ORIGIN)
    tables.joints["SpineMid"] = (1, (0.0, 0.0, 0.150 * h - waist))
    tables.joints["SpineShoulder"] = (1, (0.0, 0.0, shoulders - waist))
    tables.joints["Neck"] = (2, (0.0, 0.0, 0.020 * h))
    tables.joints["Head"] = (2, (0.0, 0.0, 0.099 * h))


def _add_arm(tables: _Tables, side: str, side_name: str, sign: int) -> None:
    """Add the upper arm and the forearm with the hand; the wrist is rigid."""
    h = tables.h
    m = tables.m
    upper = 0.186 * h
    fore = 0.146 * h
    row = len(tables.segments)

    # The signs make one set of angles give mirrored postures on both sides.
    shoulder = (
        Hinge(f"shoulder_y_{side}", 1, 1, *_degrees(-170, 60)),
        Hinge(f"shoulder_x_{side}", 0, sign, *_degrees(-30, 150)),
        Hinge(f"shoulder_z_{side}", 2, sign, *_degrees(-100, 60)),
    )
    upper_radius = 0.023 * h * tables.girth
    upper_arm = Shape(f"upper_arm_{side}", "capsule", _ORIGIN, (0, 0, -upper + 0.03), (upper_radius,), 0.028 * m)
    place = (0.0, sign * 0.110 * h, (0.288 - 0.06 - 0.012) * h)
    tables.segments.append(Segment(f"upper_arm_{side}", 1, place, shoulder, (upper_arm,)))

    elbow = (Hinge(f"elbow_{side}", 1, 1, *_degrees(-150, 0)),)
    fore_radius = 0.019 * h * tables.girth
    hand_size = (0.024 * h, 0.010 * h, 0.051 * h)
    shapes = (
        Shape(f"forearm_{side}", "capsule", _ORIGIN, (0, 0, -fore + 0.02), (fore_radius,), 0.016 * m),
        Shape(f"hand_{side}", "ellipsoid", (0.0, 0.0, -fore - 0.048 * h), _ORIGIN, hand_size, 0.006 * m, "hand"),
    )
    tables.segments.append(Segment(f"forearm_{side}", row, (0.0, 0.0, -upper), elbow, shapes))

    tables.joints[f"Shoulder{side_name}"] = (row, _ORIGIN)
    tables.joints[f"Elbow{side_name}"] = (row + 1, _ORIGIN)
    tables.joints[f"Wrist{side_name}"] = (row + 1, (0.0, 0.0, -fore))
    tables.joints[f"Hand{side_name}"] = (row + 1, (0.0, 0.0, -fore - 0.046 * h))
    tables.joints[f"HandTip{side_name}"] = (row + 1, (0.0, 0.0, -fore - 0.097 * h))
    tables.joints[f"Thumb{side_name}"] = (row + 1, (0.028 * h, 0.0, -fore - 0.034 * h))


def _add_leg(tables: _Tables, side: str, side_name: str, sign: int) -> None:
    """Add thigh, shank and foot."""
    h = tables.h
    m = tables.m
    thigh = 0.245 * h
    shank = 0.246 * h
    ankle = 0.039 * h
    row = len(tables.segments)

    hip = (
        Hinge(f"hip_z_{side}", 2, 1, *_degrees(-60, 60)),
        Hinge(f"hip_x_{side}", 0, 1, *_degrees(-45, 45)),
        Hinge(f"hip_y_{side}", 1, 1, *_degrees(-120, 40)),
    )
    thigh_radius = 0.038 * h * tables.girth
    shape = Shape(f"thigh_{side}", "capsule", (0, 0, -0.02), (0, 0, 0.03 - thigh), (thigh_radius,), 0.100 * m)
    tables.segments.append(Segment(f"thigh_{side}", 0, (0.0, sign * 0.052 * h, 0.0), hip, (shape,)))

    knee = (Hinge(f"knee_{side}", 1, 1, *_degrees(-2, 150)),)
    shank_radius = 0.027 * h * tables.girth
    shape = Shape(f"shank_{side}", "capsule", (0, 0, -0.02), (0, 0, 0.04 - shank), (shank_radius,), 0.0465 * m)
    tables.segments.append(Segment(f"shank_{side}", row, (0.0, 0.0, -thigh), knee, (shape,)))

    ankles = (Hinge(f"ankle_y_{side}", 1, 1, *_degrees(-50, 50)), Hinge(f"ankle_x_{side}", 0, 1, *_degrees(-35, 35)))
    foot = _foot(side, h, 0.0145 * m, -ankle)
    tables.segments.append(Segment(f"foot_{side}", row + 1, (0.0, 0.0, -shank), ankles, foot))

    tables.joints[f"Hip{side_name}"] = (row, _ORIGIN)
    tables.joints[f"Knee{side_name}"] = (row + 1, _ORIGIN)
    tables.joints[f"Ankle{side_name}"] = (row + 2, _ORIGIN)
    tables.joints[f"Foot{side_name}"] = (row + 2, (0.090 * h, 0.0, 0.018 * h - ankle))


def _foot(side: str, h: float, mass: float, floor: float) -> tuple[Shape, ...]:
    """Shapes of a foot: a box, and four spheres under its corners, which alone touch the floor.

    Args:
        side: suffix of the names.
        h: stature [m].
        mass: of the foot [kg].
        floor: height of the floor in the segment, whose origin is the ankle [m].
    """
    corners = (
        ("heel_out", -0.032, 0.017),
        ("heel_in", -0.032, -0.017),
        ("toe_out", 0.104, 0.021),
        ("toe_in", 0.104, -0.021),
    )
    z = floor + SOLE_RADIUS_M
    spheres = [
        Shape(f"{name}_{side}", "sphere", (x * h, y * h, z), _ORIGIN, (SOLE_RADIUS_M,), SOLE_SPHERE_KG, "sole")
        for name, x, y in corners
    ]

    size = (0.074 * h, 0.026 * h, 0.016 * h)
    box_mass = mass - 4 * SOLE_SPHERE_KG
    box = Shape(f"foot_{side}", "box", (0.036 * h, 0.0, floor + 0.020 * h), _ORIGIN, size, box_mass)
    return (box, *spheres)
