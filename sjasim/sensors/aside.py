"""Claps seen from the side, for people whose hands the client they face cannot see.

From there the paper's rule says nothing: hands and shoulders lie behind one another in the sensor's x-y plane, and the
near hand hides the far one as they meet. What is left is the near hand and the depth.
"""

from __future__ import annotations

import math
from math import hypot

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..config import DetectorConfig
from ..types import TRACKED, Array, DeviceEvent, IntArray, Kind, SkeletonFrame
from .glimpse import HAND_LEFT, HAND_RIGHT, HIP_LEFT, HIP_RIGHT, LEFT, RIGHT, yaw_rad

ASIDE_RAD = math.radians(100.0)
"""Largest heading relative to the sensor: beyond it the back hides the hands."""

FAR_SLACK = 0.4
"""So many shoulder widths the far hand, guessed behind the near one, may be off (measured on depth skeletons)."""

APART_RATIO = 0.8
"""Above it hands are apart; open hands have about 1.1."""

MEMORY_S = 0.25
"""So long before the hands meet the near one must have been tracked: touching hands hide each other (assumed)."""

_YAW, _RATIO, _NEAR = range(3)


@njit(cache=True)
def _ratio(joints: Array) -> float:
    """How far the hands of one person (25, 3) are from meeting; NaN where a hand, shoulder or hip is not known.

    Twice the near hand's distance from the body's middle plane over the shoulder distance: people clap in their
    middle (assumed). No less than the distance of the hands over that of the shoulders, in space, less `FAR_SLACK`:
    one arm that swings across is no clap.
    """
    line = joints[LEFT] - joints[RIGHT]
    width = np.sqrt(np.sum(line**2))
    line = line + joints[HIP_LEFT] - joints[HIP_RIGHT]
    across = hypot(line[0], line[2])
    if not (width > 0.0 and across > 0.0):
        return math.nan
    near = joints[HAND_LEFT] if joints[HAND_LEFT, 2] < joints[HAND_RIGHT, 2] else joints[HAND_RIGHT]
    off = near - (joints[LEFT] + joints[RIGHT]) / 2
    middle = abs(off[0] * line[0] + off[2] * line[2]) / across
    apart = np.sqrt(np.sum((joints[HAND_LEFT] - joints[HAND_RIGHT]) ** 2))
    return float(max(2.0 * middle, apart - FAR_SLACK * width) / width)


@njit(cache=True)
def _look(joints: Array, state: NDArray[np.int8], out: Array) -> None:
    """Write everybody's heading relative to the sensor, ratio, and whether the near hand is tracked: (P, 3)."""
    for p in range(len(joints)):
        body = joints[p]
        near = HAND_LEFT if body[HAND_LEFT, 2] < body[HAND_RIGHT, 2] else HAND_RIGHT
        out[p, _YAW], out[p, _RATIO] = yaw_rad(body), _ratio(body)
        out[p, _NEAR] = state[p, near] == TRACKED


class AsideClap:
    """Claps of one person: local minima of the ratio below ``clap_ratio``.

    As in `detectors.ClapDetector` the event comes with the frame after the minimum, and hands must have been apart
    since the last clap, which must be ``clap_rest_s`` ago. The near hand must be tracked while apart, and once more
    within `MEMORY_S` of the minimum; at the minimum itself it may be inferred.

    Args:
        config: ratio and rest.
    """

    __slots__ = ("_apart", "_before", "_c", "_last", "_t_clap_s", "_t_last_s", "_t_tracked_s")

    def __init__(self, config: DetectorConfig) -> None:
        self._c = config
        self._t_clap_s = self._t_tracked_s = -math.inf
        self._before = self._last = self._t_last_s = math.nan
        self._apart = False

    def update(self, t_s: float, yaw_rad: float, ratio: float, tracked: bool) -> float | None:
        """Judge one frame at the sensor's time ``t_s``; gives the time at which the hands met, or None."""
        if not abs(yaw_rad) <= ASIDE_RAD:
            ratio = math.nan
        least, t_least_s = self._last, self._t_last_s
        found = (
            self._apart
            and self._before >= least < ratio
            and least < self._c.clap_ratio
            and t_s - self._t_clap_s >= self._c.clap_rest_s
            and t_least_s - self._t_tracked_s <= MEMORY_S
        )
        self._before, self._last, self._t_last_s = least, ratio, t_s
        if tracked:
            self._t_tracked_s = t_s
        if found:
            self._t_clap_s = t_s
            self._apart = False
            return t_least_s
        self._apart = self._apart or (tracked and ratio > APART_RATIO)
        return None


class AsideDetectors:
    """All persons' claps of one client that looks from the side.

    Args:
        config: the clap's thresholds.
    """

    def __init__(self, config: DetectorConfig) -> None:
        self._config = config
        self._persons: IntArray | None = None
        self._names: list[int] = []
        self._claps: list[AsideClap] = []

    def reset(self) -> None:
        """Begin anew: nobody's hands have been seen apart."""
        self._persons = None
        self._names = []

    def update(self, frame: SkeletonFrame) -> list[DeviceEvent]:
        """Judge one frame; frames come in order of their time, some may be missing.

        Args:
            frame: all persons' skeletons. If the persons differ from the last frame's, all begin anew.

        Returns:
            the claps that it shows, stamped with the time it had been processed.
        """
        joints, t_s = frame.skeletons.joints, frame.t_sensor_s
        if frame.skeletons.persons is not self._persons:
            self._meet(frame.skeletons.persons)
        figures = np.empty((len(joints), 3))
        _look(joints, frame.skeletons.state, figures)
        events = []
        for person, clap, (yaw, ratio, near) in zip(self._names, self._claps, figures.tolist(), strict=True):
            met_s = clap.update(t_s, yaw, ratio, near > 0.0)
            if met_s is not None:
                onset_s = frame.t_capture_device_s + met_s - t_s
                events.append(DeviceEvent(frame.sensor, person, Kind.CLAP, frame.t_device_s, False, onset_s))
        return events

    def _meet(self, persons: IntArray) -> None:
        names = persons.tolist()
        if names != self._names:
            self._names = names
            self._claps = [AsideClap(self._config) for _ in names]
        self._persons = persons
