"""What truly happened, tick by tick: kept while a session goes on, made into columns when it is over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..choreography.layout import Mount
from ..core import Array, BoolArray, DancerStates, IntArray, Skeletons
from ..core.bodies import DANCER_STATE_WIDTH

K = TypeVar("K", bound=np.generic)

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


class GroundTruthRecorder:
    """What truly happened: states and odometry, and the joints at frame rate.

    While the session goes on everything is only kept, as it comes, in lists side by side: a tuple for each tick would
    keep Python's collector of cycles busy. The columns are made when somebody asks.

    Args:
        weight_n: (D,) the dancers' weights [N].
        every: which of the ticks become rows of the truth.
        rows: how many of them to make room for; more are taken.

    Attributes:
        states: (N, D, 36) rows of `types.DancerStates`, one for each tick that is kept; whoever tells the recorder of a
            tick writes its own. Their memory is touched when it is made, not while people dance.
        odometry_rows: (M, 9) the same for the odometry, with `ODOMETRY_COLUMNS`.
    """

    def __init__(self, weight_n: Array, every: int, rows: int = 1) -> None:
        self._weight = weight_n
        self._every = every
        self._fell_s = np.full(len(weight_n), np.inf)
        self.states = np.full((rows, len(weight_n), DANCER_STATE_WIDTH), 0.0)
        self._t_s: list[float] = []
        self._frame_of: list[int] = []
        self._until_next = 0
        self.odometry_rows = np.full((rows, len(ODOMETRY_COLUMNS)), 0.0)
        self._odometry_count = 0
        self._joints: list[Array] = []
        self._seen: list[BoolArray | None] = []
        self._seen_dancers: list[IntArray] = []
        self._estimated: list[int] = []
        self._estimates: list[Array] = []
        self._states: list[NDArray[np.int8]] = []
        self._estimated_dancers: list[IntArray] = []
        self._mounts: list[Mount] = []

    def next_odometry_row(self) -> int:
        """One odometry sample: its row of `odometry_rows`."""
        self._odometry_count += 1
        if self._odometry_count > len(self.odometry_rows):
            self.odometry_rows = _doubled(self.odometry_rows)
        return self._odometry_count - 1

    def add_frame(self, joints_m: Array, visible: BoolArray | None, dancers: IntArray) -> None:
        """One frame; the recorder keeps the arrays themselves.

        Args:
            joints_m: (D, 25, 3) true joints [m].
            visible: (P, 25) what the active sensor could see; None if it does not watch.
            dancers: (P,) the dancer behind each of its rows, -1 for nobody.
        """
        self._joints.append(joints_m)
        self._seen.append(visible)
        self._seen_dancers.append(dancers)

    def add_skeletons(self, skeletons: Skeletons, dancers: IntArray, mount: Mount) -> None:
        """What the active client saw in the frame that `add_frame` is about to take; the recorder keeps the arrays themselves.

        Args:
            skeletons: in the sensor's frame.
            dancers: (P,) who they are of; -1 for nobody.
            mount: where the sensor is.
        """
        self._estimated.append(len(self._joints))
        self._estimates.append(skeletons.joints)
        self._states.append(skeletons.state)
        self._estimated_dancers.append(dancers)
        self._mounts.append(mount)

    def next_state_row(self, now: float) -> int:
        """One control tick: the row of `states` that what is felt at it belongs in, -1 for one that is not kept."""
        if self._until_next:
            self._until_next -= 1
            return -1
        self._until_next = self._every - 1
        row = len(self._t_s)
        if row == len(self.states):
            self.states = _doubled(self.states)
        self._t_s.append(now)
        self._frame_of.append(len(self._joints))
        return row

    def mark_fallen(self, now: float, dancer: int) -> None:
        """A dancer is down from now on."""
        self._fell_s[dancer] = now

    def truth(self) -> dict[str, NDArray[np.generic]]:
        """The truth as columns."""
        t_s, frame = np.array(self._t_s)[:, None], np.maximum(np.array(self._frame_of, dtype=np.int64) - 1, 0)
        states = self.states[: len(t_s)]
        shape = states.shape[:2]
        of = DancerStates(states.reshape(-1, states.shape[2]))
        visible = self._visible()
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
            "spine_seen": visible[:, :, _TORSO].mean(axis=2)[frame],
            "hands_seen": visible[:, :, _HANDS].mean(axis=2)[frame],
            "fallen": (t_s >= self._fell_s).astype(np.int64),
        }
        return {name: tables[name].reshape(-1).copy() for name in TRUTH_COLUMNS}

    def odometry(self) -> dict[str, Array]:
        """The odometry as columns; empty without a robot."""
        rows = self.odometry_rows[: self._odometry_count]
        return {name: rows[:, k].copy() for k, name in enumerate(ODOMETRY_COLUMNS)} if len(rows) else {}

    def joints(self) -> NDArray[np.float32]:
        """(F, D, 25, 3) true joints at frame rate [m]."""
        shape = (len(self._joints), len(self._weight), len(JOINTS), 3)
        return np.array(self._joints, dtype=np.float32).reshape(shape)

    def skeletons(self) -> NDArray[np.float32]:
        """(F, D, 25, 4) world positions that the active client saw of them [m], and each joint's tracking state."""
        out = np.full((len(self._joints), len(self._weight), len(JOINTS), 4), np.nan, dtype=np.float32)
        for part in _alike(self._estimated_dancers):
            dancers, mount = self._estimated_dancers[part[0]], self._mounts[part[0]]
            frames = np.array([self._estimated[k] for k in part])
            local, state = _stacked([self._estimates[k] for k in part]), _stacked([self._states[k] for k in part])
            x, y, z = local[..., 0], local[..., 1], local[..., 2]
            rows = np.flatnonzero(dancers >= 0)
            for k, (right, up, ahead) in enumerate(mount.world_from_sensor):  # matmul takes four times as long
                along = x * right + y * up + z * ahead + mount.position[k]
                for row in rows:
                    out[frames, dancers[row], :, k] = along[:, row]
            for row in rows:
                out[frames, dancers[row], :, 3] = state[:, row]
        return out

    def _visible(self) -> Array:
        """(F, D, 25) 1 for what could be seen in each frame, 0 for what could not; NaN where nobody watched."""
        out = np.full((max(len(self._joints), 1), len(self._weight), len(JOINTS)), np.nan)
        for part in _alike(self._seen_dancers):
            dancers = self._seen_dancers[part[0]]
            watched = [(k, visible) for k in part if (visible := self._seen[k]) is not None]
            if not watched:
                continue
            frames, visible = np.array([k for k, _ in watched]), _stacked([visible for _, visible in watched])
            out[frames] = 0.0
            for row in np.flatnonzero(dancers >= 0):
                out[frames, dancers[row]] = visible[:, row]
        return out


def _doubled(rows: Array) -> Array:
    """The rows, and room for as many more."""
    return np.concatenate([rows, np.zeros_like(rows)])


def _stacked(arrays: Sequence[NDArray[K]]) -> NDArray[K]:
    """Arrays of one shape as one, with a leading axis; in a third of numpy's own time."""
    return np.concatenate(arrays).reshape(len(arrays), *arrays[0].shape)


def _alike(keys: Sequence[object]) -> list[list[int]]:
    """Places of the very same key, in order, key by key."""
    groups: dict[int, list[int]] = {}
    for place, key in enumerate(keys):
        groups.setdefault(id(key), []).append(place)
    return list(groups.values())
