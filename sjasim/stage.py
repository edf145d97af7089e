"""The stage: sole owner of the MuJoCo model and its state, sole caller of the physics step."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from .assets.names import (
    ACTUATED,
    FLOOR_BIT,
    JOINT_INDEX,
    JOINTS,
    ROBOT_PREFIX,
    ROOT_JOINTS,
    TETHERED,
    dancer_prefix,
)
from .choreography.layout import Layout
from .clock import Ticks
from .config import BodyConfig, RobotConfig, StageConfig
from .errors import SjasimError
from .humans.anatomy import Anatomy
from .humans.body import dancer_spec
from .robot.body import robot_spec
from .types import Array, DancerStates, Geoms, IntArray, JointTargets, Servos, WheelCommand, WheelReading

_FLOOR = (0.78, 0.75, 0.70), (0.70, 0.67, 0.62)
_ANKLES = [JOINT_INDEX["AnkleLeft"], JOINT_INDEX["AnkleRight"]]
_HANDS = [JOINT_INDEX["HandLeft"], JOINT_INDEX["HandRight"]]


def stage_spec(
    anatomies: Sequence[Anatomy], layout: Layout, body: BodyConfig, robot: RobotConfig | None, rate_hz: int
) -> mujoco.MjSpec:
    """The whole scene: floor, light, dancers, and a robot unless it is None."""
    spec = mujoco.MjSpec()
    spec.option.timestep = 1.0 / rate_hz
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1280, 960
    spec.visual.headlight.ambient = [0.4, 0.4, 0.4]
    spec.add_texture(
        name="floor", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        width=256, height=256, rgb1=_FLOOR[0], rgb2=_FLOOR[1],
    )  # fmt: skip
    material = spec.add_material(name="floor", texrepeat=[10, 10])
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    spec.worldbody.add_light(pos=[1.5, 1.0, 5], dir=[-0.3, -0.2, -1], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[8, 8, 0.1], material="floor", contype=FLOOR_BIT,
        conaffinity=0, friction=[1.0, 0.005, 0.0001],
    )  # fmt: skip
    for index, anatomy in enumerate(anatomies):
        child = dancer_spec(anatomy, index, len(anatomies), body)
        spec.attach(child, prefix=dancer_prefix(index), frame=spec.worldbody.add_frame())
    if robot is not None:
        frame = spec.worldbody.add_frame(pos=[*layout.robot, 0.0])
        spec.attach(robot_spec(robot), prefix=ROBOT_PREFIX, frame=frame)
    return spec


class Stage:
    """Physics of one session. Sensors see it through the read-only part that `types.StageView` names.

    Args:
        anatomies: one per dancer.
        layout: where everyone stands.
        headings_rad: initial headings of the dancers and of the robot.
        postures: (D, 25) hinge angles at the start [rad].
        pelvises: (D, 3) positions at the start [m].
        config: rates.
        body: tether.
        robot: its parameters, or None for a stage without a robot.
    """

    def __init__(
        self,
        anatomies: Sequence[Anatomy],
        layout: Layout,
        headings_rad: tuple[float, float],
        postures: Array,
        pelvises: Array,
        config: StageConfig,
        body: BodyConfig,
        robot: RobotConfig | None,
    ) -> None:
        self.model = stage_spec(anatomies, layout, body, robot, config.rate_hz).compile()
        self.data = mujoco.MjData(self.model)
        self.ticks = Ticks(config.rate_hz)
        self.tick = 0
        self.has_robot = robot is not None
        self._index(len(anatomies), body.tether == "weak")
        self._place(headings_rad, postures, pelvises)
        leads = self._leads()
        weight = self.model.body_subtreemass[self._pelvis] * 9.81
        leg = np.array([anatomy.thigh_m + anatomy.shank_m for anatomy in anatomies])
        self.servos = Servos(self._stiffness, leads[0], leads[1], weight, leg)

    def _index(self, dancers: int, tethered: bool) -> None:
        m = self.model
        prefixes = [dancer_prefix(index) for index in range(dancers)]
        self._pelvis = np.array([m.body(f"{p}pelvis").id for p in prefixes])
        self._sites = np.array([[m.site(p + joint).id for joint in JOINTS] for p in prefixes])
        self._hinges = np.array([[m.joint(p + name).qposadr[0] for name in ACTUATED] for p in prefixes])
        self._root = np.array([[m.joint(p + name).qposadr[0] for name in ROOT_JOINTS] for p in prefixes])
        self._root_dof = np.array([[m.joint(p + name).dofadr[0] for name in ROOT_JOINTS] for p in prefixes])
        self._servo = np.array([[m.actuator(p + name).id for name in ACTUATED] for p in prefixes])
        self._stiffness = m.actuator_gainprm[self._servo, 0]
        pulls = [[m.actuator(p + name).id for name in TETHERED] for p in prefixes] if tethered else []
        self._tether: IntArray = np.array(pulls, dtype=np.int64).reshape(-1, 5)
        self._tethered = tethered
        owner = np.full(m.ngeom + 1, -1, dtype=np.int64)
        soles = np.full(m.ngeom, -1, dtype=np.int64)
        for geom in range(m.ngeom):
            name = m.geom(geom).name
            for index, prefix in enumerate(prefixes):
                if name.startswith(prefix):
                    owner[geom] = index
                    if m.geom_contype[geom] == 0:
                        soles[geom] = index
        self._owner, self._soles = owner, soles
        self._visible = np.ones(mujoco.mjNGROUP, dtype=np.uint8)
        self._visible[3] = 0
        self._seen = np.flatnonzero(m.geom_group != 3)
        self._form = m.geom_type[self._seen].astype(np.int64)
        self._size = m.geom_size[self._seen]
        self._seen_owner = owner[self._seen]
        if self.has_robot:
            self._base = m.body(f"{ROBOT_PREFIX}base").id
            self._wheels = [m.actuator(f"{ROBOT_PREFIX}{name}").id for name in ("wheel_l", "wheel_r")]
            self._wheel_angles = [m.joint(f"{ROBOT_PREFIX}{name}").qposadr[0] for name in ("wheel_l", "wheel_r")]
            self._gyro = m.sensor(f"{ROBOT_PREFIX}gyro").adr[0] + 2

    def _leads(self) -> tuple[Array, Array]:
        gain, bias = self.model.actuator_gainprm, self.model.actuator_biasprm
        root = np.zeros((len(self._pelvis), 5))
        if self._tethered:
            root = -bias[self._tether, 2] / gain[self._tether, 0]
        return -bias[self._servo, 2] / self._stiffness, root

    def _place(self, headings_rad: tuple[float, float], postures: Array, pelvises: Array) -> None:
        d = self.data
        heading_rad, robot_rad = headings_rad
        d.qpos[self._hinges] = postures
        d.qpos[self._root[:, :3]] = pelvises
        d.qpos[self._root[:, 3]] = heading_rad
        if self.has_robot:
            address = self.model.joint(f"{ROBOT_PREFIX}root").qposadr[0]
            half = robot_rad / 2
            d.qpos[address + 3 : address + 7] = [np.cos(half), 0.0, 0.0, np.sin(half)]
        d.ctrl[self._servo] = postures
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
        d.qpos[self._hinges] = joints
        d.qpos[self._root] = roots
        if robot is not None and self.has_robot:
            address = self.model.joint(f"{ROBOT_PREFIX}root").qposadr[0]
            d.qpos[address : address + 2] = robot[:2]
            d.qpos[address + 3 : address + 7] = [np.cos(robot[2] / 2), 0.0, 0.0, np.sin(robot[2] / 2)]
        mujoco.mj_kinematics(self.model, d)

    @property
    def time_s(self) -> float:
        """Session time: ticks over rate [s]."""
        return self.ticks.time_s(self.tick)

    def step_to(self, tick: int) -> None:
        """Advance the physics to a tick.

        Raises:
            SjasimError: the simulation became unstable.
        """
        if tick > self.tick:
            mujoco.mj_step(self.model, self.data, tick - self.tick)
            self.tick = tick
            if self.data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
                raise SjasimError(f"the physics became unstable before {self.time_s:.2f} s")

    def states(self) -> DancerStates:
        """What balance needs of every dancer."""
        d = self.data
        mujoco.mj_subtreeVel(self.model, d)
        return DancerStates(
            com=d.subtree_com[self._pelvis],
            com_velocity=d.subtree_linvel[self._pelvis],
            root=d.qpos[self._root],
            root_velocity=d.qvel[self._root_dof],
            ankles=d.site_xpos[self._sites[:, _ANKLES]],
        )

    def apply(self, targets: JointTargets) -> None:
        """Set the dancers' actuators; the stage keeps a copy."""
        self.data.ctrl[self._servo] = targets.joints
        if self._tethered:
            self.data.ctrl[self._tether] = targets.root

    def drive(self, command: WheelCommand) -> None:
        """Set the robot's wheel speeds."""
        self.data.ctrl[self._wheels] = (command.left_rad_s, command.right_rad_s)

    def wheels(self) -> WheelReading:
        """What the robot's encoders and gyro would feel, without their quantisation."""
        left, right = self.data.qpos[self._wheel_angles]
        return WheelReading(float(left), float(right), float(self.data.sensordata[self._gyro]))

    def robot_pose(self) -> tuple[float, float, float]:
        """True position and heading (-pi to pi) of the robot [m, m, rad]."""
        x, y, _ = self.data.xpos[self._base]
        forward = self.data.xmat[self._base]
        return float(x), float(y), float(np.arctan2(forward[3], forward[0]))

    @property
    def joints_m(self) -> Array:
        """(D, 25, 3) true joint positions [m]."""
        return np.asarray(self.data.site_xpos[self._sites])

    @property
    def yaw_rad(self) -> Array:
        """(D,) true headings of the pelvises [rad]."""
        return np.asarray(self.data.qpos[self._root[:, 3]])

    @property
    def geoms(self) -> Geoms:
        """Everything visible, at this instant; see `types.StageView`."""
        d = self.data
        rotation = d.geom_xmat[self._seen].reshape(-1, 3, 3)
        return Geoms(self._form, self._size, d.geom_xpos[self._seen], rotation, self._seen_owner)

    def first_hits(self, origin: Array, directions: Array) -> tuple[Array, IntArray]:
        """First surface along rays (N, 3) from a point, and whose it is; see `types.StageView`."""
        count = len(directions)
        geom = np.empty(count, dtype=np.int32)
        distance = np.empty(count)
        mujoco.mj_multiRay(
            self.model, self.data, origin, directions.ravel(), self._visible, 1, -1, geom, distance, None, count,
            10.0,
        )  # fmt: skip
        return distance, self._owner[geom]

    def hand_gaps(self) -> Array:
        """(D,) distance between the hands' centres [m]."""
        hands = self.data.site_xpos[self._sites[:, _HANDS]]
        return np.asarray(np.sqrt(((hands[:, 0] - hands[:, 1]) ** 2).sum(axis=1)))

    def roots(self) -> Array:
        """(D, 6) pelvis x, y, z [m], yaw, pitch, roll [rad]."""
        return np.asarray(self.data.qpos[self._root])

    def tether(self) -> Array:
        """(D, 5) force x, y [N] and torque yaw, pitch, roll [Nm] of each tether at this moment."""
        if not self._tethered:
            return np.zeros((len(self._pelvis), 5))
        return np.asarray(self.data.actuator_force[self._tether])

    def loads(self) -> Array:
        """(D,) floor force that each dancer's feet carry at this moment [N]."""
        d = self.data
        out = np.zeros(len(self._pelvis))
        if d.ncon == 0:
            return out
        pairs, first = d.contact.geom, d.contact.efc_address
        owner = np.maximum(self._soles[pairs[:, 0]], self._soles[pairs[:, 1]])
        active = (owner >= 0) & (first >= 0)
        rows = first[active][:, None] + np.arange(4)
        np.add.at(out, owner[active], d.efc_force[rows].sum(axis=1))
        return out

    def let_go(self, dancer: int) -> None:
        """A fallen dancer's muscles and tether go limp."""
        limp = np.concatenate([self._servo[dancer], *self._tether[dancer : dancer + 1]])
        self.model.actuator_gainprm[limp] = 0.0
        self.model.actuator_biasprm[limp, :2] = 0.0

    def push(self, dancer: int, force: Array) -> None:
        """Pull at a dancer's trunk with a force (3,) until told otherwise [N]."""
        body = self.model.body(f"{dancer_prefix(dancer)}torso").id
        self.data.xfrc_applied[body, :3] = force
