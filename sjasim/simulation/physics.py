"""MuJoCo model and state of one session: its only owner, and the only caller of the physics step."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from ..assets.names import ACTUATED, FLOOR_BIT, dancer_prefix
from ..choreography.layout import Layout
from ..config import BodyConfig, PhysicsConfig, RobotConfig
from ..core import Array, DancerStates, Geoms, Servos, Solids, WheelCommand, WheelReading
from ..core.bodies import DANCER_STATE_WIDTH
from ..core.clock import Ticks
from ..core.errors import SjasimError
from ..humans.body.anatomy import Anatomy
from ..humans.body.body_model import BodyModel, body_model
from ..sensors.raycast.occlusion import bounding_shapes
from .contacts import Contacts
from .scene import scene_spec
from .state_access import DancerIndices, RobotIndices, read_dancer_states

GRAVITY_M_S2 = 9.81

LYING_ARMATURE = 0.5
"""Inertia about each of the three axes of a fallen dancer's root [kg m^2]; assumed. With a body on its face yaw and
roll are one axis, and without this inertia the root's rates would grow without bound."""

LYING_DAMPING = 20.0
"""Damping about the same axes [Nm s/rad]; assumed."""

COLLISION_GROUP = 3
"""MuJoCo's group of geoms that only collide; sensors do not see them."""


class Physics:
    """Physics of one session. Sensors read it through the protocol `SceneView`.

    MuJoCo's arrays stay where they are for as long as the data lives, so views of them are kept.

    Args:
        anatomies: one for each dancer.
        layout: places of dancers and robot.
        headings_rad: initial headings of the dancers and of the robot.
        postures: (D, 25) initial angles of the planned hinges [rad].
        pelvises: (D, 3) initial positions of the pelvises [m].
        config: rates.
        body: body model and balance support.
        robot: parameters of the robot, or None for a scene without one.

    Attributes:
        model: MuJoCo's model.
        data: MuJoCo's state.
        ticks: converts physics steps to session time.
        tick: physics steps so far.
        time_s: session time: ticks over rate.
        contacts: where the robot touches dancers.
        servos: the dancers' actuators, for the balance controller.
        solids: geoms that can occlude something, see `SceneView`.
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
        self.ticks = Ticks(config.rate_hz)
        self.tick = 0
        self.time_s = 0.0
        self._body: BodyModel = body_model(body.model)
        self.model = scene_spec(anatomies, layout, body, robot, config.rate_hz).compile()
        self.data = mujoco.MjData(self.model)
        self._qacc_warning = self.data.warning[mujoco.mjtWarning.mjWARN_BADQACC]

        tethered = body.balance_support == "weak"
        self._dancers = DancerIndices.of(self.model, self._body, len(anatomies), tethered=tethered)
        self._robot = None if robot is None else RobotIndices.of(self.model)
        self._prepare_states()
        self._prepare_targets()
        self.solids = self._visible_geoms()
        self._place(headings_rad, postures, pelvises)

        robot_geoms = np.zeros(0, dtype=np.int64) if self._robot is None else self._robot.geoms
        dancer_geoms = np.flatnonzero(self._dancers.geom_owner >= 0)
        base = 0 if self._robot is None else self._robot.base
        self.contacts = Contacts(self.model, self.data, robot_geoms, dancer_geoms, base)
        self.servos = self._servos(anatomies)

    @property
    def has_robot(self) -> bool:
        """Whether there is a robot in the scene."""
        return self._robot is not None

    def _prepare_states(self) -> None:
        """Collect what `read_dancer_states` needs, and work space."""
        model = self.model
        dancers = self._dancers
        count = len(dancers.pelvis)
        self._joints_m: Array = np.empty(0)
        self._joints_tick = -1
        self._load_n = np.zeros(count)
        self._lift_dof = dancers.root_dof[:, 2]
        self._masses = np.concatenate([model.body_mass, model.body_subtreemass[dancers.pelvis]])
        self._parents = model.body_parentid.astype(np.int64)
        self._momentum = np.zeros((model.nbody, 3))

    def _prepare_targets(self) -> None:
        """Find the actuators that take the balance controller's targets."""
        self._planned_hinges = tuple(self._body.hinges) == ACTUATED
        self._target_actuators, self._target_places = self._dancers.target_actuators(
            planned_hinges=self._planned_hinges
        )

    def _visible_geoms(self) -> Solids:
        """Geoms that a sensor sees, which are also those that occlude."""
        model = self.model
        self._visible = np.flatnonzero((model.geom_group != COLLISION_GROUP) & (model.geom_rgba[:, 3] > 0))
        self._geom_type = model.geom_type[self._visible].astype(np.int64)
        self._geom_size = model.geom_size[self._visible]
        self._geom_owner = self._dancers.geom_owner[self._visible]
        rows = np.column_stack([self._visible, self._geom_owner, self._geom_type])
        return Solids(rows, bounding_shapes(self._geom_type, self._geom_size), self.data.geom_xpos, self.data.geom_xmat)

    def _servos(self, anatomies: Sequence[Anatomy]) -> Servos:
        """Stiffness and feed-forward time (damping over stiffness) of the dancers' actuators."""
        gain = self.model.actuator_gainprm
        bias = self.model.actuator_biasprm
        leading = self._dancers.leading_actuators
        tether = self._dancers.tether_actuators
        stiffness = gain[leading, 0]
        root_lead = -bias[tether, 2] / gain[tether, 0] if len(tether) else np.zeros((len(anatomies), 5))
        return Servos(
            stiffness=stiffness,
            lead=-bias[leading, 2] / stiffness,
            root_lead=root_lead,
            weight=self.model.body_subtreemass[self._dancers.pelvis] * GRAVITY_M_S2,
            leg=np.array([anatomy.thigh_m + anatomy.shank_m for anatomy in anatomies]),
        )

    def _place(self, headings_rad: tuple[float, float], postures: Array, pelvises: Array) -> None:
        """Put everybody in their initial pose, with targets that hold it."""
        dancers = self._dancers
        qpos = self.data.qpos
        ctrl = self.data.ctrl
        heading_rad, robot_heading_rad = headings_rad
        qpos[dancers.hinge_qpos] = self._body.angles(postures)
        qpos[dancers.root_qpos[:, :3]] = pelvises
        qpos[dancers.root_qpos[:, 3]] = heading_rad
        if self._robot is not None:
            quaternion = self._robot.root_qpos + 3
            half_rad = robot_heading_rad / 2
            qpos[quaternion : quaternion + 4] = [np.cos(half_rad), 0.0, 0.0, np.sin(half_rad)]

        ctrl[dancers.hinge_actuators] = qpos[dancers.hinge_qpos]
        if len(dancers.tether_actuators):
            ctrl[dancers.tether_actuators[:, :2]] = pelvises[:, :2]
            ctrl[dancers.tether_actuators[:, 2]] = heading_rad
        mujoco.mj_forward(self.model, self.data)

    def pose(self, joints: Array, roots: Array, robot: tuple[float, float, float] | None = None) -> None:
        """Put everybody in a posture without physics, for pictures of bodies that need not balance.

        Args:
            joints: (D, 25) angles of the planned hinges [rad].
            roots: (D, 6) pelvis x, y, z [m], yaw, pitch, roll [rad].
            robot: its position and heading [m, m, rad]; None leaves it where it is.
        """
        qpos = self.data.qpos
        qpos[self._dancers.hinge_qpos] = self._body.angles(joints)
        qpos[self._dancers.root_qpos] = roots
        if robot is not None and self._robot is not None:
            root = self._robot.root_qpos
            qpos[root : root + 2] = robot[:2]
            qpos[root + 3 : root + 7] = [np.cos(robot[2] / 2), 0.0, 0.0, np.sin(robot[2] / 2)]
        mujoco.mj_kinematics(self.model, self.data)
        self._joints_tick = -1

    def step_to(self, tick: int) -> None:
        """Advance the physics to a tick; nothing happens if it has been reached."""
        if tick > self.tick:
            mujoco.mj_step(self.model, self.data, tick - self.tick)
            self.tick = tick
            self.time_s = self.ticks.time_s(tick)

    def check(self) -> None:
        """Check that the simulation is still stable; a few times a second is often enough.

        Raises:
            SjasimError: the simulation became unstable.
        """
        if self._qacc_warning.number:
            raise SjasimError(f"the physics became unstable before {self.time_s:.2f} s")

    def states(self) -> DancerStates:
        """States of all dancers at this tick."""
        data = self.data
        rows = np.empty((len(self._load_n), DANCER_STATE_WIDTH))
        read_dancer_states(
            data.qpos,
            data.qvel,
            data.subtree_com,
            data.cvel,
            data.xipos,
            data.site_xpos,
            data.actuator_force,
            self._masses,
            self._parents,
            self._load_n,
            self._dancers.kernel,
            self._momentum,
            rows,
        )
        return DancerStates(rows)

    def measure_load(self) -> None:
        """Measure the vertical force of the floor on each dancer, for the states that are read from now on.

        Call it between the ticks of the balance controller, because at these the joint targets are a whole control step
        old. Only the soles touch the floor, so the constraint force on the root's vertical coordinate is the force on
        the feet, apart from contacts with other bodies.
        """
        self._load_n[:] = self.data.qfrc_constraint[self._lift_dof]

    def write_targets(self, targets: Array) -> None:
        """Set the dancers' actuators.

        Args:
            targets: (D, 30) angles of the planned hinges [rad], then targets of the balance support.
        """
        ctrl = self.data.ctrl
        ctrl[self._target_actuators] = targets.reshape(-1)[self._target_places]
        if not self._planned_hinges:
            ctrl[self._dancers.hinge_actuators] = self._body.angles(targets[:, : len(ACTUATED)])

    def drive(self, command: WheelCommand) -> None:
        """Set the robot's wheel speeds."""
        if self._robot is not None:
            self.data.ctrl[self._robot.left_motor] = command.left_rad_s
            self.data.ctrl[self._robot.right_motor] = command.right_rad_s

    def wheel_reading(self) -> WheelReading:
        """What the robot's own sensors measure, without noise.

        Raises:
            SjasimError: there is no robot.
        """
        robot = self._require_robot()
        return WheelReading(
            left_rad=self.data.qpos.item(robot.left_wheel_qpos),
            right_rad=self.data.qpos.item(robot.right_wheel_qpos),
            yaw_rate_rad_s=self.data.sensordata.item(robot.gyro_z),
        )

    def robot_pose(self) -> tuple[float, float, float]:
        """True position and heading (-pi to pi) of the robot [m, m, rad].

        Raises:
            SjasimError: there is no robot.
        """
        base = self._require_robot().base
        position = 3 * base
        rotation = 9 * base
        x = self.data.xpos.item(position)
        y = self.data.xpos.item(position + 1)
        return x, y, math.atan2(self.data.xmat.item(rotation + 3), self.data.xmat.item(rotation))

    def _require_robot(self) -> RobotIndices:
        if self._robot is None:
            raise SjasimError("there is no robot in this scene")
        return self._robot

    @property
    def joints_m(self) -> Array:
        """(D, 25, 3) true joint positions [m], read-only; a new array for each tick."""
        if self._joints_tick != self.tick:
            joints = self.data.site_xpos[self._dancers.joint_sites]
            joints.setflags(write=False)
            self._joints_m = joints
            self._joints_tick = self.tick
        return self._joints_m

    @property
    def yaw_rad(self) -> Array:
        """(D,) true headings of the pelvises [rad]."""
        return np.asarray(self.data.qpos[self._dancers.root_qpos[:, 3]])

    @property
    def geoms(self) -> Geoms:
        """Everything visible, at this tick; see `SceneView`."""
        rotation = self.data.geom_xmat[self._visible].reshape(-1, 3, 3)
        position_m = self.data.geom_xpos[self._visible]
        return Geoms(self._geom_type, self._geom_size, position_m, rotation, self._geom_owner)

    def height_m(self, dancer: int) -> float:
        """Height of a dancer's pelvis [m]."""
        return float(self.data.qpos.item(self._dancers.root_qpos.item(dancer, 2)))

    def make_limp(self, dancer: int) -> None:
        """Switch off a fallen dancer's actuators and balance support, and let the whole body collide with the floor."""
        model = self.model
        dancers = self._dancers
        limp = np.concatenate([dancers.hinge_actuators[dancer], *dancers.tether_actuators[dancer : dancer + 1]])
        model.actuator_gainprm[limp] = 0.0
        model.actuator_biasprm[limp, :2] = 0.0

        geoms = np.flatnonzero(dancers.geom_owner == dancer)
        model.geom_conaffinity[geoms] |= FLOOR_BIT
        model.body_conaffinity[model.geom_bodyid[geoms]] |= FLOOR_BIT

        rotations = dancers.root_dof[dancer, 3:]
        model.dof_armature[rotations] = LYING_ARMATURE
        model.dof_damping[rotations] = LYING_DAMPING

    def push(self, dancer: int, force: Array) -> None:
        """Apply a force (3,) to a dancer's trunk until another call [N]."""
        body = self.model.body(f"{dancer_prefix(dancer)}torso").id
        self.data.xfrc_applied[body, :3] = force
