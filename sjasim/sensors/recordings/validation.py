"""Checks of recorded joints: units that cannot be right, and conditions under which events are missed or false."""

from __future__ import annotations

import numpy as np

from ...assets.names import JOINT_INDEX
from ...core import NOT_TRACKED, TRACKED, Array, BoolArray, RecordedJoints
from ...core.errors import RecordError

SHORTEST_INTERVAL_S = 0.001
"""Shortest median time between frames; shorter times are not in seconds (assumed)."""

LONGEST_INTERVAL_S = 1.0
"""Longest median time between frames; longer times are not in seconds (assumed)."""

SMALLEST_BODY_M = 0.05
"""Smallest median extent of a body; smaller joints are not in metres (assumed)."""

LARGEST_BODY_M = 3.0
"""Largest median extent of a body; larger joints are not in metres (assumed)."""

MAX_STANDING_SPEED_NOISE_M_S = 0.055
"""Standard deviation of the speed of a standing person above which moves are missed or false.

Measured on generated recordings: below it one event in fifty is affected at most, above it more and more are.
"""

_STANDING_S = 1.0
"""Time over which a person must stay in place to count as standing (assumed)."""

_STANDING_M = 0.1
"""Largest displacement in that time (assumed)."""

_LEAST_STANDING_S = 3.0
"""Shortest total time of standing from which the noise is estimated (assumed)."""

_SPEED_S = 4 / 30
"""Time over which the detectors take speeds."""

_MEDIAN_OF_ABSOLUTE_NORMAL = 0.6745
"""Median of the absolute value of a standard normal variable."""

_BASE = JOINT_INDEX["SpineBase"]
_HEAD = JOINT_INDEX["Head"]
_HANDS = [JOINT_INDEX["HandLeft"], JOINT_INDEX["HandRight"]]
_HIPS = [JOINT_INDEX["HipLeft"], JOINT_INDEX["HipRight"]]


def check_units(recording: RecordedJoints) -> None:
    """Check that times are in seconds and joints in metres.

    Raises:
        RecordError: the median time between frames or the median extent of the bodies is out of range.
    """
    if len(recording.t_s) > 1:
        interval_s = float(np.median(np.diff(recording.t_s)))
        if not SHORTEST_INTERVAL_S <= interval_s <= LONGEST_INTERVAL_S:
            limits = f"{SHORTEST_INTERVAL_S:g} to {LONGEST_INTERVAL_S:g} s"
            raise RecordError(
                f"t_s: frames are {interval_s:.3g} s apart, wanted {limits}: times in seconds, one for all joints of a "
                "frame"
            )

    several = (recording.state != NOT_TRACKED).sum(axis=2) > 1
    if not several.any():
        return
    bodies = recording.joints_m[several]
    extents_m = (np.nanmax(bodies, axis=1) - np.nanmin(bodies, axis=1)).max(axis=1)
    extent_m = float(np.median(extents_m))

    # An extent of 0 says nothing about units: all known joints are at one place.
    if extent_m > LARGEST_BODY_M or 0.0 < extent_m < SMALLEST_BODY_M:
        written = f"{extent_m:,.0f}" if extent_m > LARGEST_BODY_M else f"{extent_m:.2g}"
        limits = f"{SMALLEST_BODY_M:g} to {LARGEST_BODY_M:g} m"
        raise RecordError(f"x_m, y_m, z_m: bodies are {written} m large, wanted {limits}: joints in metres")


def quality_warnings(recording: RecordedJoints) -> list[str]:
    """Return one line for each condition under which events of a person are missed or false.

    Args:
        recording: the joints that the detectors get, with short gaps interpolated.
    """
    known = recording.state != NOT_TRACKED
    warnings = []
    for row, person in enumerate(recording.persons.tolist()):
        in_frame = known[:, row].any(axis=1)
        if not in_frame.any():
            warnings.append(f"person {person} is in no frame")
            continue

        joints_m = recording.joints_m[in_frame, row]
        missing = _missing_joints(known[in_frame, row], recording.state[in_frame, row])
        for text in (*missing, *_wrong_axes(joints_m)):
            warnings.append(f"person {person}: {text}")

        noise_m_s = standing_speed_noise(recording.t_s[in_frame], joints_m[:, _BASE, 2])
        if noise_m_s > MAX_STANDING_SPEED_NOISE_M_S:
            warnings.append(
                f"person {person}: SpineBase has a speed noise of {noise_m_s:.2f} m/s while standing; starts and stops "
                "may be missed or false: smooth more (--smooth-s), or raise --detectors.start-speed-m-s"
            )
    return warnings


def standing_speed_noise(t_s: Array, depth_m: Array) -> float:
    """Return the standard deviation of the speed of a standing person, from noise or small movements.

    The estimate is the median absolute deviation, which a few steps do not change.

    Args:
        t_s: (F,) times of the frames [s].
        depth_m: (F,) distance from the sensor, NaN where unknown [m].

    Returns:
        the standard deviation [m/s]; 0 if the person stands for less than 3 s in all.
    """
    interval_s = float(np.median(np.diff(t_s))) if len(t_s) > 1 else _LEAST_STANDING_S
    speed_frames = max(1, round(0.5 * _SPEED_S / interval_s))
    standing_frames = max(1, round(0.5 * _STANDING_S / interval_s))
    count = len(t_s) - 2 * standing_frames
    if count < 1:
        return 0.0

    # Speeds around frames that have frames on both sides, and whether the person stays in place around them.
    after = slice(standing_frames + speed_frames, standing_frames + speed_frames + count)
    before = slice(standing_frames - speed_frames, standing_frames - speed_frames + count)
    speeds_m_s = (depth_m[after] - depth_m[before]) / (t_s[after] - t_s[before])
    stands = np.abs(depth_m[2 * standing_frames :] - depth_m[:count]) < _STANDING_M

    standing = speeds_m_s[stands & np.isfinite(speeds_m_s)]
    if len(standing) * interval_s < _LEAST_STANDING_S:
        return 0.0
    return float(np.median(np.abs(standing))) / _MEDIAN_OF_ABSOLUTE_NORMAL


def _missing_joints(known: BoolArray, state: Array) -> list[str]:
    """Return a text for each group of joints that events need and that frames lack.

    Args:
        known: (F, 25) whether a joint is known, in frames with the person.
        state: (F, 25) tracking states in these frames.
    """
    hands_tracked = (state[:, _HANDS] == TRACKED).all(axis=1)
    needs = (
        (known[:, _HIPS].all(axis=1), "both hips (HipLeft, HipRight)", "events"),
        (known[:, _BASE], "SpineBase", "starts and stops"),
        (hands_tracked, "two tracked hands (HandLeft, HandRight)", "claps"),
    )

    texts = []
    for there, joints, events in needs:
        share = 1.0 - float(there.mean())
        if share == 1.0:
            texts.append(f"no {events} can be found: none of {len(known)} frames has {joints}")
        elif share > 0.0:
            texts.append(f"{share:.1%} of {len(known)} frames lack {joints}: {events} in them may be missed")
    return texts


def _wrong_axes(joints_m: Array) -> list[str]:
    """Return a text for each axis that is not that of the Kinect's camera space, by (F, 25, 3) joints."""
    texts = []
    trunk = _known_points(joints_m[:, _HEAD] - joints_m[:, _BASE])
    if len(trunk):
        x, y, z = np.median(trunk, axis=0).tolist()
        if y < max(abs(x), abs(z)):
            texts.append("the head is not above SpineBase: y must point up")

    base = _known_points(joints_m[:, _BASE])
    if len(base) and np.median(base[:, 2]) <= 0.0:
        texts.append(f"SpineBase's z is {np.median(base[:, 2]):.2f} m: z must point away from the sensor")

    # From the left to the right hip a person who faces the sensor extends along negative x.
    hips = _known_points(joints_m[:, _HIPS[0]] - joints_m[:, _HIPS[1]])
    back = float((hips[:, 0] > 0.0).mean()) if len(hips) else 0.0
    if back > 0.5:
        texts.append(f"the back is to the sensor in {back:.0%} of the frames (no clap): x must point to its left")
    return texts


def _known_points(points: Array) -> Array:
    """Return those of (F, 3) points that have no NaN."""
    return np.asarray(points[np.isfinite(points).all(axis=1)])
