"""What is wrong with a recording's joints: units that cannot be, and what keeps events from being found."""

from __future__ import annotations

import numpy as np

from .assets.names import JOINT_INDEX
from .errors import RecordError
from .types import NOT_TRACKED, TRACKED, Array, BoolArray, RecordedJoints

CLOSEST_S, FARTHEST_S = 0.001, 1.0
"""Frames nearer or farther apart than this are not timed in seconds (assumed)."""

SMALLEST_M, LARGEST_M = 0.05, 3.0
"""Bodies smaller or larger than this are not measured in metres (assumed)."""

UNSURE_M_S = 0.017
"""Error of a speed above which moves are invented or missed (measured on generated recordings)."""

_SHAKEN_S = 0.067
"""Time over which errors are told from motion."""

_NORMAL_QUARTILE = 0.3186
"""A quarter of normal deviates are smaller."""

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
            raise RecordError(
                f"t_s: frames are {gap_s:.3g} s apart, wanted {CLOSEST_S:g} to {FARTHEST_S:g} s: times in seconds"
            )
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


def doubts(recording: RecordedJoints) -> list[str]:
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
        error_m_s = speed_error_m_s(recording.t_s[frames], own[:, _BASE, 2])
        if error_m_s > UNSURE_M_S:
            told = "starts and stops may be missed or invented: smooth more (--smooth-s), or raise --detectors.on-m-s"
            said.append(f"person {person}: SpineBase jitters, its speed is uncertain by {error_m_s:.2f} m/s; {told}")
    return said


def speed_error_m_s(t_s: Array, depth_m: Array) -> float:
    """Standard deviation of the error of a speed that the detectors take, 0 if there is too little to tell.

    Told from motion by second differences, of which the lower quartile is taken: bodies are heavy, and stand still now
    and then. Errors that last longer than the frames compared show in part only.

    Args:
        t_s: (T,) times of the frames [s].
        depth_m: (T,) distance from the sensor, NaN where unknown [m].
    """
    if len(t_s) < 3:
        return 0.0
    back = max(1, round(_SHAKEN_S / float(np.median(np.diff(t_s)))))
    bent = depth_m[2 * back :] - 2.0 * depth_m[back:-back] + depth_m[: -2 * back]
    span_s = t_s[2 * back :] - t_s[: -2 * back]
    usable = np.isfinite(bent) & (span_s < 2.0 * np.median(span_s)) if len(span_s) else np.zeros(0, dtype=bool)
    if not usable.any():
        return 0.0
    return float(np.quantile(np.abs(bent[usable]) / span_s[usable], 0.25) / _NORMAL_QUARTILE / np.sqrt(3.0))


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
