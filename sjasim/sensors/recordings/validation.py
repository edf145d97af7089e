"""What is wrong with a recording's joints: units that cannot be, and what keeps events from being found."""

from __future__ import annotations

import numpy as np

from ...assets.names import JOINT_INDEX
from ...core import NOT_TRACKED, TRACKED, Array, BoolArray, RecordedJoints
from ...core.errors import RecordError

CLOSEST_S, FARTHEST_S = 0.001, 1.0
"""Frames nearer or farther apart than this are not timed in seconds (assumed)."""

SMALLEST_M, LARGEST_M = 0.05, 3.0
"""Bodies smaller or larger than this are not measured in metres (assumed)."""

UNREST_M_S = 0.055
"""Speeds of somebody who stays in place from which on moves are invented or missed (measured on generated recordings:
below it one event in fifty at most, above it more and more)."""

_STAYS_S, _STAYS_M, _LEAST_S = 1.0, 0.1, 3.0
"""Who is so near after so long has stayed in place; how much of that tells something (assumed)."""

_SPEED_S = 4 / 30
"""Time over which the detectors take speeds."""

_HALF_OF_NORMAL = 0.6745
"""Half of normal deviates are smaller."""

_BASE, _HEAD = JOINT_INDEX["SpineBase"], JOINT_INDEX["Head"]
_HANDS = [JOINT_INDEX["HandLeft"], JOINT_INDEX["HandRight"]]
_HIPS = [JOINT_INDEX["HipLeft"], JOINT_INDEX["HipRight"]]


def check_units(recording: RecordedJoints) -> None:
    """Refuse times that are not in seconds and joints that are not in metres.

    Raises:
        RecordError: frames lie too near together or too far apart, or bodies are too large or too small.
    """
    if len(recording.t_s) > 1:
        gap_s = float(np.median(np.diff(recording.t_s)))
        if not CLOSEST_S <= gap_s <= FARTHEST_S:
            wanted = f"{CLOSEST_S:g} to {FARTHEST_S:g} s: times in seconds, one for all joints of a frame"
            raise RecordError(f"t_s: frames are {gap_s:.3g} s apart, wanted {wanted}")
    several = (recording.state != NOT_TRACKED).sum(axis=2) > 1
    if not several.any():
        return
    bodies = recording.joints_m[several]
    size_m = float(np.median((np.nanmax(bodies, axis=1) - np.nanmin(bodies, axis=1)).max(axis=1)))
    if size_m > LARGEST_M or 0.0 < size_m < SMALLEST_M:
        told = f"{size_m:,.0f}" if size_m > LARGEST_M else f"{size_m:.2g}"
        raise RecordError(
            f"x_m, y_m, z_m: bodies are {told} m large, wanted {SMALLEST_M:g} to {LARGEST_M:g} m: joints in metres"
        )


def quality_warnings(recording: RecordedJoints) -> list[str]:
    """What keeps events of a recording from being found, or from being true: a line each, in words.

    Args:
        recording: as the detectors get it, its short gaps bridged.
    """
    known = recording.state != NOT_TRACKED
    said = []
    for row, person in enumerate(recording.persons.tolist()):
        frames = known[:, row].any(axis=1)
        if not frames.any():
            said.append(f"person {person} is in no frame")
            continue
        own = recording.joints_m[frames, row]
        for doubt in (*_missing(known[frames, row], recording.state[frames, row]), *_astray(own)):
            said.append(f"person {person}: {doubt}")
        unrest_m_s = standing_speed_noise(recording.t_s[frames], own[:, _BASE, 2])
        if unrest_m_s > UNREST_M_S:
            told = "starts and stops may be missed or invented: smooth more (--smooth-s), or raise --detectors.on-m-s"
            said.append(f"person {person}: SpineBase strays at {unrest_m_s:.2f} m/s while in place; {told}")
    return said


def standing_speed_noise(t_s: Array, depth_m: Array) -> float:
    """Standard deviation of the speed of somebody who stays in place [m/s], by jitter or small movements.

    Args:
        t_s: (F,) times of the frames [s].
        depth_m: (F,) distance from the sensor, NaN where unknown [m].

    Returns:
        the deviation; 0 if they hardly ever stay in place.
    """
    gap_s = float(np.median(np.diff(t_s))) if len(t_s) > 1 else _LEAST_S
    narrow, wide = (max(1, round(0.5 * span_s / gap_s)) for span_s in (_SPEED_S, _STAYS_S))
    count = len(t_s) - 2 * wide
    if count < 1:
        return 0.0
    after, before = (slice(wide + by, wide + by + count) for by in (narrow, -narrow))
    speeds = (depth_m[after] - depth_m[before]) / (t_s[after] - t_s[before])
    stays = np.abs(depth_m[2 * wide :] - depth_m[:count]) < _STAYS_M
    still = speeds[stays & np.isfinite(speeds)]
    return float(np.median(np.abs(still))) / _HALF_OF_NORMAL if len(still) * gap_s >= _LEAST_S else 0.0


def _missing(known: BoolArray, state: Array) -> list[str]:
    """Joints that the events of one person need, by (F, 25) frames in which the person is seen."""
    base, hips = known[:, _BASE], known[:, _HIPS].all(axis=1)
    hands = (state[:, _HANDS] == TRACKED).all(axis=1)
    said = []
    for there, name, lost in (
        (hips, "both hips (HipLeft, HipRight)", "events"),
        (base, "SpineBase", "starts and stops"),
        (hands, "two tracked hands (HandLeft, HandRight)", "claps"),
    ):
        share = 1.0 - float(there.mean())
        if share == 1.0:
            said.append(f"no {lost} can be found: none of {len(known)} frames has {name}")
        elif share > 0.0:
            said.append(f"{share:.1%} of {len(known)} frames lack {name}: {lost} in them may be missed")
    return said


def _astray(own: Array) -> list[str]:
    """Axes that are not the Kinect's, by (F, 25, 3) joints."""
    said = []
    upright = _seen(own[:, _HEAD] - own[:, _BASE])
    if len(upright):
        x, y, z = np.median(upright, axis=0).tolist()
        if y < max(abs(x), abs(z)):
            said.append("the head is not above SpineBase: y must point up")
    base = _seen(own[:, _BASE])
    if len(base) and np.median(base[:, 2]) <= 0.0:
        said.append(f"SpineBase's z is {np.median(base[:, 2]):.2f} m: z must point away from the sensor")
    hips = _seen(own[:, _HIPS[0]] - own[:, _HIPS[1]])
    back = float((hips[:, 0] > 0.0).mean()) if len(hips) else 0.0
    if back > 0.5:
        said.append(f"the back is to the sensor in {back:.0%} of the frames (no clap): x must point to its left")
    return said


def _seen(points: Array) -> Array:
    """Those of (F, 3) points that are known."""
    return np.asarray(points[np.isfinite(points).all(axis=1)])
