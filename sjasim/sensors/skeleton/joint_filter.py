"""A person's joints from one frame to the next: how far each goes from its prediction to where it is seen.

The trunk moves as one, and each of its joints a little on its own; what is shorter than the votes' noise is mostly
that. Who stands still is smoothed, and who begins to walk is followed at once.

Source: casiez2012 (a low-pass filter that is slow at rest and fast in motion); unlike there, the way to go decides,
not the speed, since walks are predicted.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...assets.names import JOINT_INDEX, JOINTS
from ...core import INFERRED, TRACKED, Array
from ...core.memory import put
from .posture_prior import TRUNK, JointMask

RELAX_S = 0.10
"""Time constant with which a hidden joint goes where the rest of the posture says (assumed)."""
SETTLE_TRUNK_S, SETTLE_LIMB_S = 0.40, 0.02
"""Time constants with which a joint that comes back into sight goes where it is seen: a trunk that jumped would look
like a step (assumed)."""
SETTLED_M = 0.03
"""A joint that comes back is tracked once it is this near to where it is seen (assumed)."""
CLOSE_M = 0.002
"""Nearer than this, it is there."""
COMMON_S, SIDEWAYS = 0.04, 0.75
"""Time constant with which the trunk leaves its predicted motion; at constant speed this is no delay. Along the view
it is longer by up to so many times for who stands sideways: fewer votes, and no event to be early for (assumed)."""
OWN_S, SPIN_RAD_S = 0.30, 0.4
"""Time constant with which a joint of the trunk leaves the motion that all of the trunk has in common, which shakes
less than each: shorter the faster the person turns, by this rate (assumed)."""
COMMON_M, OWN_M, REST = 0.004, 0.010, 0.2
"""At these ways to go, along one axis, the two time constants count half as much as at long ones; at the shortest,
only this share (assumed)."""
FRESH = -1
"""State of a joint that has just become known."""

_TRUNK = np.zeros(len(JOINTS), dtype=np.bool_)
_TRUNK[[*TRUNK, JOINT_INDEX["Head"]]] = True
_STEADY = np.zeros(len(JOINTS), dtype=np.bool_)
_STEADY[TRUNK] = True


@njit(cache=True)
def _blend(interval_s: float, constant_s: float) -> float:
    return 1.0 - math.exp(-interval_s / constant_s)


@njit(cache=True)
def _sure(off_m: float, noise_m: float) -> float:
    """Share of a gain that a way to go deserves."""
    return REST + (1.0 - REST) * off_m * off_m / (off_m * off_m + noise_m * noise_m)


@njit(cache=True)
def _common(moved: Array, yaw_rad: float, interval_s: float) -> Array:
    """(3,) how far the trunk leaves its predicted motion; ``moved`` is what its joints' mean says of that."""
    common = np.empty(3)
    for c in range(3):
        sideways = SIDEWAYS * math.sin(yaw_rad) ** 2 if c == 2 else 0.0
        common[c] = _blend(interval_s, COMMON_S * (1.0 + sideways)) * _sure(moved[c], COMMON_M) * moved[c]
    return common


@njit(cache=True)
def filter_joints(
    found: Array, seen: JointMask, likely: Array, yaw_rad: float, spin_rad_s: float, interval_s: float, joints: Array,
    state: NDArray[np.int8], carry: Array,
) -> None:  # fmt: skip
    """Move a person's joints on from their predictions.

    Args:
        found: (25, 3) where votes agree [m].
        seen: (25,) which of them count.
        likely: (25, 3) by the posture as a whole [m].
        yaw_rad: heading relative to facing the sensor.
        spin_rad_s: its rate.
        interval_s: since the last frame.
        joints: (25, 3) predicted, and afterwards taken in [m].
        state: (25,) of the last frame, and afterwards of this one.
        carry: (25, 3) what is left of the ways of joints that came back into sight [m].
    """
    for j in range(len(joints)):
        if math.isnan(joints[j, 0]):
            put(joints[j], likely[j])
            state[j] = FRESH
    moved, steady = np.zeros(3), 0
    for j in TRUNK:
        if seen[j] and state[j] == TRACKED:
            moved += found[j] - joints[j]
            steady += 1
    moved /= max(steady, 1)
    common = _common(moved, yaw_rad, interval_s)
    own = _blend(interval_s, OWN_S / (1.0 + (spin_rad_s / SPIN_RAD_S) ** 2))
    relaxed = _blend(interval_s, RELAX_S)
    for j in range(len(joints)):
        before, after = joints[j], joints[j] + moved + relaxed * (likely[j] - joints[j] - moved)
        if not seen[j]:
            carry[j] = 0.0
            put(joints[j], after)
            state[j] = INFERRED
            continue
        if state[j] < TRACKED and state[j] != FRESH and not carry[j].any():
            put(carry[j], before + moved - found[j])
        put(carry[j], carry[j] * math.exp(-interval_s / (SETTLE_TRUNK_S if _TRUNK[j] else SETTLE_LIMB_S)))
        off = np.abs(carry[j]).max()
        if off < CLOSE_M:
            carry[j] = 0.0
        here = found[j] + carry[j]
        if state[j] == TRACKED and _STEADY[j]:
            for c in range(3):
                along = before[c] + common[c]
                here[c] = along + own * _sure(here[c] - along, OWN_M) * (here[c] - along)
        put(joints[j], here)
        state[j] = TRACKED if off < SETTLED_M else INFERRED
