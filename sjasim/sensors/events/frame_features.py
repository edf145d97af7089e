"""Features of one person in one frame, from which the detectors decide.

Speeds are differences of two frames divided by the time between these frames, so lost frames only make that time
longer. A joint that is not tracked has NaN coordinates and makes each feature NaN that depends on it.
"""

from __future__ import annotations

from math import atan2, hypot, isnan, nan, tau

import numpy as np
from numpy.typing import NDArray

from ...assets.names import JOINT_INDEX
from ...core import TRACKED, Array
from ...core.compiled import compiled_inner
from .thresholds import Record, Records

SPINE_BASE = JOINT_INDEX["SpineBase"]
SHOULDER_LEFT = JOINT_INDEX["ShoulderLeft"]
SHOULDER_RIGHT = JOINT_INDEX["ShoulderRight"]
HAND_LEFT = JOINT_INDEX["HandLeft"]
HAND_RIGHT = JOINT_INDEX["HandRight"]
HIP_LEFT = JOINT_INDEX["HipLeft"]
HIP_RIGHT = JOINT_INDEX["HipRight"]

UPPER_JOINTS = np.array([JOINT_INDEX["SpineMid"], JOINT_INDEX["Neck"], SHOULDER_LEFT, SHOULDER_RIGHT])
"""Joints whose steps make early events. Source: iqbal2016, section II-B."""

FRAME_FEATURES = np.dtype([
    ("approach_speed_m_s", np.float64),  # speed of SpineBase towards the sensor; NaN in the first frames
    ("joints_approaching", np.int64),  # tracked upper joints that moved towards the sensor by more than the floor
    ("joints_receding", np.int64),  # tracked upper joints that moved away from it by more than the floor
    ("joints_tracked", np.int64),  # tracked upper joints
    # Distance of the hands over distance of the shoulders in the sensor's x-y plane; NaN if one of these joints is
    # unknown. Shoulders may be inferred, because raised forearms occlude them and they only give the scale.
    ("hand_ratio", np.float64),
    ("yaw_rad", np.float64),  # heading relative to facing the sensor, counter-clockwise from above; NaN without hips
    ("yaw_rate_rad_s", np.float64),  # rate of that heading over the same frames as the speed
    ("hands_tracked", np.int64),  # tracked hands
    ("spine_base_depth_m", np.float64),  # depth of SpineBase, with which later frames are compared
    ("upper_depths_m", np.float64, len(UPPER_JOINTS)),  # depths of the upper joints, for the same purpose
])  # fmt: skip
"""Features of one person in one frame."""


def initial_features(frames: int, persons: int) -> Records:
    """Return (frames, persons) `FRAME_FEATURES` of frames that do not exist: all comparisons with them are NaN."""
    out = np.zeros((frames, persons), dtype=FRAME_FEATURES)
    out["spine_base_depth_m"] = nan
    out["yaw_rad"] = nan
    out["upper_depths_m"] = nan
    return out


@compiled_inner
def yaw_rad(joints: Array) -> float:
    """Return the heading of one person relative to facing the sensor.

    The heading is normal to the sum of the lines across shoulders and hips. The hips alone count if a shoulder is
    unknown, because shoulders are the first to leave the picture of a near person.

    Args:
        joints: (25, 3) joints in the sensor's frame [m].

    Returns:
        the heading, counter-clockwise from above, -pi to pi; NaN if a hip is unknown.
    """
    hips_x = joints[HIP_LEFT, 0] - joints[HIP_RIGHT, 0]
    hips_z = joints[HIP_LEFT, 2] - joints[HIP_RIGHT, 2]
    both_x = hips_x + joints[SHOULDER_LEFT, 0] - joints[SHOULDER_RIGHT, 0]
    both_z = hips_z + joints[SHOULDER_LEFT, 2] - joints[SHOULDER_RIGHT, 2]
    return atan2(hips_z, -hips_x) if isnan(both_x + both_z) else atan2(both_z, -both_x)


@compiled_inner
def _hand_ratio(joints: Array) -> float:
    """Return hand distance over shoulder distance in the sensor's x-y plane; NaN if the shoulders coincide there."""
    shoulders_m = hypot(
        joints[SHOULDER_LEFT, 0] - joints[SHOULDER_RIGHT, 0], joints[SHOULDER_LEFT, 1] - joints[SHOULDER_RIGHT, 1]
    )
    hands_m = hypot(joints[HAND_LEFT, 0] - joints[HAND_RIGHT, 0], joints[HAND_LEFT, 1] - joints[HAND_RIGHT, 1])
    return hands_m / shoulders_m if shoulders_m > 0.0 else nan


@compiled_inner
def extract_features(
    joints: Array,
    state: NDArray[np.int8],
    step_reference: Record,
    speed_reference: Record,
    floor_m: float,
    span_s: float,
    out: Record,
) -> None:
    """Write the features of one person in one frame.

    Args:
        joints: (25, 3) joints in the sensor's frame [m].
        state: (25,) tracking states.
        step_reference: features of the frame from which steps of the upper joints are taken; ``out`` itself in the
            first frame, which makes all steps zero.
        speed_reference: features of the frame from which speeds are taken.
        floor_m: smallest step that counts as motion.
        span_s: time since the frame of ``speed_reference``; 0 if that frame does not exist, which makes speeds NaN.
        out: one of `FRAME_FEATURES`, output.
    """
    out.joints_approaching = 0
    out.joints_receding = 0
    out.joints_tracked = 0
    for k in range(len(UPPER_JOINTS)):
        depth_m = joints[UPPER_JOINTS[k], 2]
        out.upper_depths_m[k] = depth_m
        if state[UPPER_JOINTS[k]] == TRACKED:
            step_m = step_reference.upper_depths_m[k] - depth_m
            out.joints_tracked += 1
            out.joints_approaching += step_m > floor_m
            out.joints_receding += step_m < -floor_m

    out.hands_tracked = int(state[HAND_LEFT] == TRACKED) + int(state[HAND_RIGHT] == TRACKED)
    out.hand_ratio = _hand_ratio(joints)
    out.yaw_rad = yaw_rad(joints)
    out.spine_base_depth_m = joints[SPINE_BASE, 2]

    out.approach_speed_m_s = nan
    out.yaw_rate_rad_s = nan
    if span_s > 0.0:
        out.approach_speed_m_s = (speed_reference.spine_base_depth_m - out.spine_base_depth_m) / span_s
        # The difference of two headings is wrapped to -pi..pi.
        turned_rad = out.yaw_rad - speed_reference.yaw_rad
        out.yaw_rate_rad_s = (turned_rad - tau * np.rint(turned_rad / tau)) / span_s
