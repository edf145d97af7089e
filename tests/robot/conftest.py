"""The robot on a bare floor: its sensors are read and its wheels driven as in a session."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from sjasim.assets.names import FLOOR_BIT, ROBOT_PREFIX
from sjasim.config import PhysicsConfig, RobotConfig
from sjasim.core import Kind, Move, MoveCommand, RobotState, WheelReading
from sjasim.core.clock import Task, Ticks
from sjasim.robot.base_controller import BaseController
from sjasim.robot.diff_drive import wheel_command
from sjasim.robot.event_detector import RobotEventDetector
from sjasim.robot.mjcf import robot_spec
from sjasim.robot.odometry import Odometry

HEARTBEAT_S = 0.2
RATE_HZ = PhysicsConfig().rate_hz


def command(number: int, move: Move, *, speed: float | None = None, heading: float = 0.0) -> MoveCommand:
    cruise = 0.0 if move is Move.STOP else 0.25
    return MoveCommand(number, move, 0.0, cruise if speed is None else speed, heading, 1, 0, "test")


class Rig:
    """Steps physics at its usual rate and the robot's control at 50 Hz."""

    def __init__(self, config: RobotConfig | None = None, add_to_scene: Callable[[mujoco.MjSpec], None] | None = None):
        self.config = config or RobotConfig()
        self.model = _scene(self.config, add_to_scene).compile()
        self.data = mujoco.MjData(self.model)
        self.ticks = Ticks(RATE_HZ)
        self.tick = 0
        self.control = Task(self.ticks, self.config.odometry_hz)
        self.odometry = Odometry(self.config, (0.0, 0.0, 0.0), np.random.default_rng(0))
        self.detector = RobotEventDetector(self.config)
        self.controller = BaseController(self.config)

        self.events: list[tuple[Kind, float]] = []
        self.states: list[RobotState] = []
        self.truth: list[tuple[float, float, float]] = []
        self.drive: tuple[float, float] | None = None
        self.heartbeats = True
        self._sent: MoveCommand | None = None
        self._sent_s = 0.0
        self._heading_rad = 0.0
        self._wrapped_rad = 0.0

        root = self.model.joint(ROBOT_PREFIX + "root")
        self._q = int(root.qposadr[0])
        self._v = int(root.dofadr[0])
        wheels = [ROBOT_PREFIX + name for name in ("wheel_l", "wheel_r")]
        self._wheels = [int(self.model.joint(name).qposadr[0]) for name in wheels]
        self._motors = [self.model.actuator(name).id for name in wheels]
        self._gyro = int(self.model.sensor(ROBOT_PREFIX + "gyro").adr[0]) + 2

        mujoco.mj_forward(self.model, self.data)
        self.run(0.3)

    @property
    def t_s(self) -> float:
        return self.ticks.time_s(self.tick)

    @property
    def state(self) -> RobotState:
        return self.states[-1]

    def true_pose(self) -> tuple[float, float, float]:
        """x, y and unwrapped heading."""
        q = self.data.qpos[self._q : self._q + 7]
        raw = math.atan2(2 * (q[3] * q[6] + q[4] * q[5]), 1 - 2 * (q[5] ** 2 + q[6] ** 2))
        self._heading_rad += (raw - self._wrapped_rad + math.pi) % (2 * math.pi) - math.pi
        self._wrapped_rad = raw
        return float(q[0]), float(q[1]), self._heading_rad

    def true_velocity(self) -> tuple[float, float]:
        v = self.data.qvel[self._v : self._v + 6]
        return float(v[0] * math.cos(self._wrapped_rad) + v[1] * math.sin(self._wrapped_rad)), float(v[5])

    def wheel_angles(self) -> tuple[float, float]:
        return float(self.data.qpos[self._wheels[0]]), float(self.data.qpos[self._wheels[1]])

    def send(self, order: MoveCommand) -> float:
        """Deliver a command now and repeat it from now on; returns the time."""
        self._sent = order
        self._sent_s = self.t_s
        self.controller.receive(self.t_s, order)
        return self.t_s

    def run(self, seconds: float) -> None:
        until = self.ticks.at_or_after(self.t_s + seconds)
        while self.tick < until:
            if self.tick == self.control.due:
                self.control.advance()
                self._control()
            mujoco.mj_step(self.model, self.data)
            self.tick += 1

    def _control(self) -> None:
        t = self.t_s
        if self._sent is not None and self.heartbeats and t - self._sent_s >= HEARTBEAT_S:
            self._sent_s = t
            self.controller.receive(t, self._sent)

        left, right = self.wheel_angles()
        state = self.odometry.update(t, WheelReading(left, right, float(self.data.sensordata[self._gyro])))
        event = self.detector.update(state)
        if event is not None:
            self.events.append(event)
        self.states.append(state)
        self.truth.append(self.true_pose())

        wheels = self.controller.update(state)
        if self.drive is not None:
            wheels = wheel_command(*self.drive, self.config)
        self.data.ctrl[self._motors] = wheels.left_rad_s, wheels.right_rad_s


def _scene(config: RobotConfig, add_to_scene: Callable[[mujoco.MjSpec], None] | None) -> mujoco.MjSpec:
    scene = mujoco.MjSpec()
    scene.option.timestep = 1 / RATE_HZ
    scene.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    scene.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    scene.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    scene.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[9, 9, 0.1], contype=FLOOR_BIT, conaffinity=0
    )
    if add_to_scene is not None:
        add_to_scene(scene)
    scene.attach(robot_spec(config), prefix=ROBOT_PREFIX, frame=scene.worldbody.add_frame())
    return scene


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def make_rig() -> type[Rig]:
    return Rig


@pytest.fixture
def order() -> Callable[..., MoveCommand]:
    return command
