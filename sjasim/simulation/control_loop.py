"""What happens 50 times a second, in one compiled call each: a turn of all dancers and a turn of the robot.

Between two turns the physics runs through the processor's caches and leaves them cold; so what a turn costs is the
memory that it touches, and a dozen Python objects on the way cost more than its arithmetic.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ..config import RobotConfig
from ..core import Array, IntArray, Kind, MoveCommand, RobotState
from ..core.memory import Memory, cube, index_rows, indices, matrix, vector
from ..humans.motion.balance_controller import HINGES, BalanceController, correct
from ..robot.base_controller import LEFT_WHEEL, RIGHT_WHEEL, BaseController, steer
from ..robot.diff_drive import Pose
from ..robot.odometry import RATE, Odometry, RobotEventDetector, detect, reckon
from .physics import Physics
from .recorder import GroundTruthRecorder
from .state_access import BASE, GYRO, LEFT_ANGLE, LEFT_MOTOR, RIGHT_ANGLE, RIGHT_MOTOR, command, gather


@njit(cache=True)
def _balance(tick: int, row: int, rate: float, truth: Array, at: IntArray) -> None:
    """Feel, keep, correct, command; ``at`` lists the arrays of `DancerController`."""
    felt, where, targets = matrix(at, 0), index_rows(at, 12), matrix(at, 18)
    gather(
        matrix(at, 1), matrix(at, 2), matrix(at, 3), vector(at, 4), vector(at, 5), matrix(at, 6), vector(at, 7),
        vector(at, 8), vector(at, 9), indices(at, 10), matrix(at, 11), where, felt,
    )  # fmt: skip
    if row >= 0:
        for d in range(felt.shape[0]):
            for k in range(felt.shape[1]):
                truth[row, d, k] = felt[d, k]
    correct(
        tick, rate, indices(at, 13), cube(at, 14), felt, matrix(at, 15), vector(at, 16), cube(at, 17), targets,
    )  # fmt: skip
    command(targets, where, vector(at, 19))


class DancerController:
    """The dancers' turn: what they feel goes into the recorder, and the targets that follow from it to their actuators.

    Args:
        stage: with the dancers.
        balance: their controller.
        recorder: of the session.
    """

    def __init__(self, physics: Physics, balance: BalanceController, recorder: GroundTruthRecorder) -> None:
        self._physics, self._recorder, self._targets = physics, recorder, balance.targets
        self._rate = balance.rate_hz
        self._arrays = Memory(physics.states().rows, *physics.felt, *balance.plan, *balance.memory, physics.ctrl)

    def take(self, tick: int, now: float) -> None:
        """Take the turn of a control tick, at session time ``now``."""
        recorder = self._recorder
        row = recorder.tick(now)
        _balance(tick, row, self._rate, recorder.states, self._arrays.table)
        if not self._physics.direct:
            self._physics.bend(self._targets[:, :HINGES])


@njit(cache=True)
def _ride(t_s: float, noise: float, jammed: bool, row: int, rides: Array, at: IntArray) -> int:
    """Odometry, events, wheel command and the record of them; ``at`` lists the arrays of `RobotController`."""
    qpos, sensed, place, attitude, where = vector(at, 0), vector(at, 1), matrix(at, 2), matrix(at, 3), indices(at, 4)
    ctrl, belief, work = vector(at, 5), vector(at, 7), vector(at, 10)
    reckon(t_s, qpos[where[LEFT_ANGLE]], qpos[where[RIGHT_ANGLE]], sensed[where[GYRO]], noise, vector(at, 6), belief)
    event = int(detect(belief, vector(at, 8)))
    steer(belief, vector(at, 9), work)
    ctrl[where[LEFT_MOTOR]] = 0.0 if jammed else work[LEFT_WHEEL]
    ctrl[where[RIGHT_MOTOR]] = 0.0 if jammed else work[RIGHT_WHEEL]
    body = where[BASE]
    for k in range(RATE + 1):
        rides[row, k] = belief[k]
    rides[row, RATE + 1], rides[row, RATE + 2] = place[body, 0], place[body, 1]
    rides[row, RATE + 3] = math.atan2(attitude[body, 3], attitude[body, 0])
    return event


class RobotController:
    """The robot's turn: what it senses goes into odometry and the recorder, and what it makes of it to its wheels.

    Args:
        stage: with the robot.
        config: of the robot.
        pose: where it believes to start.
        rng: noise of its gyro.
        recorder: of the session.
    """

    def __init__(
        self, physics: Physics, config: RobotConfig, pose: Pose, rng: np.random.Generator, recorder: GroundTruthRecorder
    ) -> None:
        self._odometry = odometry = Odometry(config, pose, rng)
        self._detector = detector = RobotEventDetector(config)
        self._executor = executor = BaseController(config)
        self._recorder = recorder
        self._arrays = Memory(
            *physics.robot, physics.ctrl, odometry.base, odometry.belief, detector.seen, executor.limits, executor.work,
        )  # fmt: skip

    @property
    def state(self) -> RobotState:
        """Where it believed to be at its last turn."""
        return self._odometry.state

    @property
    def blocked(self) -> bool:
        """See `BaseController.blocked`."""
        return self._executor.blocked

    def receive(self, t_s: float, command: MoveCommand) -> None:
        """See `BaseController.receive`."""
        self._executor.receive(t_s, command)

    def take(self, t_s: float, *, jammed: bool) -> tuple[Kind, float] | None:
        """Take the turn of session time ``t_s``.

        Args:
            t_s: the present.
            jammed: whether the wheels stand still, whatever it wants.

        Returns:
            an event that its odometry shows by now, and when it was [s].
        """
        self._executor.take_up(t_s)
        recorder = self._recorder
        row = recorder.ride()
        event = _ride(t_s, self._odometry.noise_rad_s(), jammed, row, recorder.rides, self._arrays.table)
        return self._detector.event(event) if event else None
