"""Temporal filter of a person's joints: from their prediction towards where they are found in this frame.

The trunk moves as one, and each of its joints a little on its own; what is smaller than the votes' noise is mostly
noise. A person who stands still is smoothed, and one who begins to walk is followed at once.

Source: casiez2012 (1 Euro filter: a low-pass filter that is slow at rest and fast in motion). Unlike there, the
distance from the prediction sets the gain and not the speed, since walking is predicted.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...core import INFERRED, TRACKED, Array
from ...core.compiled import compiled_entry, compiled_inner
from .joint_groups import HEAD, TRUNK
from .posture_prior import JointMask

HIDDEN_S = 0.10
"""Time constant with which a hidden joint approaches its place in the estimated posture (assumed)."""

REAPPEAR_TRUNK_S = 0.40
"""Time constant with which a trunk joint that reappears approaches where it is found (assumed).

It is long because a trunk that jumped would look like a step.
"""

REAPPEAR_LIMB_S = 0.02
"""The same for a joint of a limb (assumed)."""

REAPPEARED_M = 0.03
"""A joint that reappears is tracked once it is this near to where it is found (assumed)."""

NEGLIGIBLE_M = 0.002
"""Remaining distance below which it is set to zero (assumed)."""

COMMON_S = 0.04
"""Time constant with which the trunk leaves its predicted motion; at constant speed it causes no delay (assumed)."""

SIDEWAYS = 0.75
"""By how much `COMMON_S` grows along the view, as a factor, for a person who stands sideways (assumed).

Such a person gets fewer votes along the view and shows no event there that must be detected early.
"""

OWN_S = 0.30
"""Time constant with which a trunk joint leaves the motion of the whole trunk, which is less noisy (assumed)."""

SPIN_RAD_S = 0.4
"""Turning rate at which `OWN_S` is halved: joints of a turning trunk move relative to each other (assumed)."""

COMMON_M = 0.004
"""Distance along one axis at which the gain of `COMMON_S` has half of its range (assumed)."""

OWN_M = 0.010
"""The same for `OWN_S` (assumed)."""

REST_GAIN = 0.2
"""Share of a gain that remains at the smallest distances (assumed)."""

NEW = -1
"""State of a joint that was not known before this frame."""

_IN_TRUNK = np.zeros(len(JOINTS), dtype=np.bool_)
_IN_TRUNK[TRUNK] = True
_REAPPEARS_SLOWLY = _IN_TRUNK.copy()
_REAPPEARS_SLOWLY[HEAD] = True


@compiled_inner
def _gain(interval_s: float, constant_s: float) -> float:
    """Return the gain of a first-order low-pass filter."""
    return 1.0 - math.exp(-interval_s / constant_s)


@compiled_inner
def _signal_share(distance_m: float, noise_m: float) -> float:
    """Return the share of a gain that a distance gets: `REST_GAIN` for one far below the noise, 1 for a large one."""
    return REST_GAIN + (1.0 - REST_GAIN) * distance_m * distance_m / (distance_m * distance_m + noise_m * noise_m)


@compiled_inner
def _measure_trunk_motion(
    found: Array, seen: JointMask, joints: Array, state: NDArray[np.int8], yaw_rad: float, interval_s: float,
    moved: Array, common: Array,
) -> None:  # fmt: skip
    """Write how far the trunk is found from its prediction, and the part of it by which the trunk is moved.

    Args:
        found: (25, 3) joints by the votes [m].
        seen: (25,) which of them count.
        joints: (25, 3) predicted joints [m].
        state: (25,) states at the last frame.
        yaw_rad: heading relative to facing the sensor.
        interval_s: time since the last frame.
        moved: (3,) output, zeros before: mean distance of the trunk joints that stay tracked [m].
        common: (3,) output: this distance times its gain [m].
    """
    count = 0
    for j in TRUNK:
        if seen[j] and state[j] == TRACKED:
            for c in range(3):
                moved[c] += found[j, c] - joints[j, c]
            count += 1

    for c in range(3):
        moved[c] /= max(count, 1)
        # Along the view (c = 2) a person who stands sideways is smoothed more.
        sideways = SIDEWAYS * math.sin(yaw_rad) ** 2 if c == 2 else 0.0
        common[c] = _gain(interval_s, COMMON_S * (1.0 + sideways)) * _signal_share(moved[c], COMMON_M) * moved[c]


@compiled_inner
def _decay(offset: Array, constant_s: float, interval_s: float) -> float:
    """Let an offset (3,) decay in place, to zero if it is negligible; return its largest component before that [m]."""
    decay = math.exp(-interval_s / constant_s)
    largest_m = 0.0
    for c in range(3):
        offset[c] = offset[c] * decay
        largest_m = max(largest_m, abs(offset[c]))
    if largest_m < NEGLIGIBLE_M:
        for c in range(3):
            offset[c] = 0.0
    return largest_m


@compiled_entry
def filter_joints(
    found: Array, seen: JointMask, posture: Array, yaw_rad: float, spin_rad_s: float, interval_s: float, joints: Array,
    state: NDArray[np.int8], offset: Array,
) -> None:  # fmt: skip
    """Move a person's joints from their predictions to this frame's estimates.

    Args:
        found: (25, 3) joints by the votes [m].
        seen: (25,) which of them count.
        posture: (25, 3) joints by the estimated posture as a whole [m].
        yaw_rad: heading relative to facing the sensor.
        spin_rad_s: its rate.
        interval_s: time since the last frame.
        joints: (25, 3) predicted joints [m]; replaced by the estimates.
        state: (25,) states at the last frame; replaced by those at this frame.
        offset: (25, 3) how far a joint that reappeared still is from where it is found [m]; updated.
    """
    for j in range(len(joints)):
        if math.isnan(joints[j, 0]):
            for c in range(3):
                joints[j, c] = posture[j, c]
            state[j] = NEW

    moved = np.zeros(3)
    common = np.zeros(3)
    _measure_trunk_motion(found, seen, joints, state, yaw_rad, interval_s, moved, common)

    own_gain = _gain(interval_s, OWN_S / (1.0 + (spin_rad_s / SPIN_RAD_S) ** 2))
    hidden_gain = _gain(interval_s, HIDDEN_S)
    before = np.zeros(3)
    for j in range(len(joints)):
        for c in range(3):
            before[c] = joints[j, c]

        if not seen[j]:
            for c in range(3):
                offset[j, c] = 0.0
                joints[j, c] = before[c] + moved[c] + hidden_gain * (posture[j, c] - before[c] - moved[c])
            state[j] = INFERRED
            continue

        # A joint that reappears keeps its place and approaches the found one step by step.
        settled = offset[j, 0] == 0.0 and offset[j, 1] == 0.0 and offset[j, 2] == 0.0
        if state[j] < TRACKED and state[j] != NEW and settled:
            for c in range(3):
                offset[j, c] = before[c] + moved[c] - found[j, c]
        remaining_m = _decay(offset[j], REAPPEAR_TRUNK_S if _REAPPEARS_SLOWLY[j] else REAPPEAR_LIMB_S, interval_s)

        for c in range(3):
            here = found[j, c] + offset[j, c]
            # What a trunk joint does beyond the common motion is mostly noise.
            if state[j] == TRACKED and _IN_TRUNK[j]:
                along = before[c] + common[c]
                here = along + own_gain * _signal_share(here - along, OWN_M) * (here - along)
            joints[j, c] = here
        state[j] = TRACKED if remaining_m < REAPPEARED_M else INFERRED
