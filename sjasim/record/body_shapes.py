"""Lines and capsules that draw a body from its 25 joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX

Floats = NDArray[np.floating]

_SIDES = ("Left", "Right")
_LIMB_BONES = (
    ("Shoulder", "Elbow"), ("Elbow", "Wrist"), ("Wrist", "Hand"), ("Hand", "HandTip"), ("Wrist", "Thumb"),
    ("Hip", "Knee"), ("Knee", "Ankle"), ("Ankle", "Foot"),
)  # fmt: skip
_LIMB_ROOTS = (("SpineShoulder", "Shoulder"), ("SpineBase", "Hip"))
_LIMB_CAPSULES = (
    ("Knee", "Hip", 0.062), ("Ankle", "Knee", 0.046), ("Elbow", "Shoulder", 0.040), ("Wrist", "Elbow", 0.033),
)  # fmt: skip

BONES = (
    ("SpineBase", "SpineMid"), ("SpineMid", "SpineShoulder"), ("SpineShoulder", "Neck"), ("Neck", "Head"),
    *((a + side, b + side) for side in _SIDES for a, b in _LIMB_BONES),
    *((trunk, limb + side) for side in _SIDES for trunk, limb in _LIMB_ROOTS),
)  # fmt: skip
"""Pairs of joints that the lines of a skeleton connect."""

CAPSULES = (
    ("SpineBase", "SpineMid", 0.115), ("SpineMid", "SpineShoulder", 0.125), ("Neck", "Head", 0.085),
    *((a + side, b + side, radius) for side in _SIDES for a, b, radius in _LIMB_CAPSULES),
)  # fmt: skip
"""Lower joint, upper joint and radius [m] of each capsule of a body."""


def capsule_poses(joints: Floats) -> tuple[Floats, Floats, Floats]:
    """Poses of the `CAPSULES` of a body.

    Args:
        joints: (N, 25, 3) positions of the joints [m].

    Returns:
        (N, C, 3) lower ends [m]; (N, C, 4) quaternions (x, y, z, w) that turn the z axis along each capsule; and (C,)
        lengths in the first frame [m].
    """
    lower = joints[:, [JOINT_INDEX[name] for name, _, _ in CAPSULES]]
    direction = joints[:, [JOINT_INDEX[name] for _, name, _ in CAPSULES]] - lower
    length = np.sqrt((direction**2).sum(axis=-1, keepdims=True))
    direction = direction / np.maximum(length, 1e-6)

    # The shortest rotation from z to a unit vector d is (z x d, 1 + z . d), normalised. The small number keeps it
    # finite for a capsule that points down.
    zero = 0 * direction[..., 0]
    rotation = np.stack([-direction[..., 1], direction[..., 0], zero, 1.0 + direction[..., 2] + 1e-6], axis=-1)
    rotation /= np.sqrt((rotation**2).sum(axis=-1, keepdims=True))
    return lower, rotation.astype(np.float32), length[0, :, 0]
