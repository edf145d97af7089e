"""What truly happened, tick by tick: preallocated columns that a world fills and a log takes whole."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .assets.names import JOINT_INDEX
from .choreography.layout import Mount
from .config import SessionConfig
from .types import Array, DancerStates, IntArray, RobotState, Skeletons

TRUTH_COLUMNS = (
    "t_s", "dancer", "x_m", "y_m", "z_m", "heading_rad", "hands_m", "tether_x_n", "tether_y_n",
    "tether_torque_nm", "load_n", "weight_n", "spine_seen", "hands_seen", "fallen",
)  # fmt: skip
"""One row per (tick, dancer); ``spine_seen`` and ``hands_seen`` are the shares of SpineBase, SpineMid and shoulders,
and of hands and wrists, that the sensor the dancers face could see; NaN where it sees nothing at all."""

ODOMETRY_COLUMNS = (
    "t_s", "x_m", "y_m", "heading_rad", "step_m", "yaw_rate_rad_s", "true_x_m", "true_y_m", "true_heading_rad",
)  # fmt: skip

_TORSO = [JOINT_INDEX[name] for name in ("SpineBase", "SpineMid", "ShoulderLeft", "ShoulderRight")]
_HANDS = [JOINT_INDEX[name] for name in ("HandLeft", "HandRight", "WristLeft", "WristRight")]


@njit(cache=True)
def _keep(joints: Array, state: NDArray[np.int8], dancers: IntArray, out: NDArray[np.float32]) -> None:
    """Write persons' positions and states to the rows of the dancers behind them; -1 stands for nobody."""
    for p in range(len(dancers)):
        if dancers[p] >= 0:
            row = out[dancers[p]]
            for j in range(joints.shape[1]):
                for k in range(3):
                    row[j, k] = joints[p, j, k]
                row[j, 3] = state[p, j]


@njit(cache=True)
def _see(
    truth: Array, visible: NDArray[np.bool_], dancers: IntArray, joints: NDArray[np.float32], seen: NDArray[np.bool_]
) -> None:
    """Write true joints, and what could be seen of each dancer."""
    for d in range(joints.shape[0]):
        for j in range(joints.shape[1]):
            for k in range(3):
                joints[d, j, k] = truth[d, j, k]
    for p in range(len(dancers)):
        if dancers[p] >= 0:
            for j in range(seen.shape[1]):
                seen[dancers[p], j] = visible[p, j]


class Ledger:
    """Columns of truth and odometry, and the joints at frame rate.

    Args:
        weight_n: (D,) the dancers' weights [N].
        end_s: how long the session lasts.
        config: rates.
    """

    def __init__(self, weight_n: Array, end_s: float, config: SessionConfig) -> None:
        self._weight = weight_n
        dancers = len(self._weight)
        ticks = math.ceil(end_s * config.stage.balance_hz) + 2
        self._t_s = np.empty(ticks)
        self._states = np.empty((ticks, dancers, 36))
        self._fell_s = np.full(dancers, np.inf)
        self._every = max(1, config.stage.balance_hz // config.stage.truth_hz)
        self._odometry: list[tuple[float, ...]] = []
        frames = math.ceil(end_s * config.sensors.rate_hz) + 2
        self._joints = np.empty((frames, dancers, 25, 3), dtype=np.float32)
        self._mounts: dict[str, tuple[Mount, list[int]]] = {}
        self._skeletons = np.full((frames, dancers, 25, 4), np.nan, dtype=np.float32)
        self._visible = np.zeros((frames, dancers, 25), dtype=bool)
        self._watched = np.zeros(frames, dtype=bool)
        self._frame = np.empty(ticks, dtype=np.int64)
        self._rows = self._frames = 0

    def ride(self, state: RobotState, true_pose: tuple[float, float, float]) -> None:
        """One odometry sample with the true pose."""
        self._odometry.append((*state, *true_pose))

    def see(self, joints_m: Array, visible: NDArray[np.bool_] | None, dancers: IntArray | None) -> None:
        """One frame.

        Args:
            joints_m: (D, 25, 3) true joints [m].
            visible: (P, 25) what the sensor that is faced could see; None if it does not watch.
            dancers: (P,) the dancer behind each of its rows, -1 for nobody.
        """
        frame = self._frames
        if frame >= len(self._joints):
            return
        if visible is None or dancers is None:
            self._joints[frame] = joints_m
        else:
            _see(joints_m, visible, dancers, self._joints[frame], self._visible[frame])
            self._watched[frame] = True
        self._frames += 1

    def estimate(self, skeletons: Skeletons, dancers: IntArray, mount: Mount) -> None:
        """What the active client saw in the frame that `see` is about to take.

        Args:
            skeletons: in the sensor's frame.
            dancers: (P,) who they are of; -1 for nobody.
            mount: where the sensor is.
        """
        if self._frames < len(self._skeletons):
            _keep(skeletons.joints, skeletons.state, dancers, self._skeletons[self._frames])
            self._mounts.setdefault(mount.name, (mount, []))[1].append(self._frames)

    def write(self, now: float, states: DancerStates) -> None:
        """One tick of truth."""
        row = self._rows
        if row >= len(self._t_s):
            return
        self._t_s[row] = now
        self._states[row] = states.rows
        self._frame[row] = self._frames
        self._rows += 1

    def fall(self, now: float, dancer: int) -> None:
        """A dancer is down from now on."""
        self._fell_s[dancer] = now

    def _share_seen(self, joints: list[int], rows: slice) -> Array:
        """(N, D) share of some joints that were seen at each tick; NaN while nobody watched."""
        frame = np.maximum(self._frame[rows] - 1, 0)
        share = self._visible[:, :, joints].mean(axis=2)[frame]
        share[~self._watched[frame]] = np.nan
        return np.asarray(share)

    def truth(self) -> dict[str, NDArray[np.generic]]:
        """The truth as columns."""
        kept = slice(0, self._rows, self._every)
        t_s, states = self._t_s[kept, None], self._states[kept]
        shape = states.shape[:2]
        of = DancerStates(states.reshape(-1, states.shape[2]))
        tables: dict[str, NDArray[np.generic]] = {
            "t_s": np.broadcast_to(t_s, shape),
            "dancer": np.broadcast_to(np.arange(shape[1]), shape),
            **{name: of.root[:, k] for k, name in enumerate(("x_m", "y_m", "z_m", "heading_rad"))},
            "hands_m": np.sqrt(((of.hands[:, 0] - of.hands[:, 1]) ** 2).sum(axis=-1)),
            "tether_x_n": of.tether[:, 0],
            "tether_y_n": of.tether[:, 1],
            "tether_torque_nm": np.sqrt((of.tether[:, 2:] ** 2).sum(axis=-1)),
            "load_n": of.load,
            "weight_n": np.broadcast_to(self._weight, shape),
            "spine_seen": self._share_seen(_TORSO, kept),
            "hands_seen": self._share_seen(_HANDS, kept),
            "fallen": (t_s >= self._fell_s).astype(np.int64),
        }
        return {name: tables[name].reshape(-1).copy() for name in TRUTH_COLUMNS}

    def odometry(self) -> dict[str, Array]:
        """The odometry as columns; empty without a robot."""
        rows = np.array(self._odometry)
        return {name: rows[:, k].copy() for k, name in enumerate(ODOMETRY_COLUMNS)} if len(rows) else {}

    def joints(self) -> NDArray[np.float32]:
        """(F, D, 25, 3) true joints at frame rate [m]."""
        return self._joints[: self._frames]

    def skeletons(self) -> NDArray[np.float32]:
        """(F, D, 25, 4) world positions that the active client saw of them [m], and each joint's tracking state."""
        out = self._skeletons[: self._frames].copy()
        for mount, frames in self._mounts.values():
            local = out[frames, :, :, :3]
            out[frames, :, :, :3] = local @ mount.world_from_sensor.T + mount.position
        return out
