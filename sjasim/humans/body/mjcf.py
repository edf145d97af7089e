"""The default body as a MuJoCo model: segments, PD actuators whose gains scale with the build, and balance support.

The pelvis hangs on three slides and three hinges. Balance support is saturating actuators on five of them; the vertical
is free, so that the feet carry the whole weight.
"""

from __future__ import annotations

import mujoco
import numpy as np

from ...assets.colours import dancer_colour
from ...assets.names import ACTUATED, FLOOR_BIT, HAND_BIT, ROBOT_BIT, ROOT_JOINTS, TETHERED, dancer_bit
from ...config import BodyConfig
from ...core import Array
from ...core.registry import register
from .anatomy import Anatomy, Build, Segment, Shape
from .proportions import scaled_anatomy

GAINS = {
    "abdomen_z": (2000, 150),
    "abdomen_y": (2800, 200),
    "abdomen_x": (2800, 200),
    "neck_y": (60, 20),
    "neck_z": (40, 20),
    "hip_z": (1600, 100),
    "hip_x": (3600, 250),
    "hip_y": (3600, 250),
    "knee": (3200, 250),
    "ankle_y": (1800, 150),
    "ankle_x": (1000, 80),
    "shoulder_y": (160, 60),
    "shoulder_x": (160, 60),
    "shoulder_z": (80, 30),
    "elbow": (120, 40),
}
"""Hinge -> stiffness [Nm/rad] and torque limit [Nm] of a dancer of 75 kg and 1.75 m (assumed; the limits stay within
published human maxima)."""

SUPPORT_GAINS = {
    "root_x": (800.0, 150.0),
    "root_y": (800.0, 150.0),
    "root_yaw": (100.0, 15.0),
    "root_pitch": (150.0, 25.0),
    "root_roll": (150.0, 25.0),
}
"""Supported root joint -> stiffness [N/m, Nm/rad] and damping [N s/m, Nm s/rad] of a dancer of 75 kg (assumed)."""

ARMATURE = 0.02
"""Inertia of the muscles about a joint [kg m^2] at 75 kg and 1.75 m (assumed); it scales as stiffness does."""

ANKLE_ARMATURE = 0.06
"""The same about an ankle. A light ankle with a stiff actuator on a soft contact would oscillate at 150 steps a second:
the ankles of a standing dancer then turn at 1 rad/s, with this inertia not at all."""

DAMPING = 0.6
"""Passive damping of every hinge [Nm s/rad] (assumed)."""

SKIN_RGB = (0.80, 0.60, 0.47)
SHOE_RGB = (0.16, 0.16, 0.18)

TROUSER_SHADE = 0.55
"""Brightness of the trousers, as a share of the shirt's."""

SOLE_SOLREF = (0.014, 1.0)
"""MuJoCo's contact time constant [s] and damping ratio: as hard a sole as 150 steps a second allow. On a softer one
standing feet creep (assumed)."""

SOLE_SOLIMP = (0.95, 0.99)
"""First two values of MuJoCo's contact impedance, chosen with `SOLE_SOLREF`."""

GEOM_TYPES = {
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
}
"""`Shape.form` -> type of geom."""

AXES = np.eye(3)
"""Our axes, one a row: x forward, y left, z up."""

_ROOT_AXIS = {"root_x": 0, "root_y": 1, "root_z": 2, "root_yaw": 2, "root_pitch": 1, "root_roll": 0}
_ROOT_SLIDES = ("root_x", "root_y", "root_z")


@register("body", "sjasim")
class SjasimBody:
    """Implements `BodyModel` by a body whose hinges are the planned ones."""

    hinges = leading = ACTUATED

    def anatomy(self, build: Build) -> Anatomy:
        """Tables of standard proportions; see `scaled_anatomy`."""
        return scaled_anatomy(build)

    def spec(self, anatomy: Anatomy, index: int, group: int, config: BodyConfig) -> mujoco.MjSpec:
        """See `dancer_spec`."""
        return dancer_spec(anatomy, index, group, config)

    def angles(self, planned: Array) -> Array:
        """The planned angles, unchanged."""
        return planned


def dancer_spec(anatomy: Anatomy, index: int, group: int, config: BodyConfig) -> mujoco.MjSpec:
    """The MuJoCo model of one dancer, with the pelvis at the origin; the root's joints carry the position.

    Args:
        anatomy: tables of the dancer's build.
        index: index of the dancer, from 0; it decides contact bits and colour.
        group: number of dancers.
        config: limits of the balance support.

    Returns:
        a model with sites named like the Kinect's joints, and actuators named like the joints that they move: the
        hinges and, with balance support, five root joints.
    """
    spec = mujoco.MjSpec()
    spec.modelname = "dancer"
    spec.compiler.degree = False
    # Inertia about a joint goes with mass times length squared; gains follow it.
    scale = anatomy.build.mass_kg / 75.0 * (anatomy.build.stature_m / 1.75) ** 2

    bodies: list[mujoco.MjsBody] = []
    for segment in anatomy.segments:
        parent = bodies[segment.parent] if segment.parent >= 0 else spec.worldbody
        bodies.append(_add_segment(parent, segment, scale))
        for shape in segment.shapes:
            _add_shape(bodies[-1], shape, index, group)

    for name, (row, offset) in anatomy.joints.items():
        bodies[row].add_site(name=name, pos=offset, size=[0.01, 0.01, 0.01], group=4)

    for name in ACTUATED:
        kp, limit = (value * scale for value in GAINS[name.removesuffix("_L").removesuffix("_R")])
        servo = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=kp, dampratio=1.0)
        servo.forcelimited = True
        servo.forcerange = [-limit, limit]

    add_balance_support(spec, anatomy.build, config)
    return spec


def _add_segment(parent: mujoco.MjsBody, segment: Segment, scale: float) -> mujoco.MjsBody:
    """Add a segment with its joints; ``scale`` is that of the armature."""
    body = parent.add_body(name=segment.name, pos=segment.offset)
    if segment.parent < 0:
        add_root(body)

    for hinge in segment.hinges:
        armature = ANKLE_ARMATURE if hinge.name.startswith("ankle") else ARMATURE
        body.add_joint(
            name=hinge.name,
            axis=hinge.sign * AXES[hinge.axis],
            range=[hinge.low_rad, hinge.high_rad],
            limited=True,
            armature=scale * armature,
            damping=[DAMPING, 0, 0],
        )
    return body


def add_root(body: mujoco.MjsBody, axes: Array = AXES, place: Array | None = None) -> None:
    """Let a pelvis move freely, by slides and hinges at which balance support can act one by one.

    Args:
        body: the pelvis.
        axes: (3, 3) our axes in the body's own frame, one a column.
        place: (3,) point that the joints move, in the body's own frame; None stands for its origin [m].
    """
    for name in ROOT_JOINTS:
        kind = mujoco.mjtJoint.mjJNT_SLIDE if name in _ROOT_SLIDES else mujoco.mjtJoint.mjJNT_HINGE
        body.add_joint(
            name=name,
            type=kind,
            axis=axes[:, _ROOT_AXIS[name]],
            pos=np.zeros(3) if place is None else place,
            limited=False,
            armature=0.0,
            damping=np.zeros(3),
        )


def _add_shape(body: mujoco.MjsBody, shape: Shape, index: int, group: int) -> None:
    """Add a shape as a geom with the contacts of its role; see `Shape.role`."""
    # Without its own bit in conaffinity a dancer never collides with itself, which its planned postures avoid.
    own = dancer_bit(index)
    others = ROBOT_BIT | sum(dancer_bit(other) for other in range(group) if other != index)
    geom = body.add_geom(
        name=shape.name,
        type=GEOM_TYPES[shape.form],
        mass=shape.mass,
        condim=3,
        friction=[0.8, 0.005, 0.0001],
        contype=own,
        conaffinity=others,
        rgba=[*_colour(shape, index), 1.0],
    )

    if shape.form == "capsule":
        geom.fromto = [*shape.a, *shape.b]
        geom.size = [shape.size[0], 0, 0]
    else:
        geom.pos = shape.a
        geom.size = [*shape.size, 0, 0][:3]

    if shape.role == "hand":
        geom.contype = own | HAND_BIT
        geom.conaffinity = others | HAND_BIT
    elif shape.role == "sole":
        # Group 3 hides the spheres from cameras and sensors.
        geom.group = 3
        geom.contype = 0
        geom.conaffinity = FLOOR_BIT
        geom.friction = [1.0, 0.005, 0.0001]
        geom.solref[:2] = SOLE_SOLREF
        geom.solimp[:2] = SOLE_SOLIMP


def _colour(shape: Shape, index: int) -> tuple[float, ...]:
    """Red, green and blue of a shape, 0 to 1."""
    if shape.role == "hand" or shape.name in ("head", "neck"):
        return SKIN_RGB
    if shape.name.startswith("foot"):
        return SHOE_RGB

    shade = TROUSER_SHADE if shape.name.startswith(("pelvis", "thigh", "shank")) else 1.0
    return tuple(shade * (0.12 + 0.88 * value / 255) for value in dancer_colour(index))


def add_balance_support(spec: mujoco.MjSpec, build: Build, config: BodyConfig) -> None:
    """Add saturating PD actuators on the root's joints, unless ``config.balance_support`` is ``none``."""
    if config.balance_support == "none":
        return

    scale = build.mass_kg / 75.0
    for name in TETHERED:
        stiffness, damping = (scale * gain for gain in SUPPORT_GAINS[name])
        limit = config.support_force_n if name in ("root_x", "root_y") else config.support_torque_nm

        pull = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        pull.gaintype = mujoco.mjtGain.mjGAIN_FIXED
        pull.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        pull.gainprm[0] = stiffness
        pull.biasprm[1] = -stiffness
        pull.biasprm[2] = -damping
        pull.forcelimited = True
        pull.forcerange = [-limit, limit]
