"""Recorded joints made fit for the detectors: short gaps interpolate_gaps, the trunk's jitter gaussian_smooth.

Both look at the frames on either side, which a recording has and a live sensor has not; simulated sensors never pass
here. The arms are not gaussian_smooth: a clap is brief, and jitter does not hide it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...config.checks import within
from ...core import NOT_TRACKED, Array, BoolArray, IntArray, RecordedJoints

BRIDGE_S = 0.2
"""Longest gap of a joint that is interpolate_gaps: a blink of the tracker, shorter than any move (assumed)."""

SMOOTH_S = 0.3
"""Width over which trunks are gaussian_smooth: on generated recordings with jitter of 1 cm it leaves no false event, and moves
the times of clean ones by less than 10 ms."""

_ARM = ("Elbow", "Wrist", "Hand", "Thumb")
_STEADY = np.array([not name.startswith(_ARM) for name in JOINTS])
_ROUNDING_S = 1e-6

States = NDArray[np.int8]


def preprocess(recording: RecordedJoints, bridge_s: float = BRIDGE_S, smooth_s: float = SMOOTH_S) -> RecordedJoints:
    """A recording whose short gaps are interpolate_gaps and whose trunks are gaussian_smooth; 0 leaves the one or the other out.

    Raises:
        ConfigError: a time is negative or longer than 2 s.
    """
    within("bridge_s", bridge_s, 0.0, 2.0)
    within("smooth_s", smooth_s, 0.0, 2.0)
    joints, state = interpolate_gaps(recording.t_s, recording.joints_m, recording.state, bridge_s)
    joints = joints.copy()
    joints[:, :, _STEADY] = gaussian_smooth(recording.t_s, joints[:, :, _STEADY], smooth_s)
    return recording._replace(joints_m=joints, state=state)


def interpolate_gaps(t_s: Array, joints_m: Array, state: States, longest_s: float) -> tuple[Array, States]:
    """Lead every joint straight across its short gaps.

    Args:
        t_s: (T,) rising times of the frames [s].
        joints_m: (T, P, 25, 3) joints, NaN where unknown [m].
        state: (T, P, 25) tracking states, not tracked where the joint is unknown.
        longest_s: longest time between the two frames that know a joint; 0 bridges nothing.

    Returns:
        joints and states; a interpolate_gaps joint has the lower state of the two frames that it was led between. Longer gaps,
        and those at the beginning and the end, stay.
    """
    if not longest_s > 0.0 or not len(t_s):
        return joints_m, state
    known = state != NOT_TRACKED
    before, after = _nearest_known(known)
    inside = ~known & (before >= 0) & (after < len(t_s))
    frame, person, joint = np.nonzero(inside)
    first, last = before[inside], after[inside]
    short = t_s[last] - t_s[first] <= longest_s + _ROUNDING_S
    frame, person, joint, first, last = (index[short] for index in (frame, person, joint, first, last))
    share = ((t_s[frame] - t_s[first]) / (t_s[last] - t_s[first]))[:, None]
    joints, codes = joints_m.copy(), state.copy()
    start, end = joints_m[first, person, joint], joints_m[last, person, joint]
    joints[frame, person, joint] = start + share * (end - start)
    codes[frame, person, joint] = np.minimum(state[first, person, joint], state[last, person, joint])
    return joints, codes


def _nearest_known(known: BoolArray) -> tuple[IntArray, IntArray]:
    """The last frame up to each that knows a joint, -1 without one, and the first from it on, T without one."""
    frames = np.arange(len(known)).reshape(-1, *(1,) * (known.ndim - 1))
    before = np.maximum.accumulate(np.where(known, frames, -1), axis=0)
    after = np.minimum.accumulate(np.where(known, frames, len(known))[::-1], axis=0)[::-1]
    return before, after


def gaussian_smooth(t_s: Array, joints_m: Array, width_s: float) -> Array:
    """Weighted means of the frames around each: a bell whose standard deviation is a quarter of its width.

    Args:
        t_s: (T,) rising times of the frames [s].
        joints_m: (T, P, J, 3) joints, NaN where unknown [m].
        width_s: frames within half of it on either side count; 0 smooths nothing.

    Returns:
        (T, P, J, 3) joints, NaN where they were: unknown joints neither count nor become known.
    """
    if not width_s > 0.0 or not len(t_s):
        return joints_m
    known = np.isfinite(joints_m)
    plain = np.where(known, joints_m, 0.0)
    total, weight = plain.copy(), known.astype(np.float64)
    for back in range(1, len(t_s)):
        apart_s = t_s[back:] - t_s[:-back]
        near = np.where(apart_s <= 0.5 * width_s + _ROUNDING_S, np.exp(-0.5 * (4.0 * apart_s / width_s) ** 2), 0.0)
        if not near.any():
            break
        bell: NDArray[Any] = near[:, None, None, None]
        total[back:] += bell * plain[:-back]
        total[:-back] += bell * plain[back:]
        weight[back:] += bell * known[:-back]
        weight[:-back] += bell * known[back:]
    return np.where(known, total / np.where(known, weight, 1.0), np.nan)
