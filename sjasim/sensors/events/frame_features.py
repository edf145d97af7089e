"""What the detectors look at: a few numbers per person from each frame, compiled.

A lost frame only widens the intervals: every difference is divided by the time that really passed between its two
frames. Joints that are not tracked are NaN and make every figure they enter NaN.
"""

from __future__ import annotations

from math import atan2, hypot, isnan, nan, tau

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...assets.names import JOINT_INDEX
from ...core import TRACKED, Array
from .thresholds import Record, Records

SPINE_BASE, MID, NECK, LEFT, RIGHT, HAND_LEFT, HAND_RIGHT, HIP_LEFT, HIP_RIGHT = (
    JOINT_INDEX[name]
    for name in (
        "SpineBase", "SpineMid", "Neck", "ShoulderLeft", "ShoulderRight", "HandLeft", "HandRight", "HipLeft",
        "HipRight",
    )
)  # fmt: skip
UPPER = np.array([MID, NECK, LEFT, RIGHT])

GLIMPSE = np.dtype([
    ("speed_m_s", np.float64),  # SpineBase's towards the sensor over ``difference_frames``; NaN before that
    ("towards", np.int64),  # how many of the upper four moved towards the sensor by more than the floor
    ("away", np.int64),  # the same away from it
    ("tracked", np.int64),  # how many of the four are tracked; the others are not counted above
    ("hand_ratio", np.float64),  # hand distance over shoulder distance in the sensor's x-y plane; NaN unless all four
    # are known. The shoulders are its scale only, and may be inferred: raised forearms hide them
    ("yaw_rad", np.float64),  # heading relative to facing the sensor, counter-clockwise from above; NaN without a hip
    ("yaw_rate_rad_s", np.float64),  # its rate over the same frames as the speed
    ("hands", np.int64),  # how many of the two are tracked
    ("base_m", np.float64),  # SpineBase's depth, which the next frames are compared with
    ("upper_m", np.float64, len(UPPER)),  # the same of SpineMid, Neck and both shoulders
])  # fmt: skip
"""One person in one frame."""


def unseen(frames: int, count: int) -> Records:
    """(frames, count) `GLIMPSE` of people whom no frame has shown yet: whatever is compared with them is unknown."""
    out = np.zeros((frames, count), dtype=GLIMPSE)
    out["base_m"] = out["yaw_rad"] = out["upper_m"] = nan
    return out


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
def look(
    joints: Array, state: NDArray[np.int8], before: Record, oldest: Record, floor_m: float, span_s: float, seen: Record
) -> None:
    """Write one person's glimpse.

    Args:
        joints: (25, 3) in the sensor's frame [m].
        state: (25,) tracking states.
        before: the glimpse that single steps are taken from; ``seen`` itself at the first frame.
        oldest: the one that speeds are taken from.
        floor_m: least motion since ``before`` that counts.
        span_s: time since ``oldest``; 0 without one, which leaves speeds unknown.
        seen: one of `GLIMPSE`, output.
    """
    towards = away = tracked = 0
    for k in range(len(UPPER)):
        z = seen.upper_m[k] = joints[UPPER[k], 2]
        if state[UPPER[k]] == TRACKED:
            way = before.upper_m[k] - z
            tracked += 1
            towards += way > floor_m
            away += way < -floor_m
    seen.towards, seen.away, seen.tracked = towards, away, tracked
    seen.hands = int(state[HAND_LEFT] == TRACKED) + int(state[HAND_RIGHT] == TRACKED)
    seen.hand_ratio, seen.yaw_rad, seen.base_m = _hand_ratio(joints), yaw_rad(joints), joints[SPINE_BASE, 2]
    seen.speed_m_s = seen.yaw_rate_rad_s = nan
    if span_s > 0.0:
        seen.speed_m_s = (oldest.base_m - seen.base_m) / span_s
        turned = seen.yaw_rad - oldest.yaw_rad
        seen.yaw_rate_rad_s = (turned - tau * np.rint(turned / tau)) / span_s
