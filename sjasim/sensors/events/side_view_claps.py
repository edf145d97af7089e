"""Detection of claps seen from the side, for persons whose hands are occluded from the sensor that they face.

The hand ratio of the front view is useless here: from the side, hands and shoulders lie behind one another in the
sensor's x-y plane, and the near hand occludes the far one as they meet. The ratio of this module uses depth instead,
and mostly the near hand.
"""

from __future__ import annotations

import math
from math import hypot

import numpy as np
from numpy.typing import NDArray

from ...config import DetectorConfig
from ...core import TRACKED, Array, DeviceEvent, IntArray, Kind, SkeletonFrame
from ...core.compiled import compiled_entry, compiled_inner
from .clap_detection import clap_time_s, initial_clap_states
from .frame_features import (
    HAND_LEFT,
    HAND_RIGHT,
    HIP_LEFT,
    HIP_RIGHT,
    SHOULDER_LEFT,
    SHOULDER_RIGHT,
    yaw_rad,
)
from .thresholds import REFERENCE_RATE_HZ, Records, threshold_row

LARGEST_YAW_RAD = math.radians(100.0)
"""Largest heading relative to the sensor at which claps are detected; beyond it the back occludes the hands."""

FAR_HAND_ERROR = 0.4
"""Error of an inferred far hand [shoulder widths]; measured on skeletons from depth images."""

LONGEST_INFERRED_S = 0.35
"""How long the near hand may be inferred: for that time hands that touch have no separate surfaces (assumed)."""


class SideClapDetector:
    """Detector of the claps of all persons whom one sensor sees from the side.

    Args:
        config: thresholds, of which those of a clap are used.
    """

    def __init__(self, config: DetectorConfig) -> None:
        # The clap's thresholds are times and ratios, which do not depend on the frame rate.
        self._thresholds = threshold_row(config, REFERENCE_RATE_HZ)
        self._persons: IntArray | None = None
        self._names: list[int] = []
        self._hands: Records
        self._t_claps_s: Array
        self._set_persons(np.zeros(0, dtype=np.int64))
        self.reset()

    def reset(self) -> None:
        """Forget what was seen: each person's hands must be seen apart again."""
        self._persons = None

    def update(self, frame: SkeletonFrame) -> list[DeviceEvent]:
        """Return the claps that a frame shows.

        Args:
            frame: skeletons of all persons. Frames come in the order of their times; some may be missing. The state of
                a person who was not in the last frame is initialised.

        Returns:
            the claps in the order of the persons, with the time at which the frame had been processed.
        """
        persons, joints, tracking = frame.skeletons
        t_s = frame.t_sensor_s
        if persons is not self._persons:
            self._set_persons(persons)
        if not _detect_claps(joints, tracking, t_s, self._thresholds, self._hands, self._t_claps_s):
            return []

        return [
            DeviceEvent(
                frame.sensor, person, Kind.CLAP, frame.t_device_s, False, frame.t_capture_device_s + t_clap_s - t_s
            )
            for person, t_clap_s in zip(self._names, self._t_claps_s.tolist(), strict=True)
            if not math.isnan(t_clap_s)
        ]

    def _set_persons(self, persons: IntArray) -> None:
        """Set the person of each row; initialise the state of new persons and keep that of the others."""
        names = persons.tolist()
        if self._persons is None or names != self._names:
            previous_names = [] if self._persons is None else self._names
            hands = initial_clap_states(len(names))
            for row, name in enumerate(names):
                if name in previous_names:
                    hands[row] = self._hands[previous_names.index(name)]

            self._names = names
            self._hands = hands
            self._t_claps_s = np.zeros(len(names))
        self._persons = persons


@compiled_inner
def _side_hand_ratio(joints: Array, slack: float) -> float:
    """Return a measure of how far the hands are from meeting.

    The ratio is twice the distance of the near hand from the body's median plane over the shoulder distance, because
    people clap in front of their middle (assumed). It is at least the distance of the hands over that of the
    shoulders, in space, minus ``slack``: one arm that swings across the body is no clap.

    Args:
        joints: (25, 3) joints of one person in the sensor's frame [m].
        slack: error of the far hand [shoulder widths].

    Returns:
        the ratio, in which hands that meet are 0; NaN if a hand, shoulder or hip is unknown.
    """
    width_m = _distance_m(joints, SHOULDER_LEFT, SHOULDER_RIGHT)
    line_x = joints[SHOULDER_LEFT, 0] - joints[SHOULDER_RIGHT, 0] + joints[HIP_LEFT, 0] - joints[HIP_RIGHT, 0]
    line_z = joints[SHOULDER_LEFT, 2] - joints[SHOULDER_RIGHT, 2] + joints[HIP_LEFT, 2] - joints[HIP_RIGHT, 2]
    line_length = hypot(line_x, line_z)
    if not (width_m > 0.0 and line_length > 0.0):
        return math.nan

    # Distance of the near hand from the plane through the middle of the shoulders, whose normal is the line.
    near = HAND_LEFT if joints[HAND_LEFT, 2] < joints[HAND_RIGHT, 2] else HAND_RIGHT
    offset_x = joints[near, 0] - (joints[SHOULDER_LEFT, 0] + joints[SHOULDER_RIGHT, 0]) / 2
    offset_z = joints[near, 2] - (joints[SHOULDER_LEFT, 2] + joints[SHOULDER_RIGHT, 2]) / 2
    from_middle_m = abs(offset_x * line_x + offset_z * line_z) / line_length

    hands_m = _distance_m(joints, HAND_LEFT, HAND_RIGHT)
    return float(max(2.0 * from_middle_m, hands_m - slack * width_m) / width_m)


@compiled_inner
def _distance_m(joints: Array, one: int, other: int) -> float:
    """Return the distance of two joints, by their indices."""
    # Written by component: array expressions on three numbers take long to compile.
    x = joints[one, 0] - joints[other, 0]
    y = joints[one, 1] - joints[other, 1]
    z = joints[one, 2] - joints[other, 2]
    return math.sqrt(x * x + y * y + z * z)


@compiled_entry
def _detect_claps(
    joints: Array, tracking: NDArray[np.int8], t_s: float, threshold_rows: Records, hands: Records, t_claps_s: Array
) -> bool:
    """Write the times of the claps that one frame shows.

    Args:
        joints: (P, 25, 3) joints in the sensor's frame [m].
        tracking: (P, 25) tracking states.
        t_s: time of the frame on the sensor's clock.
        threshold_rows: (1,) `THRESHOLDS`.
        hands: (P,) `CLAP_STATE`; changed.
        t_claps_s: (P,) output, NaN for a person without a clap.

    Returns:
        whether there is any clap.
    """
    found = False
    for p in range(len(joints)):
        body = joints[p]
        left_is_near = body[HAND_LEFT, 2] < body[HAND_RIGHT, 2]
        near = HAND_LEFT if left_is_near else HAND_RIGHT
        far = HAND_RIGHT if left_is_near else HAND_LEFT

        ratio = _side_hand_ratio(body, 0.0 if tracking[p, far] == TRACKED else FAR_HAND_ERROR)
        # The negated comparison also covers an unknown heading, which is NaN.
        if not abs(yaw_rad(body)) <= LARGEST_YAW_RAD:
            ratio = math.nan
        near_tracked = tracking[p, near] == TRACKED
        t_claps_s[p] = clap_time_s(hands[p], t_s, ratio, near_tracked, LONGEST_INFERRED_S, threshold_rows[0])
        found = found or not math.isnan(t_claps_s[p])
    return found
