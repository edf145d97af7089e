"""Control steps of the dancers and of the robot, 50 times a second."""

from __future__ import annotations

import numpy as np

from ..config import RobotConfig
from ..core import Kind, MoveCommand, RobotState, WheelCommand
from ..humans.motion.balance_controller import BalanceController
from ..robot.base_controller import BaseController, update_drive
from ..robot.diff_drive import Pose
from ..robot.event_detector import RobotEventDetector, detect_event
from ..robot.odometry import STATE_WIDTH, Odometry, update_estimate
from .ground_truth_recorder import GroundTruthRecorder
from .physics import Physics

STOPPED = WheelCommand(0.0, 0.0)


class DancerController:
    """Reads the dancers' states, logs them, runs the balance controller and writes the actuator targets.

    Args:
        physics: physics with the dancers.
        balance: their balance controller.
        recorder: ground truth of the session.
    """

    def __init__(self, physics: Physics, balance: BalanceController, recorder: GroundTruthRecorder) -> None:
        self._physics = physics
        self._balance = balance
        self._recorder = recorder

    def step(self, tick: int, now: float) -> None:
        """Take one control step.

        Args:
            tick: number of the step, the row of the plan.
            now: session time [s].
        """
        states = self._physics.states().rows
        row = self._recorder.next_state_row(now)
        if row >= 0:
            self._recorder.states[row] = states
        self._balance.update(tick, states)
        self._physics.write_targets(self._balance.targets)


class RobotController:
    """Reads the robot's sensors, updates odometry and events, logs them, and writes the wheel speeds.

    Args:
        physics: physics with the robot.
        config: parameters of the robot.
        pose: where odometry starts.
        rng: noise of the gyro.
        recorder: ground truth of the session.
    """

    def __init__(
        self, physics: Physics, config: RobotConfig, pose: Pose, rng: np.random.Generator, recorder: GroundTruthRecorder
    ) -> None:
        self._physics = physics
        self._recorder = recorder
        self._odometry = Odometry(config, pose, rng)
        self._detector = RobotEventDetector(config)
        self._base = BaseController(config)

    @property
    def state(self) -> RobotState:
        """Odometry estimate of the last step."""
        return self._odometry.state

    @property
    def blocked(self) -> bool:
        """Whether the wheels stand still though the robot commands a motion; see `BaseController.blocked`."""
        return self._base.blocked

    def receive(self, t_s: float, command: MoveCommand) -> None:
        """Accept a command; see `BaseController.receive`."""
        self._base.receive(t_s, command)

    def step(self, t_s: float, *, wheels_blocked: bool) -> tuple[Kind, float] | None:
        """Take one control step.

        Args:
            t_s: session time.
            wheels_blocked: whether a fault keeps the wheels from turning.

        Returns:
            the event that odometry shows, with its time [s], or None.
        """
        self._base.start_pending(t_s)
        estimate = self._odometry.estimate
        left_rad, right_rad, yaw_rate_rad_s = self._physics.wheel_reading()
        noise_rad_s = self._odometry.noise_rad_s()
        update_estimate(t_s, left_rad, right_rad, yaw_rate_rad_s, noise_rad_s, self._odometry.calibration, estimate)
        event = detect_event(estimate, self._detector.memory)
        update_drive(estimate, self._base.limits, self._base.drive)

        self._physics.drive(STOPPED if wheels_blocked else self._base.wheels)

        row = self._recorder.next_odometry_row()
        self._recorder.odometry_rows[row, :STATE_WIDTH] = estimate[:STATE_WIDTH]
        self._recorder.odometry_rows[row, STATE_WIDTH:] = self._physics.robot_pose()
        return self._detector.event(event) if event else None
