"""Short dropouts and implausible detections of joints: which joints count as seen in a frame.

Joints that lose their votes for a moment stay seen, and hands that touch for longer, because they hide each other's
surface. Joints that leap do not count: what was at one place a moment ago and is found at a distant one is hidden, and
something else looks like it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...core import NOT_TRACKED, TRACKED, Array
from ...core.compiled import compiled_entry, compiled_inner
from .joint_groups import ELBOWS, HAND_JOINTS, SPINE_MID
from .point_kernels import closer_than
from .posture_prior import JointMask

TOUCH_M = 0.16
"""Hands that are seen closer than this hide each other (assumed)."""

TOUCH_HOLD_S = 0.4
"""How long hands that touch count as seen without votes (assumed)."""

MAX_BESIDE_M = 0.17
"""Hands do not meet farther than this beside the trunk's middle: both are the hand of that side (assumed)."""

APPROACH_M = 0.22
"""Tracked hands closer than this are about to touch (assumed)."""

CLOSING_RATIO = 0.7
"""Share of the distance between two approaching hands that remains one frame later (assumed)."""

NO_VOTE_HOLD_S = 0.08
"""How long a tracked joint counts as seen without a vote (assumed)."""

FEW_VOTES_HOLD_S = 0.15
"""How long a tracked joint counts as seen with too few votes (assumed)."""

HOLD_M = 0.15
"""Both hold only while the joint is found this near to its prediction (assumed)."""

LEAP_S = 0.12
"""How long a joint that leaps does not count (assumed)."""

LEAP_M = 0.25
"""A joint that is found farther than this from its prediction leaps (assumed)."""

ELBOW_WRIST_M = 0.34
"""Longest distance of a wrist from its elbow over scale: a quarter more than a forearm (assumed)."""

ELBOW_HAND_M = 0.42
"""Longest distance of a hand from its elbow over scale (assumed)."""

WRIST_HAND_M = 0.16
"""Longest distance of a hand from its wrist over scale: twice half a hand (assumed)."""

_WRIST = 0
"""Row of `HAND_JOINTS` with the wrists."""

_HAND = 1
"""Row of `HAND_JOINTS` with the hands."""


@compiled_inner
def _reject_impossible_hands(joints: Array, before: Array, scale: float, unseen_s: Array, seen: JointMask) -> None:
    """Clear wrists and hands beyond the forearm's reach, and one held without votes away from the other.

    Args:
        joints: (25, 3) joints by the votes [m].
        before: (25, 3) predicted joints [m].
        scale: stature over 1.75 m.
        unseen_s: (25,) how long joints have lacked votes.
        seen: (25,) changed in place.
    """
    for side in range(2):
        wrist = HAND_JOINTS[_WRIST, side]
        hand = HAND_JOINTS[_HAND, side]
        elbow = joints[ELBOWS[side]] if seen[ELBOWS[side]] else before[ELBOWS[side]]
        if not math.isnan(elbow[0]):
            if seen[wrist] and not closer_than(joints[wrist], elbow, ELBOW_WRIST_M * scale):
                seen[wrist] = False
            if seen[hand] and not closer_than(joints[hand], elbow, ELBOW_HAND_M * scale):
                seen[hand] = False

        held = wrist if unseen_s[wrist] > unseen_s[hand] else hand
        one_is_held = seen[wrist] and seen[hand] and unseen_s[held] > 0.0
        if one_is_held and not closer_than(joints[wrist], joints[hand], WRIST_HAND_M * scale):
            seen[held] = False


@compiled_entry
def bridge_dropouts(
    joints: Array, before: Array, state: NDArray[np.int8], weak: JointMask, yaw_rad: float, scale: float,
    interval_s: float, unseen_s: Array, seen: JointMask,
) -> None:  # fmt: skip
    """Decide which joints of a person count as seen.

    Args:
        joints: (25, 3) joints by the votes [m]; a hand hidden by the other one is moved beside it.
        before: (25, 3) predicted joints [m].
        state: (25,) states at the last frame.
        weak: (25,) joints with a vote at all; changed in place.
        yaw_rad: yaw relative to facing the sensor.
        scale: stature over 1.75 m.
        interval_s: time since the last frame.
        unseen_s: (25,) how long joints have lacked support; updated.
        seen: (25,) joints with sufficient support; changed in place.
    """
    cos = math.cos(yaw_rad)
    sin = math.sin(yaw_rad)
    hold_s = np.zeros(len(seen))
    twin = np.zeros(len(seen), np.int64)
    for j in range(len(seen)):
        hold_s[j] = NO_VOTE_HOLD_S
        twin[j] = -1  # no other hand hides this joint

    # Hands that touch, or are about to.
    for pair in range(len(HAND_JOINTS)):
        left = HAND_JOINTS[pair, 0]
        right = HAND_JOINTS[pair, 1]
        both_tracked = state[left] == TRACKED and state[right] == TRACKED
        touch = closer_than(joints[left], joints[right], TOUCH_M)
        middle_x = 0.5 * (joints[left, 0] + joints[right, 0]) - before[SPINE_MID, 0]
        middle_z = 0.5 * (joints[left, 2] + joints[right, 2]) - before[SPINE_MID, 2]
        beside_m = sin * middle_z - cos * middle_x
        if abs(beside_m) > MAX_BESIDE_M and touch:
            other = right if beside_m > 0.0 else left
            seen[other] = False
            weak[other] = False
        elif touch or (both_tracked and closer_than(before[left], before[right], APPROACH_M)):
            hold_s[left] = TOUCH_HOLD_S
            hold_s[right] = TOUCH_HOLD_S
            twin[left] = right
            twin[right] = left

    for j in range(len(seen)):
        # After `LEAP_S` at a distant place the joint counts again: then the prediction is wrong.
        known = unseen_s[j] < LEAP_S and state[j] != NOT_TRACKED
        if seen[j] and known and not closer_than(joints[j], before[j], LEAP_M):
            seen[j] = False
        unseen_s[j] = 0.0 if seen[j] else unseen_s[j] + interval_s

    for j in range(len(seen)):
        if seen[j] or state[j] != TRACKED or unseen_s[j] >= max(hold_s[j], FEW_VOTES_HOLD_S * weak[j]):
            continue
        if closer_than(joints[j], before[j], HOLD_M):
            seen[j] = True
        elif twin[j] >= 0 and unseen_s[twin[j]] == 0.0:
            # A hidden hand follows the one that hides it.
            other = twin[j]
            for c in range(3):
                joints[j, c] = joints[other, c] + CLOSING_RATIO * (before[j, c] - before[other, c])
            seen[j] = True
    _reject_impossible_hands(joints, before, scale, unseen_s, seen)
