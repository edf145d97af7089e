"""dm_control's CMU humanoid as a dancer: its own shapes and 56 hinges perform motion planned for 25 hinges.

Motion is planned with the lengths and masses of its segments. The rotation of each planned joint is then decomposed
into the hinges that the humanoid has there. Its ankles cannot roll, so the balance support has to do more than with
sjasim's own body: 13 to 15 N rms instead of 4 N, within the same limits.

Source: tunyasuvunakool2020 (the model). Gains, scaling and the Kinect's joints are assumed.
"""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from ..assets.colours import dancer_colour
from ..assets.names import ACTUATED, FLOOR_BIT, HAND_BIT, ROBOT_BIT, dancer_bit
from ..config import BodyConfig
from ..core import Array
from ..core.registry import register
from ..humans.body.anatomy import Anatomy, Build, Segment, Shape
from ..humans.body.mjcf import (
    ANKLE_ARMATURE,
    ARMATURE,
    GAINS,
    SKIN_RGB,
    TROUSER_SHADE,
    add_balance_support,
    add_root,
)
from ..humans.body.proportions import scaled_anatomy
from .cmu_measures import (
    ARM_HINGES,
    FROM_CMU,
    KINECT_JOINTS,
    LEG_HINGES,
    TRUNK_HINGES,
    CmuMeasures,
    cmu_measures,
    hinge_angles,
    source_spec,
)

SEGMENTS = {
    "pelvis": ("root", "lhipjoint", "rhipjoint"),
    "torso": ("lowerback", "upperback", "thorax", "lclavicle", "rclavicle"),
    "head": ("lowerneck", "upperneck", "head"),
    "upper_arm_L": ("lhumerus",),
    "upper_arm_R": ("rhumerus",),
    "forearm_L": ("lradius", "lwrist", "lhand", "lfingers", "lthumb"),
    "forearm_R": ("rradius", "rwrist", "rhand", "rfingers", "rthumb"),
    "thigh_L": ("lfemur",),
    "thigh_R": ("rfemur",),
    "shank_L": ("ltibia",),
    "shank_R": ("rtibia",),
    "foot_L": ("lfoot", "ltoes"),
    "foot_R": ("rfoot", "rtoes"),
}
"""Planned segment -> the humanoid's bodies that move with it, first the one whose origin is the segment's joint."""

OTHER_GAINS = {
    "toes": (60.0, 20.0),
    "back": (1500.0, 200.0),
    "thorax": (1500.0, 200.0),
    "neck": (60.0, 20.0),
    "head": (60.0, 20.0),
    "clavicle": (300.0, 60.0),
    "wrist": (40.0, 20.0),
    "hand": (20.0, 10.0),
    "fingers": (3.0, 2.0),
    "thumb": (3.0, 2.0),
}
"""Part of a hinge's name -> stiffness [Nm/rad] and torque limit [Nm] of hinges without a planned one; assumed."""

LIGHT_ARMATURE = {"foot": ANKLE_ARMATURE, "toes": ANKLE_ARMATURE, "back": 0.10, "thorax": 0.10}
"""Part of a hinge's name -> armature [kg m^2] where it is not `mjcf.ARMATURE`; assumed. Without it a light vertebra or
foot would oscillate between stiff neighbours."""

HAND_HALF_M = 0.02
"""Half the thickness of a hand in the original size [m]."""

REFERENCE_BUILD = Build(1.75, 75.0)
"""Build at which the gains hold unscaled."""

_LIMB_HINGES = {**LEG_HINGES, **ARM_HINGES}


def _leading_hinge(planned: str) -> str:
    """The humanoid's hinge for a planned one, such as ``lfemurrx`` for ``hip_y_L``."""
    if planned in TRUNK_HINGES:
        return TRUNK_HINGES[planned]
    return planned[-1].lower() + _LIMB_HINGES[planned[:-2]]


@register("body", "cmu")
class CmuBody:
    """dm_control's CMU humanoid (version 2020), scaled to a dancer's stature and mass; see `BodyModel`."""

    leading = tuple(_leading_hinge(name) for name in ACTUATED)

    @property
    def hinges(self) -> tuple[str, ...]:
        """Names of the humanoid's hinges."""
        return cmu_measures().hinges

    def angles(self, planned: Array) -> Array:
        """(D, 56) angles of the humanoid's hinges for planned angles (D, 25) [rad]."""
        return hinge_angles(cmu_measures(), planned)

    def anatomy(self, build: Build) -> Anatomy:
        """The planner's tables with the lengths and masses of the humanoid, scaled to a build."""
        measures = cmu_measures()
        own = scaled_anatomy(build)
        scale = build.stature_m / measures.stature_m
        origins = {name: measures.origins[bodies[0]] for name, bodies in SEGMENTS.items()}

        names = [segment.name for segment in own.segments]
        segments = tuple(_scaled_segment(segment, names, build) for segment in own.segments)
        joints = {
            name: (row, tuple(scale * (measures.joints[name] - origins[names[row]])))
            for name, (row, _) in own.joints.items()
        }
        return replace(
            own,
            segments=segments,
            joints=joints,
            model="cmu",
            ankle_m=scale * measures.ankle_m,
            thigh_m=scale * float(origins["thigh_L"][2] - origins["shank_L"][2]),
            shank_m=scale * float(origins["shank_L"][2] - origins["foot_L"][2]),
            hip_m=scale * float(origins["thigh_L"][1]),
            hand_half_m=scale * HAND_HALF_M,
        )

    def spec(self, anatomy: Anatomy, index: int, group: int, config: BodyConfig) -> mujoco.MjSpec:
        """The MuJoCo model of one dancer; see `BodyModel.spec`."""
        measures = cmu_measures()
        build = anatomy.build
        scale = build.stature_m / measures.stature_m
        spec = source_spec()
        spec.modelname = "dancer"
        _scale(spec, scale, build.mass_kg / (sum(measures.masses.values()) * scale**3))

        # The middle between the hips becomes the origin, and the quaternion turns the humanoid's axes into sjasim's.
        pelvis = spec.body("root")
        pelvis.name = "pelvis"
        spec.body("thorax").name = "torso"
        pelvis.pos = -scale * (FROM_CMU @ measures.hip_middle)
        pelvis.quat = [0.5, 0.5, 0.5, 0.5]
        add_root(pelvis, FROM_CMU.T, scale * measures.hip_middle)

        for geom in spec.geoms:
            _set_contacts(geom, index, group)
            _set_colour(geom, index)
        for name, (body, offset) in {**KINECT_JOINTS, "SpineBase": ("pelvis", measures.hip_middle)}.items():
            spec.body(body).add_site(name=name, pos=scale * np.array(offset), size=[0.01] * 3, group=4)
        for name in measures.hinges:
            _add_servo(spec, name, build)
        add_balance_support(spec, build, config)
        return spec


def _scaled_segment(segment: Segment, names: list[str], build: Build) -> Segment:
    """A planned segment with the offset and mass of the humanoid's bodies, whose masses are spheres of no size.

    Args:
        segment: the segment of sjasim's own body.
        names: names of all segments, by row.
        build: stature and mass.
    """
    measures: CmuMeasures = cmu_measures()
    scale = build.stature_m / measures.stature_m
    mass_scale = build.mass_kg / sum(measures.masses.values())
    origin = measures.origins[SEGMENTS[segment.name][0]]
    parent = measures.origins[SEGMENTS[names[segment.parent]][0]] if segment.parent >= 0 else origin

    shapes = []
    for body in SEGMENTS[segment.name]:
        mass_kg = measures.masses[body]
        if mass_kg > 0.0:
            centre = tuple(scale * (measures.centres[body] - origin))
            shapes.append(Shape(body, "sphere", centre, (0, 0, 0), (0.0,), mass_scale * mass_kg))
    return replace(segment, offset=tuple(scale * (origin - parent)), shapes=tuple(shapes))


def _scale(spec: mujoco.MjSpec, scale: float, density: float) -> None:
    """Scale all lengths and densities of a model, and remove what holds its zero posture."""
    for body in spec.bodies:
        body.pos = scale * body.pos
    for geom in spec.geoms:
        geom.pos = scale * geom.pos
        geom.size = scale * geom.size
        geom.density = density * geom.density
    for joint in spec.joints:
        joint.pos = scale * joint.pos
        # The springs of the model pull towards a T posture.
        joint.stiffness = np.zeros(3)
        # The right arm has the range of the left one, with which it could not hang.
        if joint.name.endswith("humerusrz"):
            joint.limited = False


def _set_contacts(geom: mujoco.MjsGeom, index: int, group: int) -> None:
    """Let a geom collide with the robot and other dancers, soles also with the floor, and hands with each other."""
    own = dancer_bit(index)
    others = ROBOT_BIT | sum(dancer_bit(other) for other in range(group) if other != index)
    geom.contype = own
    geom.conaffinity = others
    geom.condim = 3

    name = geom.name[1:]  # without the side
    if name.startswith(("hand", "finger")):
        geom.contype = own | HAND_BIT
        geom.conaffinity = others | HAND_BIT
    elif name.startswith(("foot", "toes")):
        geom.conaffinity = others | FLOOR_BIT


def _set_colour(geom: mujoco.MjsGeom, index: int) -> None:
    """Give a geom the colour of skin, or of the dancer's shirt or trousers."""
    name = geom.name[1:]  # without the side
    geom.material = ""
    if name.startswith(("hand", "finger", "thumb", "wrist")) or geom.name in ("head", "upperneck", "lowerneck"):
        geom.rgba = [*SKIN_RGB, 1.0]
        return

    trousers = name.startswith(("femur", "tibia", "foot", "toes", "hip")) or geom.name == "root_geom"
    shade = TROUSER_SHADE if trousers else 1.0
    geom.rgba = [*(shade * (0.12 + 0.88 * value / 255) for value in dancer_colour(index)), 1.0]


def _add_servo(spec: mujoco.MjSpec, hinge: str, build: Build) -> None:
    """Add armature and a position servo to a hinge, with the gains of the planned hinge that it stands for."""
    planned = dict(zip(CmuBody.leading, ACTUATED, strict=True))
    gains: tuple[float, float]
    if hinge in planned:
        gains = GAINS[planned[hinge].removesuffix("_L").removesuffix("_R")]
    else:
        gains = next(value for part, value in OTHER_GAINS.items() if part in hinge)
    stiffness, torque_nm = gains

    strength = build.mass_kg / REFERENCE_BUILD.mass_kg * (build.stature_m / REFERENCE_BUILD.stature_m) ** 2
    armature = next((value for part, value in LIGHT_ARMATURE.items() if part in hinge), ARMATURE)
    spec.joint(hinge).armature = strength * armature
    servo = spec.add_actuator(name=hinge, target=hinge, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    servo.set_to_position(kp=strength * stiffness, dampratio=1.0)
    servo.forcelimited = True
    servo.forcerange = [-strength * torque_nm, strength * torque_nm]
