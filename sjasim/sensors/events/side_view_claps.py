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

from ...config import DetectorConfig
from ...core import TRACKED, Array, DeviceEvent, IntArray, Kind, SkeletonFrame
from .clap_detection import met_s, unseen_hands
from .frame_features import HAND_LEFT, HAND_RIGHT, HIP_LEFT, HIP_RIGHT, LEFT, RIGHT, yaw_rad
from .thresholds import BASE_HZ, Records, rules

ASIDE_RAD = math.radians(100.0)
"""Largest heading relative to the sensor: beyond it the back hides the hands."""

FAR_SLACK = 0.4
"""So many shoulder widths the far hand, guessed behind the near one, may be off (measured on depth skeletons)."""

MEMORY_S = 0.35
"""How long the near hand may be inferred: hands that touch stay so long without a surface of their own (assumed)."""


@njit(cache=True)
def _ratio(joints: Array, slack: float) -> float:
    """How far the hands of one person (25, 3) are from meeting; NaN where a hand, shoulder or hip is not known.

    Twice the near hand's distance from the body's middle plane over the shoulder distance: people clap in their
    middle (assumed). No less than the distance of the hands over that of the shoulders, in space, less ``slack``: one
    arm that swings across is no clap.
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
    return float(max(2.0 * middle, apart - slack * width) / width)


@njit(cache=True)
def _judge(joints: Array, state: NDArray[np.int8], t_s: float, limits: Records, hands: Records, t_met_s: Array) -> bool:
    """Write when everybody's hands met, (P,), NaN where this frame does not show it; whether any did."""
    found = False
    for p in range(len(joints)):
        body = joints[p]
        left = body[HAND_LEFT, 2] < body[HAND_RIGHT, 2]
        near, far = (HAND_LEFT, HAND_RIGHT) if left else (HAND_RIGHT, HAND_LEFT)
        ratio = _ratio(body, 0.0 if state[p, far] == TRACKED else FAR_SLACK)
        if not abs(yaw_rad(body)) <= ASIDE_RAD:
            ratio = math.nan
        t_met_s[p] = met_s(hands[p], t_s, ratio, state[p, near] == TRACKED, MEMORY_S, limits[0])
        found = found or not math.isnan(t_met_s[p])
    return found


class SideClapDetector:
    """All persons' claps of one client that looks from the side.

    Args:
        config: the clap's thresholds.
    """

    def __init__(self, config: DetectorConfig) -> None:
        self._rules = rules(config, BASE_HZ)
        self._persons: IntArray | None = None
        self._names: list[int] = []
        self._hands: Records
        self._meet(np.zeros(0, dtype=np.int64))
        self.reset()

    def reset(self) -> None:
        """Begin anew: nobody's hands have been seen apart."""
        self._persons = None

    def update(self, frame: SkeletonFrame) -> list[DeviceEvent]:
        """Judge one frame; frames come in order of their time, some may be missing.

        Args:
            frame: all persons' skeletons. Somebody new begins anew, the others go on.

        Returns:
            the claps that it shows, stamped with the time it had been processed.
        """
        persons, joints, state = frame.skeletons
        t_s = frame.t_sensor_s
        if persons is not self._persons:
            self._meet(persons)
        if not _judge(joints, state, t_s, self._rules, self._hands, self._t_met_s):
            return []
        return [
            DeviceEvent(frame.sensor, person, Kind.CLAP, frame.t_device_s, False, frame.t_capture_device_s + met - t_s)
            for person, met in zip(self._names, self._t_met_s.tolist(), strict=True)
            if not math.isnan(met)
        ]

    def _meet(self, persons: IntArray) -> None:
        """Begin anew with those who were not there before."""
        names = persons.tolist()
        if self._persons is None or names != self._names:
            before = [] if self._persons is None else self._names
            hands = unseen_hands(len(names))
            for row, name in enumerate(names):
                if name in before:
                    hands[row] = self._hands[before.index(name)]
            self._names, self._hands, self._t_met_s = names, hands, np.zeros(len(names))
        self._persons = persons
