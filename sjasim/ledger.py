"""What truly happened, tick by tick: preallocated columns that a world fills and a log takes whole."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .config import SessionConfig
from .stage import Stage
from .types import Array, RobotState

TRUTH_COLUMNS = (
    "t_s", "dancer", "x_m", "y_m", "z_m", "heading_rad", "hands_m", "tether_x_n", "tether_y_n",
    "tether_torque_nm", "load_n", "weight_n", "spine_seen", "hands_seen", "fallen",
)  # fmt: skip
"""One row per (tick, dancer); ``spine_seen`` and ``hands_seen`` are the shares of SpineBase, SpineMid and shoulders,
and of hands and wrists, that the sensor the dancers face could see; NaN where it sees nothing at all."""

ODOMETRY_COLUMNS = (
    "t_s", "x_m", "y_m", "heading_rad", "step_m", "yaw_rate_rad_s", "true_x_m", "true_y_m", "true_heading_rad",
)  # fmt: skip


class Ledger:
    """Columns of truth and odometry, and the joints at frame rate.

    Args:
        stage: for sizes and weights.
        end_s: how long the session lasts.
        config: rates.
    """

    def __init__(self, stage: Stage, end_s: float, config: SessionConfig) -> None:
        dancers = len(stage.servos.weight)
        self._truth = np.full((math.ceil(end_s * config.stage.balance_hz) + 2, dancers, len(TRUTH_COLUMNS)), np.nan)
        self._truth[:, :, 1] = np.arange(dancers)
        self._truth[:, :, 11] = stage.servos.weight
        self._every = max(1, config.stage.balance_hz // config.stage.truth_hz)
        self._odometry = np.empty((math.ceil(end_s * config.robot.odometry_hz) + 2, len(ODOMETRY_COLUMNS)))
        self._joints = np.empty((math.ceil(end_s * config.sensors.rate_hz) + 2, dancers, 25, 3), dtype=np.float32)
        self._load = np.zeros(dancers)
        self._rows = self._rides = self._frames = 0

    def feel(self, stage: Stage) -> None:
        """Remember the floor's force; taken at the robot's ticks, which are out of step with the controller's."""
        self._load = stage.loads()

    def ride(self, state: RobotState, true_pose: tuple[float, float, float]) -> None:
        """One odometry sample with the true pose."""
        if self._rides < len(self._odometry):
            row = (state.t_s, state.x_m, state.y_m, state.heading_rad, state.step_m, state.yaw_rate_rad_s)
            self._odometry[self._rides] = (*row, *true_pose)
            self._rides += 1

    def see(self, joints_m: Array) -> None:
        """One frame of true joints."""
        if self._frames < len(self._joints):
            self._joints[self._frames] = joints_m
            self._frames += 1

    def write(self, now: float, roots: Array, stage: Stage, seen: Array, fallen: NDArray[np.bool_]) -> None:
        """One tick of truth; ``seen`` is (D, 2): spine and hands."""
        if self._rows >= len(self._truth):
            return
        row = self._truth[self._rows]
        row[:, 0] = now
        row[:, 2:6] = roots[:, :4]
        row[:, 6] = stage.hand_gaps()
        tether = stage.tether()
        row[:, 7:9] = tether[:, :2]
        row[:, 9] = np.sqrt((tether[:, 2:] ** 2).sum(axis=1))
        row[:, 10] = self._load
        row[:, 12:14] = seen
        row[:, 14] = fallen
        self._rows += 1

    def truth(self) -> dict[str, NDArray[np.generic]]:
        """The truth as columns."""
        rows = self._truth[: self._rows : self._every].reshape(-1, len(TRUTH_COLUMNS))
        columns: dict[str, NDArray[np.generic]] = {name: rows[:, k].copy() for k, name in enumerate(TRUTH_COLUMNS)}
        columns["dancer"] = rows[:, 1].astype(np.int64)
        columns["fallen"] = rows[:, 14].astype(np.int64)
        return columns

    def odometry(self) -> dict[str, Array]:
        """The odometry as columns; empty without a robot."""
        rows = self._odometry[: self._rides]
        return {name: rows[:, k].copy() for k, name in enumerate(ODOMETRY_COLUMNS)} if len(rows) else {}

    def joints(self) -> NDArray[np.float32]:
        """(F, D, 25, 3) true joints at frame rate [m]."""
        return self._joints[: self._frames]
