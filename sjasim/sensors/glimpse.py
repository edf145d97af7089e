"""What the detectors look at: a few numbers per person from each frame, for all persons at once."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from ..assets.names import JOINT_INDEX
from ..config import DetectorConfig
from ..types import TRACKED, Array, SkeletonFrame

_ROWS = np.array(
    [
        JOINT_INDEX[name]
        for name in (
            "SpineBase", "SpineMid", "Neck", "ShoulderLeft", "ShoulderRight",
            "HipLeft", "HipRight", "HandLeft", "HandRight",
        )
    ]
)  # fmt: skip
"""Rows taken from a skeleton: SpineBase, the four upper joints of the early events, then pairs left and right."""

_UPPER = slice(1, 5)
_CLAPPING = _ROWS[[3, 4, 7, 8]]


class Glimpse(NamedTuple):
    """One person in one frame.

    Attributes:
        speed_m_s: SpineBase's speed towards the sensor over the last ``difference_frames`` frames; NaN before that.
        towards: how many of SpineMid, Neck and both shoulders moved towards the sensor by more than the floor.
        away: the same away from the sensor.
        tracked: how many of the four are tracked; the others are not counted above.
        hand_ratio: hand distance over shoulder distance in the sensor's x-y plane; NaN unless all four are tracked.
        yaw_rad: heading relative to facing the sensor, counter-clockwise from above; NaN if hips or shoulders miss.
        yaw_rate_rad_s: its rate over the same frames as the speed.
    """

    speed_m_s: float
    towards: int
    away: int
    tracked: int
    hand_ratio: float
    yaw_rad: float
    yaw_rate_rad_s: float


class _Past(NamedTuple):
    t_s: float
    depth: Array
    yaw: list[float]


class Glimpses:
    """Turns frames into glimpses; remembers as many frames as a speed needs.

    A lost frame only widens the intervals: every difference is divided by the time that really passed between its
    two frames. Joints that are not tracked are NaN and make every figure they enter NaN.

    Args:
        config: frames per speed and the early events' floor.
        rate_hz: nominal frame rate, which turns the floor per frame into a speed.

    Attributes:
        span_s: time over which the last frame's speeds were taken [s].
    """

    def __init__(self, config: DetectorConfig, rate_hz: int) -> None:
        self._floor_m_s = config.early_step_m * rate_hz
        self._past: deque[_Past] = deque(maxlen=config.difference_frames)
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
        joints, state, t_s = frame.skeletons.joints, frame.skeletons.state, frame.t_sensor_s
        rows = joints.take(_ROWS, axis=1)
        across = rows[:, 3::2] - rows[:, 4::2]
        yaw = yaw_rad(across)
        depth = rows[:, :5, 2]
        counts = self._counts(depth, state, t_s)
        ratio = _hand_ratio(across, state)
        speed, turned = self._rates(depth, yaw, t_s)
        self._past.append(_Past(t_s, depth, yaw))
        return list(map(Glimpse, speed, *counts, ratio, yaw, turned))

    def _rates(self, depth: Array, yaw: list[float], t_s: float) -> tuple[list[float], list[float]]:
        if len(self._past) < (self._past.maxlen or 0):
            missing = [math.nan] * len(yaw)
            return missing, missing
        oldest = self._past[0]
        self.span_s = span_s = t_s - oldest.t_s
        speed = ((oldest.depth[:, 0] - depth[:, 0]) / span_s).tolist()
        turned = [math.remainder(now - then, math.tau) / span_s for now, then in zip(yaw, oldest.yaw, strict=True)]
        return speed, turned

    def _counts(self, depth: Array, state: np.ndarray, t_s: float) -> list[list[int]]:
        """(3 lists of P) how many upper joints went towards the sensor, away from it, and are tracked."""
        if not self._past:
            return [[0] * len(depth)] * 3
        before = self._past[-1]
        step = before.depth[:, _UPPER] - depth[:, _UPPER]
        floor_m = self._floor_m_s * (t_s - before.t_s)
        masks = np.empty((3, *step.shape), dtype=bool)
        np.greater(step, floor_m, out=masks[0])
        np.less(step, -floor_m, out=masks[1])
        masks[2] = True
        masks &= state.take(_ROWS[_UPPER], axis=1) == TRACKED
        counts: list[list[int]] = masks.sum(axis=2).tolist()
        return counts


def yaw_rad(across: Array) -> list[float]:
    """Headings relative to facing the sensor, from the lines across shoulders and hips.

    Args:
        across: (P, 2 or more, 3) right-to-left vectors of shoulders, then hips, in the sensor's frame [m].

    Returns:
        P angles, 0 facing the sensor, counter-clockwise from above positive [rad]; NaN if a joint is missing.
    """
    left = across[:, 0] + across[:, 1]
    yaw: list[float] = np.arctan2(left[:, 2], -left[:, 0]).tolist()
    return yaw


def _hand_ratio(across: Array, state: np.ndarray) -> list[float]:
    """Hand distance over shoulder distance; NaN unless both hands and shoulders are tracked."""
    flat = np.hypot(across[:, :, 0], across[:, :, 1])
    ratio = flat[:, 2] / flat[:, 0]
    seen = (state.take(_CLAPPING, axis=1) == TRACKED).all(axis=1)
    values: list[float] = np.where(seen, ratio, np.nan).tolist()
    return values


def across_body(joints: Array) -> Array:
    """Right-to-left vectors of shoulders, hips and hands.

    Args:
        joints: (P, 25, 3) in the sensor's frame [m].

    Returns:
        (P, 3, 3) [m].
    """
    rows = joints.take(_ROWS, axis=1)
    return np.asarray(rows[:, 3::2] - rows[:, 4::2])


