"""Ground truth of a session: recorded while the session runs, converted to table columns afterwards."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..choreography.layout import Mount
from ..core import Array, BoolArray, DancerStates, IntArray, Skeletons
from ..core.bodies import DANCER_STATE_WIDTH

Scalar = TypeVar("Scalar", bound=np.generic)

TRUTH_COLUMNS = (
    "t_s",
    "dancer",
    "x_m",
    "y_m",
    "z_m",
    "heading_rad",
    "hands_m",
    "tether_x_n",
    "tether_y_n",
    "tether_torque_nm",
    "load_n",
    "weight_n",
    "spine_seen",
    "hands_seen",
    "fallen",
)
"""Columns of the ground truth, which has one row for each recorded tick and dancer.

``spine_seen`` and ``hands_seen`` are the shares of the joints of the torso, and of hands and wrists, that are visible
to the active sensor; NaN while that sensor does not detect anything.
"""

ODOMETRY_COLUMNS = (
    "t_s",
    "x_m",
    "y_m",
    "heading_rad",
    "step_m",
    "yaw_rate_rad_s",
    "true_x_m",
    "true_y_m",
    "true_heading_rad",
)
"""Columns of the odometry, which has one row for each control step of the robot."""

TORSO_JOINTS = [JOINT_INDEX[name] for name in ("SpineBase", "SpineMid", "ShoulderLeft", "ShoulderRight")]
"""Joints that ``spine_seen`` is about."""

HAND_JOINTS = [JOINT_INDEX[name] for name in ("HandLeft", "HandRight", "WristLeft", "WristRight")]
"""Joints that ``hands_seen`` is about."""


class GroundTruthRecorder:
    """Records the dancers' states, their joints and visibility, the odometry, and the active sensor's skeletons.

    Recording only appends to lists and writes to arrays that were allocated before; the tables are computed on request.
    The lists stand side by side, since one object for each frame would make Python's garbage collector run more often.

    Args:
        weight_n: (D,) weights of the dancers [N].
        every: interval between two recorded states, in control steps.
        rows: expected number of recorded states. The arrays grow if there are more.

    Attributes:
        states: (N, D, `DANCER_STATE_WIDTH`) recorded states, see `core.bodies.StateColumn`; the caller writes the row
            that `next_state_row` returns.
        odometry_rows: (M, 9) odometry, see `ODOMETRY_COLUMNS`; the caller writes the row that `next_odometry_row`
            returns.
    """

    def __init__(self, weight_n: Array, every: int, rows: int = 1) -> None:
        self._weight_n = weight_n
        self._every = every
        self._fallen_from_s = np.full(len(weight_n), np.inf)

        # np.full touches the memory now; np.zeros would leave that to the first writes, in the control loop.
        self.states = np.full((rows, len(weight_n), DANCER_STATE_WIDTH), 0.0)
        self._state_t_s: list[float] = []
        self._state_frames: list[int] = []
        self._steps_to_skip = 0

        self.odometry_rows = np.full((rows, len(ODOMETRY_COLUMNS)), 0.0)
        self._odometry_count = 0

        self._joints_m: list[Array] = []
        self._visible: list[BoolArray | None] = []
        self._visible_dancers: list[IntArray] = []

        self._estimated_frames: list[int] = []
        self._estimated_joints_m: list[Array] = []
        self._tracking_states: list[NDArray[np.int8]] = []
        self._estimated_dancers: list[IntArray] = []
        self._mounts: list[Mount] = []

    def next_state_row(self, now: float) -> int:
        """Count a control step of the dancers.

        Args:
            now: session time [s].

        Returns:
            the row of `states` for this step, or -1 for a step that is not recorded.
        """
        if self._steps_to_skip:
            self._steps_to_skip -= 1
            return -1
        self._steps_to_skip = self._every - 1

        row = len(self._state_t_s)
        if row == len(self.states):
            self.states = _with_doubled_length(self.states)
        self._state_t_s.append(now)
        self._state_frames.append(len(self._joints_m))
        return row

    def next_odometry_row(self) -> int:
        """Count a control step of the robot; returns its row of `odometry_rows`."""
        self._odometry_count += 1
        if self._odometry_count > len(self.odometry_rows):
            self.odometry_rows = _with_doubled_length(self.odometry_rows)
        return self._odometry_count - 1

    def add_frame(self, joints_m: Array, visible: BoolArray | None, dancers: IntArray) -> None:
        """Record the joints of a frame. The arrays are not copied.

        Args:
            joints_m: (D, 25, 3) true joints [m].
            visible: (P, 25) joints that are visible to the active sensor; None while it does not detect anything.
            dancers: (P,) dancer of each row of ``visible``; -1 for a row of nobody. The recorder groups frames by the
                identity of this array, so pass the same array as long as it does not change.
        """
        self._joints_m.append(joints_m)
        self._visible.append(visible)
        self._visible_dancers.append(dancers)

    def add_skeletons(self, skeletons: Skeletons, dancers: IntArray, mount: Mount) -> None:
        """Record the active sensor's skeletons of the frame that `add_frame` records next. The arrays are not copied.

        Args:
            skeletons: skeletons in the sensor's frame.
            dancers: (P,) dancer of each skeleton; -1 for nobody. Frames are grouped by its identity, as in `add_frame`.
            mount: pose of the sensor.
        """
        self._estimated_frames.append(len(self._joints_m))
        self._estimated_joints_m.append(skeletons.joints)
        self._tracking_states.append(skeletons.state)
        self._estimated_dancers.append(dancers)
        self._mounts.append(mount)

    def mark_fallen(self, now: float, dancer: int) -> None:
        """Record that a dancer has fallen, from a session time on [s]."""
        self._fallen_from_s[dancer] = now

    def truth(self) -> dict[str, NDArray[np.generic]]:
        """Ground truth of the dancers; see `TRUTH_COLUMNS`."""
        t_s = np.array(self._state_t_s)[:, None]
        rows = self.states[: len(t_s)]
        shape = rows.shape[:2]
        states = DancerStates(rows.reshape(-1, rows.shape[2]))

        # A state belongs to the last frame before it; the states before the first frame belong to that one.
        frame = np.maximum(np.array(self._state_frames, dtype=np.int64) - 1, 0)
        visible = self._visibility()

        columns: dict[str, NDArray[np.generic]] = {
            "t_s": np.broadcast_to(t_s, shape),
            "dancer": np.broadcast_to(np.arange(shape[1]), shape),
            **{name: states.root[:, k] for k, name in enumerate(("x_m", "y_m", "z_m", "heading_rad"))},
            "hands_m": np.sqrt(((states.hands[:, 0] - states.hands[:, 1]) ** 2).sum(axis=-1)),
            "tether_x_n": states.tether[:, 0],
            "tether_y_n": states.tether[:, 1],
            "tether_torque_nm": np.sqrt((states.tether[:, 2:] ** 2).sum(axis=-1)),
            "load_n": states.load,
            "weight_n": np.broadcast_to(self._weight_n, shape),
            "spine_seen": visible[:, :, TORSO_JOINTS].mean(axis=2)[frame],
            "hands_seen": visible[:, :, HAND_JOINTS].mean(axis=2)[frame],
            "fallen": (t_s >= self._fallen_from_s).astype(np.int64),
        }
        return {name: columns[name].reshape(-1).copy() for name in TRUTH_COLUMNS}

    def odometry(self) -> dict[str, Array]:
        """Odometry of the robot, see `ODOMETRY_COLUMNS`; an empty dictionary without a robot."""
        rows = self.odometry_rows[: self._odometry_count]
        return {name: rows[:, k].copy() for k, name in enumerate(ODOMETRY_COLUMNS)} if len(rows) else {}

    def joints(self) -> NDArray[np.float32]:
        """(F, D, 25, 3) true joints of every frame [m]."""
        shape = (len(self._joints_m), len(self._weight_n), len(JOINTS), 3)
        return np.array(self._joints_m, dtype=np.float32).reshape(shape)

    def skeletons(self) -> NDArray[np.float32]:
        """The active sensor's skeletons of every frame.

        Returns:
            (F, D, 25, 4) joints in the world [m] and their tracking states; NaN where there is no skeleton.
        """
        out = np.full((len(self._joints_m), len(self._weight_n), len(JOINTS), 4), np.nan, dtype=np.float32)
        for group in _groups_by_identity(self._estimated_dancers):
            dancers = self._estimated_dancers[group[0]]
            mount = self._mounts[group[0]]
            rows = np.flatnonzero(dancers >= 0)
            frames = np.array([self._estimated_frames[k] for k in group])
            local_m = _stack([self._estimated_joints_m[k] for k in group])
            state = _stack([self._tracking_states[k] for k in group])

            # Matrix multiplication of such small matrices takes four times as long as the sums of products.
            x_m = local_m[..., 0]
            y_m = local_m[..., 1]
            z_m = local_m[..., 2]
            for axis, (right, up, ahead) in enumerate(mount.world_from_sensor):
                world_m = x_m * right + y_m * up + z_m * ahead + mount.position[axis]
                for row in rows:
                    out[frames, dancers[row], :, axis] = world_m[:, row]
            for row in rows:
                out[frames, dancers[row], :, 3] = state[:, row]
        return out

    def _visibility(self) -> Array:
        """(F, D, 25) 1 for a visible joint and 0 for another in each frame; NaN where the sensor detected nothing."""
        out = np.full((max(len(self._joints_m), 1), len(self._weight_n), len(JOINTS)), np.nan)
        for group in _groups_by_identity(self._visible_dancers):
            dancers = self._visible_dancers[group[0]]
            detecting = [(k, visible) for k in group if (visible := self._visible[k]) is not None]
            if not detecting:
                continue

            frames = np.array([k for k, _ in detecting])
            stacked = _stack([visible for _, visible in detecting])
            out[frames] = 0.0
            for row in np.flatnonzero(dancers >= 0):
                out[frames, dancers[row]] = stacked[:, row]
        return out


def _with_doubled_length(rows: Array) -> Array:
    """A copy of an array, followed by as many rows of zeros."""
    return np.concatenate([rows, np.zeros_like(rows)])


def _stack(arrays: Sequence[NDArray[Scalar]]) -> NDArray[Scalar]:
    """Stack arrays of one shape along a new first axis, in a third of the time of `numpy.stack`."""
    return np.concatenate(arrays).reshape(len(arrays), *arrays[0].shape)


def _groups_by_identity(items: Sequence[object]) -> list[list[int]]:
    """Indices of identical objects, in order; one list for each object."""
    groups: dict[int, list[int]] = {}
    for index, item in enumerate(items):
        groups.setdefault(id(item), []).append(index)
    return list(groups.values())
