"""The stage: sole owner of the MuJoCo model and its state, sole caller of the physics step."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from ..assets.names import (
    ACTUATED,
    FLOOR_BIT,
    JOINT_INDEX,
    JOINTS,
    ROBOT_PREFIX,
    ROOT_JOINTS,
    TETHERED,
    dancer_prefix,
)
from ..choreography.layout import Layout
from ..config import BodyConfig, PhysicsConfig, RobotConfig
from ..core import Array, DancerStates, Geoms, IntArray, Servos, Solids, WheelCommand
from ..core.clock import Ticks
from ..core.errors import SjasimError
from ..core.memory import Memory
from ..humans.body.anatomy import Anatomy
from ..humans.body.body_model import BodyModel, body_model
from ..robot.mjcf import robot_spec
from ..sensors.raycast.occlusion import bounding_shapes
from .contacts import Contacts
from .state_access import PELVIS, RATES, feel, gather

_FLOOR = (0.74, 0.72, 0.69), (0.66, 0.64, 0.61)
_SKY = (0.80, 0.86, 0.92), (0.97, 0.97, 0.96)
LYING_ARMATURE, LYING_DAMPING = 0.5, 20.0
"""Inertia [kg m^2] and damping [Nm s/rad] about a lying body's three axes, two of which may be one (assumed)."""
_LOGGED = [JOINT_INDEX[name] for name in ("AnkleLeft", "AnkleRight", "HandLeft", "HandRight")]


def scene_spec(
    anatomies: Sequence[Anatomy], layout: Layout, body: BodyConfig, robot: RobotConfig | None, rate_hz: int
) -> mujoco.MjSpec:
    """The whole scene: floor, light, dancers, and a robot unless it is None."""
    spec = mujoco.MjSpec()
    spec.option.timestep = 1.0 / rate_hz
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    _light(spec)
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.1], material="floor", contype=FLOOR_BIT,
        conaffinity=0, friction=[1.0, 0.005, 0.0001],
    )  # fmt: skip
    for index, anatomy in enumerate(anatomies):
        child = body_model(body.model).spec(anatomy, index, len(anatomies), body)
        spec.attach(child, prefix=dancer_prefix(index), frame=spec.worldbody.add_frame())
    if robot is not None:
        frame = spec.worldbody.add_frame(pos=[*layout.robot, 0.0])
        spec.attach(robot_spec(robot), prefix=ROBOT_PREFIX, frame=frame)
    return spec


def _light(spec: mujoco.MjSpec) -> None:
    """Sky, floor and lamps; nothing that a ray or the physics could meet."""
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1280, 960
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.45] * 3, [0.30] * 3
    spec.visual.headlight.specular = [0.0] * 3
    spec.visual.quality.shadowsize = 4096
    spec.visual.rgba.haze, spec.visual.map.haze = [*_SKY[1], 1.0], 0.5
    spec.stat.center, spec.stat.extent = [0.0, 0.0, 0.8], 6.0  # the shadows' and the far plane's measure
    cube, plane = mujoco.mjtTexture.mjTEXTURE_SKYBOX, mujoco.mjtTexture.mjTEXTURE_2D
    gradient, checker = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT, mujoco.mjtBuiltin.mjBUILTIN_CHECKER
    spec.add_texture(name="sky", type=cube, builtin=gradient, width=128, height=768, rgb1=_SKY[0], rgb2=_SKY[1])
    spec.add_texture(name="floor", type=plane, builtin=checker, width=256, height=256, rgb1=_FLOOR[0], rgb2=_FLOOR[1])
    material = spec.add_material(name="floor", texrepeat=[0.5, 0.5], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    lamp = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    spec.worldbody.add_light(pos=[3, 1.5, 8], dir=[-0.4, -0.2, -1], type=lamp, diffuse=[0.5] * 3, specular=[0.1] * 3)


class Physics:
    """Physics of one session. Sensors see it through the read-only part that `types.SceneView` names.

    Args:
        anatomies: one per dancer.
        layout: where everyone stands.
        headings_rad: initial headings of the dancers and of the robot.
        postures: (D, 25) hinge angles at the start [rad].
        pelvises: (D, 3) positions at the start [m].
        config: rates.
        body: tether.
        robot: its parameters, or None for a stage without a robot.

    Attributes:
        direct: whether the bodies' hinges are the planned ones.
        where: (D, ...) addresses of what belongs to each dancer, see `addresses.PELVIS`.
        felt: all that `addresses.gather` takes but its output.
        ctrl: the physics' own array of actuator commands.
        robot: what its turn reads: coordinates, sensors, places and attitudes of bodies, and its addresses.
    """

    def __init__(
        self,
        anatomies: Sequence[Anatomy],
        layout: Layout,
        headings_rad: tuple[float, float],
        postures: Array,
        pelvises: Array,
        config: PhysicsConfig,
        body: BodyConfig,
        robot: RobotConfig | None,
    ) -> None:
        self._body: BodyModel = body_model(body.model)
        self.model = scene_spec(anatomies, layout, body, robot, config.rate_hz).compile()
        self.data = mujoco.MjData(self.model)
        self.ticks = Ticks(config.rate_hz)
        d = self.data  # its arrays stay where they are, and looking them up costs more than reading them
        self._qpos, self._qvel, self.ctrl, self._xpos, self._xmat = d.qpos, d.qvel, d.ctrl, d.xpos, d.xmat
        self._warning = d.warning[mujoco.mjtWarning.mjWARN_BADQACC]
        self._joints: Array = np.empty(0)
        self._joints_tick = -1
        self.tick = 0
        self.time_s = 0.0
        """Session time: ticks over rate [s]."""
        self.has_robot = robot is not None
        self._index(len(anatomies), body.balance_support == "weak")
        self._place(headings_rad, postures, pelvises)
        self.contacts = Contacts(self.model, d, self._shell, np.flatnonzero(self._owner >= 0), self._base)
        """Where the robot touches dancers."""
        leads, pelvis = self._leads(), self.where[:, PELVIS]
        weight = self.model.body_subtreemass[pelvis] * 9.81
        leg = np.array([anatomy.thigh_m + anatomy.shank_m for anatomy in anatomies])
        self.servos = Servos(self._stiffness, leads[0], leads[1], weight, leg)

    def _index(self, dancers: int, tethered: bool) -> None:
        m = self.model
        prefixes = [dancer_prefix(index) for index in range(dancers)]
        pelvis = np.array([m.body(f"{p}pelvis").id for p in prefixes])
        self._sites = np.array([[m.site(p + joint).id for joint in JOINTS] for p in prefixes])
        hinges, leading = self._body.hinges, self._body.leading
        self._shape = (dancers, len(JOINTS), 3)
        self._hinges = np.array([[m.joint(p + name).qposadr[0] for name in hinges] for p in prefixes])
        self._root = np.array([[m.joint(p + name).qposadr[0] for name in ROOT_JOINTS] for p in prefixes])
        root_dof = np.array([[m.joint(p + name).dofadr[0] for name in ROOT_JOINTS] for p in prefixes])
        self._servo = np.array([[m.actuator(p + name).id for name in hinges] for p in prefixes])
        self._leading = np.array([[m.actuator(p + name).id for name in leading] for p in prefixes])
        self._stiffness = m.actuator_gainprm[self._leading, 0]
        pulls = [[m.actuator(p + name).id for name in TETHERED] for p in prefixes] if tethered else []
        self._tether: IntArray = np.array(pulls, dtype=np.int64).reshape(-1, 5)
        self._tethered = tethered
        wires = self._tether if tethered else np.full((dancers, 5), -1)
        body = np.column_stack([pelvis, m.body_rootid[pelvis], [_behind(m, body) for body in pelvis]])
        self.direct = tuple(hinges) == ACTUATED
        servos = self._servo if self.direct else np.full((dancers, len(ACTUATED)), -1)
        self.where = np.hstack([body, self._root, root_dof, self._sites[:, _LOGGED], servos, wires]).astype(np.int64)
        masses = np.concatenate([m.body_mass, m.body_subtreemass[pelvis]])
        self._load = np.zeros(dancers)
        d = self.data
        sites, lifts = self._sites.astype(np.int64), root_dof[:, 2].astype(np.int64)
        self._looks = Memory(d.site_xpos, sites, d.qfrc_constraint, lifts, self._load)
        self.felt = (
            d.subtree_com, d.cvel, d.xipos, d.qpos, d.qvel, d.site_xpos, d.actuator_force, self._load, masses,
            m.body_parentid.astype(np.int64), np.zeros((m.nbody, 3)), self.where,
        )  # fmt: skip
        owner = np.full(m.ngeom, -1, dtype=np.int64)
        names = [m.geom(geom).name for geom in range(m.ngeom)]
        self._shell = np.flatnonzero([name.startswith(ROBOT_PREFIX) for name in names])
        for index, prefix in enumerate(prefixes):
            owner[[name.startswith(prefix) for name in names]] = index
        self._solid = np.flatnonzero((m.geom_group != 3) & (m.geom_rgba[:, 3] > 0))
        self._positions, self._rotations = self.data.geom_xpos, self.data.geom_xmat
        self._form, self._size = m.geom_type[self._solid].astype(np.int64), m.geom_size[self._solid]
        self._owner, self._solid_owner = owner, owner[self._solid]
        rows = np.column_stack([self._solid, self._solid_owner, self._form])
        self.solids = Solids(rows, bounding_shapes(self._form, self._size), self._positions, self._rotations)
        """All that can hide something; see `types.SceneView`."""
        self._base = m.body(f"{ROBOT_PREFIX}base").id if self.has_robot else 0
        if self.has_robot:
            wheels = [f"{ROBOT_PREFIX}{name}" for name in ("wheel_l", "wheel_r")]
            self._wheels = [m.actuator(name).id for name in wheels]
            angles, gyro = [m.joint(name).qposadr[0] for name in wheels], m.sensor(f"{ROBOT_PREFIX}gyro").adr[0] + 2
            where = np.array([*angles, gyro, self._base, *self._wheels])
            self.robot = d.qpos, d.sensordata, d.xpos, d.xmat, where

    def _leads(self) -> tuple[Array, Array]:
        gain, bias = self.model.actuator_gainprm, self.model.actuator_biasprm
        root = np.zeros((len(self.where), 5))
        if self._tethered:
            root = -bias[self._tether, 2] / gain[self._tether, 0]
        return -bias[self._leading, 2] / self._stiffness, root

    def _place(self, headings_rad: tuple[float, float], postures: Array, pelvises: Array) -> None:
        d = self.data
        heading_rad, robot_rad = headings_rad
        d.qpos[self._hinges] = self._body.angles(postures)
        d.qpos[self._root[:, :3]] = pelvises
        d.qpos[self._root[:, 3]] = heading_rad
        if self.has_robot:
            address = self.model.joint(f"{ROBOT_PREFIX}root").qposadr[0]
            half = robot_rad / 2
            d.qpos[address + 3 : address + 7] = [np.cos(half), 0.0, 0.0, np.sin(half)]
        d.ctrl[self._servo] = d.qpos[self._hinges]
        if self._tethered:
            d.ctrl[self._tether[:, :2]] = pelvises[:, :2]
            d.ctrl[self._tether[:, 2]] = heading_rad
        mujoco.mj_forward(self.model, d)

    def pose(self, joints: Array, roots: Array, robot: tuple[float, float, float] | None = None) -> None:
        """Put everyone in a posture without physics, for pictures of bodies that need not balance.

        Args:
            joints: (D, 25) hinge angles [rad].
            roots: (D, 6) pelvis x, y, z [m], yaw, pitch, roll [rad].
            robot: its position and heading [m, m, rad]; None leaves it where it is.
        """
        d = self.data
        d.qpos[self._hinges] = self._body.angles(joints)
        d.qpos[self._root] = roots
        if robot is not None and self.has_robot:
            address = self.model.joint(f"{ROBOT_PREFIX}root").qposadr[0]
            d.qpos[address : address + 2] = robot[:2]
            d.qpos[address + 3 : address + 7] = [np.cos(robot[2] / 2), 0.0, 0.0, np.sin(robot[2] / 2)]
        mujoco.mj_kinematics(self.model, d)
        self._joints_tick = -1

    def step_to(self, tick: int) -> None:
        """Advance the physics to a tick."""
        if tick > self.tick:
            mujoco.mj_step(self.model, self.data, tick - self.tick)
            self.tick = tick
            self.time_s = self.ticks.time_s(tick)

    def check(self) -> None:
        """Make sure that the physics is still sound; now and then is enough.

        Raises:
            SjasimError: the simulation became unstable.
        """
        if self._warning.number:
            raise SjasimError(f"the physics became unstable before {self.time_s:.2f} s")

    def states(self) -> DancerStates:
        """What balance needs of every dancer, and the record."""
        rows = np.empty((len(self.where), 36))
        gather(*self.felt, rows)
        return DancerStates(rows)

    def feel(self) -> None:
        """Take what the floor carries at this moment, for the states to come, and where joints are.

        Forces at the balance controller's own ticks would be those of targets as old as they get; so somebody who is
        out of step with it asks. Only soles meet the floor: beside a brush with somebody else, all that holds a body
        up at its root is what its feet carry.
        """
        joints = np.empty(self._shape)
        feel(joints, self._looks.table)
        self._keep(joints)

    def bend(self, joints: Array) -> None:
        """Set the hinge servos of bodies that are not `direct`, for targets (D, 25) of the planned hinges [rad]."""
        self.ctrl[self._servo] = self._body.angles(joints)

    def drive(self, command: WheelCommand) -> None:
        """Set the robot's wheel speeds."""
        left, right = self._wheels
        self.ctrl[left], self.ctrl[right] = command.left_rad_s, command.right_rad_s

    def robot_pose(self) -> tuple[float, float, float]:
        """True position and heading (-pi to pi) of the robot [m, m, rad]."""
        place, turn = 3 * self._base, 9 * self._base
        x, y = self._xpos.item(place), self._xpos.item(place + 1)
        return x, y, math.atan2(self._xmat.item(turn + 3), self._xmat.item(turn))

    @property
    def joints_m(self) -> Array:
        """(D, 25, 3) true joint positions, an array for each tick [m]."""
        if self._joints_tick != self.tick:
            self._keep(self.data.site_xpos[self._sites])
        return self._joints

    def _keep(self, joints: Array) -> None:
        joints.setflags(write=False)
        self._joints, self._joints_tick = joints, self.tick

    @property
    def yaw_rad(self) -> Array:
        """(D,) true headings of the pelvises [rad]."""
        return np.asarray(self._qpos.take(self._root[:, 3]))

    @property
    def geoms(self) -> Geoms:
        """Everything visible, at this instant; see `types.SceneView`."""
        rotation = self._rotations[self._solid].reshape(-1, 3, 3)
        return Geoms(self._form, self._size, self._positions[self._solid], rotation, self._solid_owner)

    def height_m(self, dancer: int) -> float:
        """Height of a dancer's pelvis [m]."""
        return float(self._qpos.item(self._root.item(dancer, 2)))

    def let_go(self, dancer: int) -> None:
        """A fallen dancer's muscles and tether go limp, and all of the body meets the floor."""
        m = self.model
        limp = np.concatenate([self._servo[dancer], *self._tether[dancer : dancer + 1]])
        m.actuator_gainprm[limp] = 0.0
        m.actuator_biasprm[limp, :2] = 0.0
        flesh = np.flatnonzero(self._owner == dancer)
        m.geom_conaffinity[flesh] |= FLOOR_BIT
        m.body_conaffinity[m.geom_bodyid[flesh]] |= FLOOR_BIT
        turns = self.where[dancer, RATES + 3 : RATES + 6]  # of one who lies on the face, yaw and roll are the same
        m.dof_armature[turns], m.dof_damping[turns] = LYING_ARMATURE, LYING_DAMPING

    def push(self, dancer: int, force: Array) -> None:
        """Pull at a dancer's trunk with a force (3,) until told otherwise [N]."""
        body = self.model.body(f"{dancer_prefix(dancer)}torso").id
        self.data.xfrc_applied[body, :3] = force


def _behind(model: mujoco.MjModel, body: int) -> int:
    """The first body behind those that hang on one; they stand together."""
    last = body + 1
    while last < model.nbody and model.body_parentid[last] >= body:
        last += 1
    return last
