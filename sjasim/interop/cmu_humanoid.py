"""dm_control's CMU humanoid as a dancer: its own shapes and 56 hinges perform what is planned for our 25.

The plan is made with its segments' lengths and masses; each planned joint is then taken apart into the hinges that
the humanoid has there. Its ankles cannot roll, so that its tether has more to do than ours (13-15 N rms against 4 N,
in a dance under the same limits). Its axes are x to the left, y up, z ahead.

Source: tunyasuvunakool2020 (the model). Servos, scaling and the Kinect's joints are ours (assumed).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from math import radians

import mujoco
import numpy as np

from ..assets.colours import dancer_colour
from ..assets.names import ACTUATED, ACTUATED_INDEX, FLOOR_BIT, HAND_BIT, ROBOT_BIT, dancer_bit
from ..config import BodyConfig
from ..core import Array
from ..core.registry import register
from ..humans.body.anatomy import Anatomy, Build, Shape
from ..humans.body.mjcf import ANKLE_ARMATURE, GAINS, SKIN_RGB, TROUSER_SHADE, add_balance_support, add_root
from ..humans.body.mjcf import ARMATURE as OWN_ARMATURE
from ..humans.body.proportions import scaled_anatomy
from .guard import explained

try:
    import dm_control
except ImportError as missing:
    raise explained(missing) from missing

MODEL = "locomotion/walkers/assets/humanoid_CMU_V2020.xml"
OURS = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Rotation from the humanoid's axes to ours."""
STRADDLE_RAD = radians(20.0)
"""In its zero posture the legs are apart by this angle, each."""
HANGING = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Rotation of a hanging upper arm in our axes: the elbow bends it forward."""

SEGMENTS = {
    "pelvis": ("root", "lhipjoint", "rhipjoint"),
    "torso": ("lowerback", "upperback", "thorax", "lclavicle", "rclavicle"),
    "head": ("lowerneck", "upperneck", "head"),
    **{f"upper_arm_{side.upper()}": (f"{side}humerus",) for side in "lr"},
    **{f"forearm_{side.upper()}": tuple(side + bone for bone in ("radius", "wrist", "hand", "fingers", "thumb"))
       for side in "lr"},
    **{f"thigh_{side.upper()}": (f"{side}femur",) for side in "lr"},
    **{f"shank_{side.upper()}": (f"{side}tibia",) for side in "lr"},
    **{f"foot_{side.upper()}": (f"{side}foot", f"{side}toes") for side in "lr"},
}  # fmt: skip
"""Planned segment -> the bodies that move with it, the one at its joint first."""

SITES = {
    "SpineMid": ("upperback", (0.0, 0.05, 0.0)),
    "SpineShoulder": ("lowerneck", (0.0, 0.0, 0.0)),
    "Neck": ("upperneck", (0.0, 0.0, 0.0)),
    "Head": ("head", (0.0, 0.048, 0.025)),
    **{name + word: (side + bone, offset) for side, word in (("l", "Left"), ("r", "Right")) for name, bone, offset in (
        ("Shoulder", "humerus", (0.0, 0.0, 0.0)), ("Elbow", "radius", (0.0, 0.0, 0.0)),
        ("Wrist", "hand", (0.0, 0.0, 0.0)), ("Hand", "hand", (0.0, -0.0168, 0.0)),
        ("HandTip", "fingers", (0.0, -0.065, 0.0)), ("Thumb", "thumb", (0.0, -0.06, 0.0)),
        ("Hip", "femur", (0.0, 0.0, 0.0)), ("Knee", "tibia", (0.0, 0.0, 0.0)),
        ("Ankle", "foot", (0.0, 0.0, 0.0)), ("Foot", "toes", (0.0, 0.0, 0.0)))},
}  # fmt: skip
"""Kinect joint -> body of the humanoid and place in it [m]; the base of the spine lies between the hips."""

LEG = {"hip_x": "femurrz", "hip_z": "femurry", "hip_y": "femurrx", "knee": "tibiarx", "ankle_y": "footrx",
       "ankle_x": "footrz"}  # fmt: skip
ARM = {"shoulder_x": "humerusrz", "shoulder_y": "humerusrx", "shoulder_z": "humerusry", "elbow": "radiusrx"}
TRUNK = {"abdomen_x": "lowerbackrz", "abdomen_z": "lowerbackry", "abdomen_y": "lowerbackrx",
         "neck_z": "lowerneckry", "neck_y": "lowerneckrx"}  # fmt: skip
"""Planned hinge -> the humanoid's hinge with nearly the same axis, whose servo gets its gains."""

OTHER_GAINS = {"toes": (60.0, 20.0), "back": (1500.0, 200.0), "thorax": (1500.0, 200.0), "neck": (60.0, 20.0),
               "head": (60.0, 20.0), "clavicle": (300.0, 60.0), "wrist": (40.0, 20.0), "hand": (20.0, 10.0),
               "fingers": (3.0, 2.0), "thumb": (3.0, 2.0)}  # fmt: skip
"""Part of a hinge's name -> stiffness [Nm/rad] and torque limit [Nm] where nothing is planned (assumed)."""

ARMATURE = {"foot": ANKLE_ARMATURE, "toes": ANKLE_ARMATURE, "back": 0.10, "thorax": 0.10}
"""Part of a hinge's name -> inertia of its muscles [kg m^2], where not ours (assumed): so light a vertebra or foot
would quiver between stiff neighbours."""


@dataclass(frozen=True, slots=True)
class Native:
    """The humanoid as it comes, standing upright, arms down, in our axes from between its hips [m].

    Attributes:
        hinges: names.
        place: body -> origin (3,).
        centre: body -> centre of mass (3,).
        mass: body -> [kg].
        joints: Kinect joint -> place (3,).
        shoulders: (2, 3, 3) rotation of left and right upper arm at zero, in our axes.
        wrists_rad: turn of left and right hand that lets the palms face each other.
        flat_rad: angle of the foot's hinge at which the sole is flat on the floor.
        ankle_m: height of the ankle then.
        stature_m: height of the whole.
        middle: (3,) between the hips, in the humanoid's own axes.
    """

    hinges: tuple[str, ...]
    place: dict[str, Array]
    centre: dict[str, Array]
    mass: dict[str, float]
    joints: dict[str, Array]
    shoulders: Array
    wrists_rad: tuple[float, float]
    flat_rad: float
    ankle_m: float
    stature_m: float
    middle: Array


def _source() -> mujoco.MjSpec:
    """The model as dm_control ships it, without what a stage has no use for."""
    path = resources.files(dm_control).joinpath(MODEL)
    spec = mujoco.MjSpec.from_file(str(path))
    for item in (*spec.lights, *spec.cameras, *spec.sites, *spec.actuators, *spec.sensors, *spec.excludes):
        spec.delete(item)
    spec.default.actuator.ctrllimited = False
    spec.njmax = spec.nconmax = -1  # as many as there are
    return spec


@cache
def native() -> Native:
    """Measure the humanoid, standing as we stand."""
    model = _source().compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    shoulders = np.array([OURS @ data.body(f"{side}humerus").xmat.reshape(3, 3) for side in "lr"])
    hands = np.array([OURS @ data.body(f"{side}hand").xmat.reshape(3, 3) for side in "lr"])
    wrists = _facing(shoulders[0].T @ hands[0], 1), _facing(shoulders[1].T @ hands[1], -1)
    hinges = tuple(model.joint(index).name for index in range(model.njnt))
    flat, drop = _flat_sole(model, data)
    known = Native(hinges, {}, {}, {}, {}, shoulders, wrists, flat, 0.0, 0.0, np.zeros(3))
    data.qpos[:] = _angles(known, np.zeros((1, 25)))[0]
    mujoco.mj_forward(model, data)
    middle = (data.body("lfemur").xpos + data.body("rfemur").xpos) / 2
    names = [model.body(index).name for index in range(1, model.nbody)]
    place = {name: OURS @ (data.body(name).xpos - middle) for name in names}
    place["root"] = np.zeros(3)
    joints = {name: OURS @ (data.body(body).xpos + data.body(body).xmat.reshape(3, 3) @ offset - middle)
              for name, (body, offset) in SITES.items()}  # fmt: skip
    crown = model.geom("head")
    top = float(data.geom("head").xpos[1] + crown.size[0] + crown.size[1])
    return replace(
        known, place=place, centre={name: OURS @ (data.body(name).xipos - middle) for name in names},
        mass={name: float(model.body(name).mass[0]) for name in names},
        joints={**joints, "SpineBase": np.zeros(3)}, ankle_m=drop,
        stature_m=top - float(data.body("lfoot").xpos[1]) + drop, middle=middle,
    )  # fmt: skip


def _facing(hand: Array, sign: int) -> float:
    """Turn of a hand about its length, given its rotation in the arm, that lets a hanging palm face the body."""
    outward = hand.T @ HANGING.T @ np.array([0.0, sign, 0.0])
    return float(np.arctan2(outward[0], outward[2]))


def _flat_sole(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[float, float]:
    """Angle of the foot's hinge that puts heel and toes at one height, and how far they are below the ankle then."""
    ankle, toes, foot = data.body("lfoot"), data.geom("ltoes0"), data.geom("lfoot")
    along = ankle.xmat.reshape(3, 3)
    ends = [foot.xpos + end * model.geom("lfoot").size[1] * foot.xmat.reshape(3, 3)[:, 2] for end in (-1, 1)]
    local = [along.T @ (point - ankle.xpos) for point in (*ends, toes.xpos)]
    heel = max(local, key=lambda point: float(point[1]))
    tip = local[-1]
    tilt = float(np.arctan2(heel[2] - tip[2], heel[1] - tip[1]))
    drop = -float(np.cos(tilt) * heel[2] - np.sin(tilt) * heel[1]) + float(model.geom("lfoot").size[0])
    return -tilt, drop


def _angles(known: Native, planned: Array) -> Array:
    """(D, 56) angles of the humanoid's hinges for planned ones (D, 25) [rad]."""
    column = {name: index for index, name in enumerate(known.hinges)}
    out = np.zeros((len(planned), len(known.hinges)))

    def write(bone: str, turn: Array) -> None:
        """Angles of z, y and x that make a rotation in our axes, for a bone whose own axes are the humanoid's."""
        out[:, column[f"{bone}rz"]] = np.arctan2(turn[:, 2, 1], turn[:, 1, 1])
        out[:, column[f"{bone}ry"]] = -np.arcsin(np.clip(turn[:, 0, 1], -1.0, 1.0))
        out[:, column[f"{bone}rx"]] = np.arctan2(turn[:, 0, 2], turn[:, 0, 0])

    trunk = {name: planned[:, ACTUATED_INDEX[name]] for name in TRUNK}
    write("lowerback", _turn(2, trunk["abdomen_z"]) @ _turn(1, trunk["abdomen_y"]) @ _turn(0, trunk["abdomen_x"]))
    write("lowerneck", _turn(1, trunk["neck_y"]) @ _turn(2, trunk["neck_z"]))
    for index, (side, sign) in enumerate((("l", 1), ("r", -1))):
        leg = {name: planned[:, ACTUATED_INDEX[f"{name}_{side.upper()}"]] for name in LEG}
        arm = {name: planned[:, ACTUATED_INDEX[f"{name}_{side.upper()}"]] for name in ARM}
        write(f"{side}femur", _turn(2, leg["hip_z"]) @ _turn(0, leg["hip_x"]) @ _turn(1, leg["hip_y"]))
        out[:, column[f"{side}femurrz"]] -= sign * STRADDLE_RAD
        out[:, column[f"{side}tibiarx"]] = leg["knee"]
        out[:, column[f"{side}footrx"]] = leg["ankle_y"] + known.flat_rad
        upper = _turn(1, arm["shoulder_y"]) @ _turn(0, sign * arm["shoulder_x"]) @ _turn(2, sign * arm["shoulder_z"])
        write(f"{side}humerus", OURS @ known.shoulders[index].T @ upper @ HANGING @ OURS.T)
        out[:, column[f"{side}radiusrx"]] = -arm["elbow"]
        out[:, column[f"{side}wristry"]] = known.wrists_rad[index]
    return out


def _turn(axis: int, angle: Array) -> Array:
    """(D, 3, 3) rotations by angles (D,) about an axis of the frame."""
    out = np.tile(np.eye(3), (len(angle), 1, 1))
    a, b = (axis + 1) % 3, (axis + 2) % 3
    cos, sin = np.cos(angle), np.sin(angle)
    out[:, a, a], out[:, a, b], out[:, b, a], out[:, b, b] = cos, -sin, sin, cos
    return out


@register("body", "cmu")
class CmuBody:
    """dm_control's CMU humanoid (version 2020), scaled to a dancer's stature and mass."""

    leading = tuple(TRUNK[name] if name in TRUNK else name[-1].lower() + {**LEG, **ARM}[name[:-2]] for name in ACTUATED)

    @property
    def hinges(self) -> tuple[str, ...]:
        """Every hinge of the humanoid."""
        return native().hinges

    def angles(self, planned: Array) -> Array:
        """Each planned joint's rotation in the order of axes that the humanoid has there."""
        return _angles(native(), planned)

    def anatomy(self, build: Build) -> Anatomy:
        """The humanoid's own lengths and masses in our tables."""
        known, ours = native(), scaled_anatomy(build)
        scale, share = build.stature_m / known.stature_m, build.mass_kg / sum(known.mass.values())
        place = {name: known.place[bodies[0]] for name, bodies in SEGMENTS.items()}
        segments, names = [], [segment.name for segment in ours.segments]
        for segment in ours.segments:
            own = place[segment.name]
            above = place[names[segment.parent]] if segment.parent >= 0 else own
            shapes = tuple(
                Shape(body, "sphere", tuple(scale * (known.centre[body] - own)), (0, 0, 0), (0.0,), share * mass)
                for body in SEGMENTS[segment.name] if (mass := known.mass[body]) > 0.0
            )  # fmt: skip
            segments.append(replace(segment, offset=tuple(scale * (own - above)), shapes=shapes))
        joints = {
            name: (row, tuple(scale * (known.joints[name] - place[names[row]])))
            for name, (row, _) in ours.joints.items()
        }
        return replace(
            ours, segments=tuple(segments), joints=joints, model="cmu", ankle_m=scale * known.ankle_m,
            thigh_m=scale * float(place["thigh_L"][2] - place["shank_L"][2]),
            shank_m=scale * float(place["shank_L"][2] - place["foot_L"][2]),
            hip_m=scale * float(place["thigh_L"][1]), hand_half_m=scale * 0.02,
        )  # fmt: skip

    def spec(self, anatomy: Anatomy, index: int, group: int, config: BodyConfig) -> mujoco.MjSpec:
        """See `humans.body.dancer_spec`."""
        known, build = native(), anatomy.build
        scale = build.stature_m / known.stature_m
        spec = _source()
        spec.modelname = "dancer"
        _scale(spec, scale, build.mass_kg / (sum(known.mass.values()) * scale**3))
        pelvis = spec.body("root")
        pelvis.name, spec.body("thorax").name = "pelvis", "torso"
        pelvis.pos, pelvis.quat = -scale * (OURS @ known.middle), [0.5, 0.5, 0.5, 0.5]
        add_root(pelvis, OURS.T, scale * known.middle)
        for geom in spec.geoms:
            _dress(geom, index, group)
        for name, (body, offset) in {**SITES, "SpineBase": ("pelvis", known.middle)}.items():
            spec.body(body).add_site(name=name, pos=scale * np.array(offset), size=[0.01] * 3, group=4)
        for name in known.hinges:
            _servo(spec, name, build)
        add_balance_support(spec, build, config)
        return spec


def _scale(spec: mujoco.MjSpec, scale: float, density: float) -> None:
    for body in spec.bodies:
        body.pos = scale * body.pos
    for geom in spec.geoms:
        geom.pos, geom.size, geom.density = scale * geom.pos, scale * geom.size, density * geom.density
    for joint in spec.joints:
        joint.pos, joint.stiffness = scale * joint.pos, np.zeros(3)  # its springs pull towards a T
        if joint.name.endswith("humerusrz"):
            joint.limited = False  # the right one's range is the left one's: it could not let its arm hang


def _dress(geom: mujoco.MjsGeom, index: int, group: int) -> None:
    """Contacts and colours as our own dancers have them; soles meet the floor, hands each other."""
    own = dancer_bit(index)
    others = ROBOT_BIT | sum(dancer_bit(other) for other in range(group) if other != index)
    name = geom.name[1:]
    skin = name.startswith(("hand", "finger", "thumb", "wrist")) or geom.name in ("head", "upperneck", "lowerneck")
    shade = (
        TROUSER_SHADE if name.startswith(("femur", "tibia", "foot", "toes", "hip")) or geom.name == "root_geom" else 1.0
    )
    cloth = [shade * (0.12 + 0.88 * value / 255) for value in dancer_colour(index)]
    geom.material, geom.rgba = "", [*(SKIN_RGB if skin else cloth), 1.0]
    geom.contype, geom.conaffinity, geom.condim = own, others, 3
    if name.startswith(("hand", "finger")):
        geom.contype, geom.conaffinity = own | HAND_BIT, others | HAND_BIT
    elif name.startswith(("foot", "toes")):
        geom.conaffinity = others | FLOOR_BIT


def _servo(spec: mujoco.MjSpec, hinge: str, build: Build) -> None:
    leading = dict(zip(CmuBody.leading, ACTUATED, strict=True))
    if hinge in leading:
        gains: tuple[float, float] = GAINS[leading[hinge].removesuffix("_L").removesuffix("_R")]
    else:
        gains = next(value for part, value in OTHER_GAINS.items() if part in hinge)
    strength = build.mass_kg / 75.0 * (build.stature_m / 1.75) ** 2
    heavy = next((value for part, value in ARMATURE.items() if part in hinge), OWN_ARMATURE)
    spec.joint(hinge).armature = strength * heavy
    servo = spec.add_actuator(name=hinge, target=hinge, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    servo.set_to_position(kp=strength * gains[0], dampratio=1.0)
    servo.forcelimited, servo.forcerange = True, [-strength * gains[1], strength * gains[1]]
