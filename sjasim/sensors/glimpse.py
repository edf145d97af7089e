"""What the detectors look at: a few numbers per person from each frame.

One compiled call takes everybody's figures out of a frame.
"""

from __future__ import annotations

from collections import deque
from math import atan2, hypot, isnan, nan, tau
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX
from ..config import DetectorConfig
from ..types import TRACKED, Array, SkeletonFrame


class Glimpse(NamedTuple):
    """One person in one frame.

    Attributes:
        speed_m_s: SpineBase's speed towards the sensor over the last ``difference_frames`` frames; NaN before that.
        towards: how many of SpineMid, Neck and both shoulders moved towards the sensor by more than the floor.
        away: the same away from the sensor.
        tracked: how many of the four are tracked; the others are not counted above.
        hand_ratio: hand distance over shoulder distance in the sensor's x-y plane; NaN unless all four are known.
            The shoulders are its scale only, and may be inferred: raised forearms hide them.
        yaw_rad: heading relative to facing the sensor, counter-clockwise from above; NaN if a hip is missing.
        yaw_rate_rad_s: its rate over the same frames as the speed.
        hands: how many of the two are tracked.
    """

    speed_m_s: float
    towards: int
    away: int
    tracked: int
    hand_ratio: float
    yaw_rad: float
    yaw_rate_rad_s: float
    hands: int


BASE, MID, NECK, LEFT, RIGHT, HAND_LEFT, HAND_RIGHT, HIP_LEFT, HIP_RIGHT = (
    JOINT_INDEX[name]
    for name in (
        "SpineBase", "SpineMid", "Neck", "ShoulderLeft", "ShoulderRight", "HandLeft", "HandRight", "HipLeft",
        "HipRight",
    )
)  # fmt: skip
_UPPER = np.array([MID, NECK, LEFT, RIGHT])
_FIGURES = len(Glimpse._fields)
_BASE_Z = _FIGURES
_UPPER_Z = _FIGURES + 1
_COLUMNS = _FIGURES + 1 + len(_UPPER)
"""A person's row: the glimpse, then the depths that the next frames are compared with [m]."""


@njit(cache=True)
def yaw_rad(joints: Array) -> float:
    """Heading of one person (25, 3) relative to facing the sensor, from the lines across shoulders and hips.

    From the hips alone where a shoulder is missing (it leaves the range first); NaN where a hip is.
    """
    hips_x, hips_z = joints[HIP_LEFT, 0] - joints[HIP_RIGHT, 0], joints[HIP_LEFT, 2] - joints[HIP_RIGHT, 2]
    x, z = hips_x + joints[LEFT, 0] - joints[RIGHT, 0], hips_z + joints[LEFT, 2] - joints[RIGHT, 2]
    return atan2(hips_z, -hips_x) if isnan(x + z) else atan2(z, -x)


@njit(cache=True)
def _hand_ratio(joints: Array) -> float:
    """Hand distance over shoulder distance, both as the sensor sees them; NaN if the shoulders coincide."""
    shoulders = hypot(joints[LEFT, 0] - joints[RIGHT, 0], joints[LEFT, 1] - joints[RIGHT, 1])
    hands = hypot(joints[HAND_LEFT, 0] - joints[HAND_RIGHT, 0], joints[HAND_LEFT, 1] - joints[HAND_RIGHT, 1])
    return hands / shoulders if shoulders > 0.0 else nan


@njit(cache=True)
def _look(
    joints: Array, state: NDArray[np.int8], before: Array, oldest: Array, floor_m: float, span_s: float, out: Array
) -> None:
    """Write everybody's figures and depths, (P, `_COLUMNS`).

    Args:
        joints: (P, 25, 3) in the sensor's frame [m].
        state: (P, 25) tracking states.
        before: the same figures of the last frame.
        oldest: of the frame that speeds are taken from.
        floor_m: least motion between two frames that counts.
        span_s: time since the oldest; 0 without one, which leaves speeds unknown.
        out: output.
    """
    for p in range(len(joints)):
        row, body, known = out[p], joints[p], state[p]
        row[_BASE_Z] = body[BASE, 2]
        towards = away = tracked = 0
        for k in range(len(_UPPER)):
            z = row[_UPPER_Z + k] = body[_UPPER[k], 2]
            if known[_UPPER[k]] == TRACKED:
                way = before[p, _UPPER_Z + k] - z
                tracked += 1
                towards += way > floor_m
                away += way < -floor_m
        row[1], row[2], row[3] = towards, away, tracked
        row[4] = _hand_ratio(body)
        row[7] = (known[HAND_LEFT] == TRACKED) + (known[HAND_RIGHT] == TRACKED)
        yaw = row[5] = yaw_rad(body)
        row[0] = row[6] = nan
        if span_s > 0.0:
            row[0] = (oldest[p, _BASE_Z] - row[_BASE_Z]) / span_s
            turned = yaw - oldest[p, 5]
            row[6] = (turned - tau * np.rint(turned / tau)) / span_s


@njit(cache=True)
def report(joints: Array, state: NDArray[np.int8], pose: Array, bearing_rad: float, out: Array) -> None:
    """Write where everybody stands in the world: x, y [m], yaw [rad], and the shares of tracked joints and hands.

    Args:
        joints: (P, 25, 3) in the sensor's frame [m].
        state: (P, 25) tracking states.
        pose: (3, 4) rotation and position of the sensor in the world.
        bearing_rad: heading of someone who faces the sensor.
        out: (P, 5) output; NaN where SpineBase or a hip is not known.
    """
    for p in range(len(joints)):
        base = joints[p, BASE]
        for k in range(2):
            out[p, k] = pose[k, 0] * base[0] + pose[k, 1] * base[1] + pose[k, 2] * base[2] + pose[k, 3]
        yaw = bearing_rad + yaw_rad(joints[p])
        out[p, 2] = yaw - tau * np.rint(yaw / tau)
        out[p, 3] = np.sum(state[p] == TRACKED) / state.shape[1]
        out[p, 4] = ((state[p, HAND_LEFT] == TRACKED) + (state[p, HAND_RIGHT] == TRACKED)) / 2.0


BASE_HZ = 30
"""Frame rate that the thresholds' frames are meant for; at another one they stand for the same times."""


def frames_at(rate_hz: float, frames: int) -> int:
    """How many frames of another rate last as long as so many at `BASE_HZ`; at least one."""
    return max(1, round(frames * rate_hz / BASE_HZ))


class Glimpses:
    """Turns frames into glimpses; remembers as many frames as a speed needs.

    A lost frame only widens the intervals: every difference is divided by the time that really passed between its
    two frames. Joints that are not tracked are NaN and make every figure they enter NaN.

    Args:
        config: frames per speed and the early events' floor.
        rate_hz: nominal frame rate.

    Attributes:
        span_s: time over which the last frame's speeds were taken [s].
    """

    def __init__(self, config: DetectorConfig, rate_hz: float) -> None:
        self._floor_m_s = config.early_step_m * BASE_HZ
        self._step = frames_at(rate_hz, 1)
        self._frames = max(self._step, frames_at(rate_hz, config.difference_frames))
        self._past: deque[tuple[float, Array]] = deque(maxlen=self._frames)
        self.span_s = 0.0

    def reset(self) -> None:
        """Forget the frames."""
        self._past.clear()

    def update(self, frame: SkeletonFrame) -> list[Glimpse]:
        """Look at a frame.

        Args:
            frame: the newest frame, with the same persons as the frames before it.

        Returns:
            one glimpse for each of its P persons.
        """
        t_s, past = frame.t_sensor_s, self._past
        joints = frame.skeletons.joints
        seen = np.empty((len(joints), _COLUMNS))
        before_s, before = past[-min(self._step, len(past))] if past else (t_s, seen)
        oldest_s, oldest = past[0] if len(past) == self._frames else (t_s, seen)
        self.span_s = t_s - oldest_s
        _look(joints, frame.skeletons.state, before, oldest, self._floor_m_s * (t_s - before_s), self.span_s, seen)
        past.append((t_s, seen))
        return [Glimpse._make(row[:_FIGURES]) for row in seen.tolist()]
