"""Lengths, masses and joint positions of dm_control's CMU humanoid, measured on its MuJoCo model.

Axes of the humanoid are x to the left, y up, z ahead. Those of sjasim's bodies are x ahead, y to the left, z up.

Source: tunyasuvunakool2020 (the model). The places of the Kinect's joints are assumed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from math import radians

import mujoco
import numpy as np

from ..assets.names import ACTUATED_INDEX
from ..core import Array
from .missing_dm_control import missing_dm_control

try:
    import dm_control
except ImportError as error:
    raise missing_dm_control(error) from error

MODEL_FILE = "locomotion/walkers/assets/humanoid_CMU_V2020.xml"
"""The model's file in the package dm_control."""

FROM_CMU = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Rotation to sjasim's axes from the humanoid's."""

LEG_SPREAD_RAD = radians(20.0)
"""Angle of each leg to the vertical in the humanoid's zero posture [rad]."""

HANGING_ARM = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Rotation of a hanging upper arm in sjasim's axes; the elbow bends it forward."""

LEG_HINGES = {
    "hip_x": "femurrz",
    "hip_z": "femurry",
    "hip_y": "femurrx",
    "knee": "tibiarx",
    "ankle_y": "footrx",
    "ankle_x": "footrz",
}
"""Planned hinge of a leg -> the humanoid's hinge with nearly the same axis, without the side."""

ARM_HINGES = {"shoulder_x": "humerusrz", "shoulder_y": "humerusrx", "shoulder_z": "humerusry", "elbow": "radiusrx"}
"""The same for an arm."""

TRUNK_HINGES = {
    "abdomen_x": "lowerbackrz",
    "abdomen_z": "lowerbackry",
    "abdomen_y": "lowerbackrx",
    "neck_z": "lowerneckry",
    "neck_y": "lowerneckrx",
}
"""The same for the trunk."""

_ORIGIN = (0.0, 0.0, 0.0)

_LIMB_JOINTS = (
    ("Shoulder", "humerus", _ORIGIN),
    ("Elbow", "radius", _ORIGIN),
    ("Wrist", "hand", _ORIGIN),
    ("Hand", "hand", (0.0, -0.0168, 0.0)),
    ("HandTip", "fingers", (0.0, -0.065, 0.0)),
    ("Thumb", "thumb", (0.0, -0.06, 0.0)),
    ("Hip", "femur", _ORIGIN),
    ("Knee", "tibia", _ORIGIN),
    ("Ankle", "foot", _ORIGIN),
    ("Foot", "toes", _ORIGIN),
)

KINECT_JOINTS = {
    "SpineMid": ("upperback", (0.0, 0.05, 0.0)),
    "SpineShoulder": ("lowerneck", _ORIGIN),
    "Neck": ("upperneck", _ORIGIN),
    "Head": ("head", (0.0, 0.048, 0.025)),
    **{
        joint + word: (side + bone, offset)
        for side, word in (("l", "Left"), ("r", "Right"))
        for joint, bone, offset in _LIMB_JOINTS
    },
}
"""Kinect joint -> body of the humanoid, and place in it [m]. SpineBase is the middle between the hips instead."""


@dataclass(frozen=True, slots=True)
class CmuMeasures:
    """Measures of the humanoid in its original size.

    Positions are those of a standing humanoid with hanging arms, in sjasim's axes, relative to the middle between its
    hips [m].

    Attributes:
        hinges: names of the 56 hinges.
        origins: body -> origin (3,).
        centres: body -> centre of mass (3,).
        masses: body -> mass [kg].
        joints: Kinect joint -> position (3,).
        shoulders: (2, 3, 3) rotations of the left and right upper arm in the zero posture, in sjasim's axes.
        wrists_rad: angles of the left and right wrist at which the palms face each other.
        flat_foot_rad: angle of the foot's hinge at which the sole is parallel to the floor.
        ankle_m: height of the ankle with that angle.
        stature_m: stature.
        hip_middle: (3,) middle between the hips in the humanoid's axes.
    """

    hinges: tuple[str, ...]
    origins: dict[str, Array]
    centres: dict[str, Array]
    masses: dict[str, float]
    joints: dict[str, Array]
    shoulders: Array
    wrists_rad: tuple[float, float]
    flat_foot_rad: float
    ankle_m: float
    stature_m: float
    hip_middle: Array


def source_spec() -> mujoco.MjSpec:
    """The model as dm_control ships it, without its lights, cameras, sites, actuators and sensors."""
    path = resources.files(dm_control).joinpath(MODEL_FILE)
    spec = mujoco.MjSpec.from_file(str(path))
    for item in (*spec.lights, *spec.cameras, *spec.sites, *spec.actuators, *spec.sensors, *spec.excludes):
        spec.delete(item)

    spec.default.actuator.ctrllimited = False
    # MuJoCo then chooses the sizes itself, as several dancers need more than the file allows.
    spec.njmax = -1
    spec.nconmax = -1
    return spec


@cache
def cmu_measures() -> CmuMeasures:
    """Measure the humanoid."""
    model = source_spec().compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    upright = _measure_zero_posture(model, data)

    # Let the humanoid stand with hanging arms, as sjasim's bodies do with zero angles.
    data.qpos[:] = hinge_angles(upright, np.zeros((1, len(ACTUATED_INDEX))))[0]
    mujoco.mj_forward(model, data)
    middle = (data.body("lfemur").xpos + data.body("rfemur").xpos) / 2
    names = [model.body(index).name for index in range(1, model.nbody)]
    origins = {name: FROM_CMU @ (data.body(name).xpos - middle) for name in names}
    origins["root"] = np.zeros(3)

    joints = {}
    for joint, (name, offset) in KINECT_JOINTS.items():
        body = data.body(name)
        joints[joint] = FROM_CMU @ (body.xpos + body.xmat.reshape(3, 3) @ offset - middle)
    joints["SpineBase"] = np.zeros(3)

    head = model.geom("head")
    top_m = float(data.geom("head").xpos[1] + head.size[0] + head.size[1])
    return replace(
        upright,
        origins=origins,
        centres={name: FROM_CMU @ (data.body(name).xipos - middle) for name in names},
        masses={name: float(model.body(name).mass[0]) for name in names},
        joints=joints,
        stature_m=top_m - float(data.body("lfoot").xpos[1]) + upright.ankle_m,
        hip_middle=middle,
    )


def _measure_zero_posture(model: mujoco.MjModel, data: mujoco.MjData) -> CmuMeasures:
    """What `hinge_angles` needs, measured in the zero posture; the other measures are empty."""
    shoulders = np.array([FROM_CMU @ data.body(f"{side}humerus").xmat.reshape(3, 3) for side in "lr"])
    hands = np.array([FROM_CMU @ data.body(f"{side}hand").xmat.reshape(3, 3) for side in "lr"])
    flat_foot_rad, ankle_m = _flat_foot(model, data)
    return CmuMeasures(
        hinges=tuple(model.joint(index).name for index in range(model.njnt)),
        origins={},
        centres={},
        masses={},
        joints={},
        shoulders=shoulders,
        wrists_rad=(_wrist_angle(shoulders[0].T @ hands[0], 1), _wrist_angle(shoulders[1].T @ hands[1], -1)),
        flat_foot_rad=flat_foot_rad,
        ankle_m=ankle_m,
        stature_m=0.0,
        hip_middle=np.zeros(3),
    )


def _wrist_angle(hand: Array, side: int) -> float:
    """Angle of a wrist at which the palm of a hanging hand faces the body [rad].

    Args:
        hand: (3, 3) rotation of the hand in the upper arm.
        side: 1 for the left hand, -1 for the right one.
    """
    outward = hand.T @ HANGING_ARM.T @ np.array([0.0, side, 0.0])
    return float(np.arctan2(outward[0], outward[2]))


def _flat_foot(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[float, float]:
    """Angle of the foot's hinge at which heel and toes have one height [rad], and the height of the ankle then [m]."""
    ankle = data.body("lfoot")
    toes = data.geom("ltoes0")
    foot = data.geom("lfoot")
    rotation = ankle.xmat.reshape(3, 3)

    # The heel is the higher end of the foot's capsule in the frame of the foot.
    ends = [foot.xpos + end * model.geom("lfoot").size[1] * foot.xmat.reshape(3, 3)[:, 2] for end in (-1, 1)]
    local = [rotation.T @ (point - ankle.xpos) for point in (*ends, toes.xpos)]
    heel = max(local, key=lambda point: float(point[1]))
    toe = local[-1]
    tilt_rad = float(np.arctan2(heel[2] - toe[2], heel[1] - toe[1]))
    height_m = -float(np.cos(tilt_rad) * heel[2] - np.sin(tilt_rad) * heel[1]) + float(model.geom("lfoot").size[0])
    return -tilt_rad, height_m


def hinge_angles(measures: CmuMeasures, planned: Array) -> Array:
    """Angles of the humanoid's hinges at which its segments have the planned orientations.

    Args:
        measures: measures of the humanoid.
        planned: (D, 25) planned angles [rad]. The roll of the ankles is ignored: the humanoid's ankles do not have it.

    Returns:
        (D, 56) angles [rad].
    """
    column = {name: index for index, name in enumerate(measures.hinges)}
    out = np.zeros((len(planned), len(measures.hinges)))

    def write(bone: str, rotation: Array) -> None:
        """Write the angles about z, y and x that make a rotation in sjasim's axes."""
        out[:, column[f"{bone}rz"]] = np.arctan2(rotation[:, 2, 1], rotation[:, 1, 1])
        out[:, column[f"{bone}ry"]] = -np.arcsin(np.clip(rotation[:, 0, 1], -1.0, 1.0))
        out[:, column[f"{bone}rx"]] = np.arctan2(rotation[:, 0, 2], rotation[:, 0, 0])

    trunk = {name: planned[:, ACTUATED_INDEX[name]] for name in TRUNK_HINGES}
    write("lowerback", _about(2, trunk["abdomen_z"]) @ _about(1, trunk["abdomen_y"]) @ _about(0, trunk["abdomen_x"]))
    write("lowerneck", _about(1, trunk["neck_y"]) @ _about(2, trunk["neck_z"]))

    for index, (side, sign) in enumerate((("l", 1), ("r", -1))):
        leg = {name: planned[:, ACTUATED_INDEX[f"{name}_{side.upper()}"]] for name in LEG_HINGES}
        write(f"{side}femur", _about(2, leg["hip_z"]) @ _about(0, leg["hip_x"]) @ _about(1, leg["hip_y"]))
        out[:, column[f"{side}femurrz"]] -= sign * LEG_SPREAD_RAD
        out[:, column[f"{side}tibiarx"]] = leg["knee"]
        out[:, column[f"{side}footrx"]] = leg["ankle_y"] + measures.flat_foot_rad

        # The zero posture of the humanoid is a T, that of the plan has hanging arms.
        arm = {name: planned[:, ACTUATED_INDEX[f"{name}_{side.upper()}"]] for name in ARM_HINGES}
        upper = _about(1, arm["shoulder_y"]) @ _about(0, sign * arm["shoulder_x"])
        upper = upper @ _about(2, sign * arm["shoulder_z"])
        write(f"{side}humerus", FROM_CMU @ measures.shoulders[index].T @ upper @ HANGING_ARM @ FROM_CMU.T)
        out[:, column[f"{side}radiusrx"]] = -arm["elbow"]
        out[:, column[f"{side}wristry"]] = measures.wrists_rad[index]
    return out


def _about(axis: int, angle: Array) -> Array:
    """(D, 3, 3) rotations about a coordinate axis by angles (D,) [rad]."""
    rotation = np.tile(np.eye(3), (len(angle), 1, 1))
    first = (axis + 1) % 3
    second = (axis + 2) % 3
    cos = np.cos(angle)
    sin = np.sin(angle)
    rotation[:, first, first] = cos
    rotation[:, first, second] = -sin
    rotation[:, second, first] = sin
    rotation[:, second, second] = cos
    return rotation
