"""Whether a depth image shows a limb where it is believed to be.

Who stands sideways shows few pixels of the far limb, too few to vote, although the posture puts it where it is; and
votes may agree on a limb that something hides, or that has left. The image tells: there is flesh about the joint,
just before it, or something else covers it, or the sensor looks through where it should be. Joints of a trunk may be
covered, too: the rest of the body tells where they are, but not to the centimetre by which people seem to move.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...core import Array, IntArray
from ..depth_camera import Intrinsics
from .posture_prior import TRUNK
from .segmentation import Image

LIMBS = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb", "Knee", "Ankle", "Foot")) for name in JOINTS])
"""(25,) which joints are a limb's: thin, so that their own surface is near them whichever way somebody stands."""
AROUND_M, MIDDLE_M = 0.065, 0.02
"""Radius in which a joint's surface is looked for, the error of a good guess; and of what covers the joint itself
(assumed)."""
BEFORE_M, BEHIND_M = 0.12, 0.03
"""Surface up to so far before a joint, and so far behind it, may be its own (assumed)."""
ENOUGH = 0.03
"""Share of the surface that has to be there for a joint to be shown (measured: of joints that lack votes but are
shown, 99 in 100 of those visible are within 15 cm; of joints with votes of which there is nothing, two in three)."""
COVERED = 0.8
"""A joint of whose middle more than this share is covered is hidden (measured: so are 98 in 100 of those)."""
ARMS_M = 0.40
"""What is farther before a joint of the trunk than this is somebody else's: no own arm reaches so far (assumed)."""
OCCLUDED, VISIBLE = -1, 1


@njit(cache=True, error_model="numpy")
def _look(
    image: Image, u: int, v: int, radius: int, middle: int, near_mm: float, far_mm: float
) -> int:  # fmt: skip
    """`HIDDEN`, 0 or `SHOWN`, of what lies around a pixel."""
    rows, columns = image.shape[0] - 2, image.shape[1] - 2
    seen = there = inner = covered = 0
    for b in range(max(v - radius, 0), min(v + radius + 1, rows)):
        for a in range(max(u - radius, 0), min(u + radius + 1, columns)):
            away = (a - u) ** 2 + (b - v) ** 2
            if away > radius * radius:
                continue
            depth = image[b + 1, a + 1]
            seen += 1
            there += near_mm <= depth < far_mm
            if away <= middle * middle:
                inner += 1
                covered += depth < near_mm
    if there == 0 or covered > COVERED * inner:
        return OCCLUDED
    return VISIBLE if there > ENOUGH * seen else 0


@njit(cache=True, error_model="numpy")
def _shown(
    image: Image, fx: float, fy: float, height_m: float, joints: Array, scales: Array, limbs: IntArray,
    trunk: IntArray, out: NDArray[np.int8],
) -> None:  # fmt: skip
    middle_v, middle_u = (image.shape[0] - 3) / 2, (image.shape[1] - 3) / 2
    for k in range(len(joints)):
        for j in limbs:
            x, y, z = joints[k, j]
            if not z > 0.0:
                continue
            u, v = round(middle_u + fx * x / z), round(middle_v - fy * (y - height_m) / z)
            per_m = scales[k] * fx / z
            near_mm, far_mm = 1000.0 * (z - BEFORE_M * scales[k]), 1000.0 * (z + BEHIND_M * scales[k])
            out[k, j] = _look(image, u, v, round(AROUND_M * per_m), round(MIDDLE_M * per_m), near_mm, far_mm)
        for j in trunk:
            x, y, z = joints[k, j]
            if not z > 0.0:
                continue
            u, v = round(middle_u + fx * x / z), round(middle_v - fy * (y - height_m) / z)
            if 0 <= u <= 2.0 * middle_u and 0 <= v <= 2.0 * middle_v:
                out[k, j] = OCCLUDED * (image[v + 1, u + 1] < 1000.0 * (z - ARMS_M * scales[k]))


def joint_visibility(
    image: Image, intrinsics: Intrinsics, height_m: float, joints: Array, scales: Array
) -> NDArray[np.int8]:
    """Whether joints are where they are believed to be.

    Args:
        image: (H + 2, W + 2) depth with a rim, see `segmentation.Foreground` [mm].
        intrinsics: the image's pinhole.
        height_m: of the sensor above the floor.
        joints: (P, 25, 3) points [m].
        scales: (P,) stature over 1.75 m.

    Returns:
        (P, 25) `SHOWN` where surface lies about a limb's joint as its own would, `HIDDEN` where something covers it or
        there is none of it, and where something covers a joint of the trunk; 0 where the image does not tell.
    """
    out = np.zeros(joints.shape[:2], np.int8)
    _shown(image, intrinsics.fx, intrinsics.fy, height_m, joints, scales, np.flatnonzero(LIMBS), TRUNK, out)
    return out
