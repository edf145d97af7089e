"""A dancer's body as a MuJoCo model: the anatomy's tables, PD actuators whose gains scale with the build, a tether.

The pelvis hangs on three slides and three hinges. Saturating actuators on five of them are the tether; the
vertical is free, so the feet carry the whole weight.
"""

from __future__ import annotations

import mujoco
import numpy as np

from ...assets.colours import dancer_colour
from ...assets.names import ACTUATED, FLOOR_BIT, HAND_BIT, ROBOT_BIT, ROOT_JOINTS, TETHERED, dancer_bit
from ...config import BodyConfig
from ...core import Array
from ...core.registry import register
from .anatomy import Anatomy, Build, Segment, Shape, anatomy

GAINS = {
    "abdomen_z": (2000, 150), "abdomen_y": (2800, 200), "abdomen_x": (2800, 200),
    "neck_y": (60, 20), "neck_z": (40, 20),
    "hip_z": (1600, 100), "hip_x": (3600, 250), "hip_y": (3600, 250),
    "knee": (3200, 250), "ankle_y": (1800, 150), "ankle_x": (1000, 80),
    "shoulder_y": (160, 60), "shoulder_x": (160, 60), "shoulder_z": (80, 30), "elbow": (120, 40),
}  # fmt: skip
"""Hinge -> stiffness [Nm/rad] and torque limit [Nm] of a dancer of 75 kg and 1.75 m (assumed; joint torques
stay within published human maxima)."""

SUPPORT_GAINS = {
    "root_x": (800.0, 150.0), "root_y": (800.0, 150.0),
    "root_yaw": (100.0, 15.0), "root_pitch": (150.0, 25.0), "root_roll": (150.0, 25.0),
}  # fmt: skip
"""Tethered root joint -> stiffness [N/m, Nm/rad] and damping [N s/m, Nm s/rad] (assumed)."""

ARMATURE, ANKLE_ARMATURE = 0.02, 0.06
"""Inertia of muscles about a joint [kg m^2], at 75 kg and 1.75 m (assumed); it scales as stiffness does.

A light ankle under a stiff muscle on a soft contact would quiver at 150 steps a second: a standing dancer's ankles then
turn at 1 rad/s, with this inertia not at all.
"""
DAMPING = 0.6
SKIN_RGB, SHOE_RGB = (0.80, 0.60, 0.47), (0.16, 0.16, 0.18)
TROUSER_SHADE = 0.55
"""Brightness of the trousers, as a share of the shirt's."""
SOLE_SOLREF, SOLE_SOLIMP = (0.014, 1.0), (0.95, 0.99)
"""As hard a sole as 150 steps a second bear: a softer one lets standing feet creep (assumed)."""
FORMS = {
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
}
AXES = np.eye(3)


@register("body", "sjasim")
class SjasimBody:
    """Our own dancer, whose hinges are the planned ones."""

    hinges = leading = ACTUATED

    def anatomy(self, build: Build) -> Anatomy:
        """See `anatomy.anatomy`."""
        return anatomy(build)

    def spec(self, anatomy: Anatomy, index: int, group: int, config: BodyConfig) -> mujoco.MjSpec:
        """See `dancer_spec`."""
        return dancer_spec(anatomy, index, group, config)

    def angles(self, planned: Array) -> Array:
        """The same."""
        return planned


def dancer_spec(anatomy: Anatomy, index: int, group: int, config: BodyConfig) -> mujoco.MjSpec:
    """Build one dancer, pelvis at the origin of the world (the root's joints carry the position).

    Args:
        anatomy: the build's tables.
        index: the dancer's place in the cast, from 0; decides contact bits and colour.
        group: number of dancers.
        config: tether limits.

    Returns:
        a model with sites named like the Kinect's joints, actuators named like the hinges they move and, with a
        tether, like the root joints it pulls at.
    """
    spec = mujoco.MjSpec()
    spec.modelname = "dancer"
    spec.compiler.degree = False
    scale = anatomy.build.mass_kg / 75.0 * (anatomy.build.stature_m / 1.75) ** 2
    bodies: list[mujoco.MjsBody] = []
    for segment in anatomy.segments:
        parent = bodies[segment.parent] if segment.parent >= 0 else spec.worldbody
        bodies.append(_segment(parent, segment, scale))
        for shape in segment.shapes:
            _shape(bodies[-1], shape, index, group)
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


def _segment(parent: mujoco.MjsBody, segment: Segment, scale: float) -> mujoco.MjsBody:
    body = parent.add_body(name=segment.name, pos=segment.offset)
    if segment.parent < 0:
        add_root(body)
    for hinge in segment.hinges:
        armature = ANKLE_ARMATURE if hinge.name.startswith("ankle") else ARMATURE
        body.add_joint(
            name=hinge.name, axis=hinge.sign * AXES[hinge.axis], range=[hinge.low_rad, hinge.high_rad], limited=True,
            armature=scale * armature, damping=[DAMPING, 0, 0],
        )  # fmt: skip
    return body


def add_root(body: mujoco.MjsBody, axes: Array = AXES, place: Array | None = None) -> None:
    """Let a pelvis move freely, on slides and hinges that a tether can pull at one by one.

    Args:
        body: the pelvis.
        axes: (3, 3) our axes in the body's own, one a column.
        place: (3,) what is to be placed, in the body's own axes; its origin if None [m].
    """
    for name in ROOT_JOINTS:
        slide = name in ("root_x", "root_y", "root_z")
        axis = {"root_x": 0, "root_y": 1, "root_z": 2, "root_yaw": 2, "root_pitch": 1, "root_roll": 0}[name]
        kind = mujoco.mjtJoint.mjJNT_SLIDE if slide else mujoco.mjtJoint.mjJNT_HINGE
        body.add_joint(
            name=name, type=kind, axis=axes[:, axis], pos=np.zeros(3) if place is None else place, limited=False,
            armature=0.0, damping=np.zeros(3),
        )  # fmt: skip


def _shape(body: mujoco.MjsBody, shape: Shape, index: int, group: int) -> None:
    own = dancer_bit(index)
    others = ROBOT_BIT | sum(dancer_bit(other) for other in range(group) if other != index)
    geom = body.add_geom(
        name=shape.name, type=FORMS[shape.form], mass=shape.mass, condim=3, friction=[0.8, 0.005, 0.0001],
        contype=own, conaffinity=others, rgba=[*_colour(shape, index), 1.0],
    )  # fmt: skip
    if shape.form == "capsule":
        geom.fromto = [*shape.a, *shape.b]
        geom.size = [shape.size[0], 0, 0]
    else:
        geom.pos = shape.a
        geom.size = [*shape.size, 0, 0][:3]
    if shape.role == "hand":
        geom.contype, geom.conaffinity = own | HAND_BIT, others | HAND_BIT
    elif shape.role == "sole":
        geom.contype, geom.conaffinity, geom.group = 0, FLOOR_BIT, 3
        geom.friction = [1.0, 0.005, 0.0001]
        geom.solref[:2], geom.solimp[:2] = SOLE_SOLREF, SOLE_SOLIMP


def _colour(shape: Shape, index: int) -> tuple[float, ...]:
    if shape.role == "hand" or shape.name in ("head", "neck"):
        return SKIN_RGB
    if shape.name.startswith("foot"):
        return SHOE_RGB
    shade = TROUSER_SHADE if shape.name.startswith(("pelvis", "thigh", "shank")) else 1.0
    return tuple(shade * (0.12 + 0.88 * value / 255) for value in dancer_colour(index))


def add_balance_support(spec: mujoco.MjSpec, build: Build, config: BodyConfig) -> None:
    """Let saturating actuators pull at the root's joints, unless the configuration wants none."""
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
        pull.biasprm[1], pull.biasprm[2] = -stiffness, -damping
        pull.forcelimited = True
        pull.forcerange = [-limit, limit]
