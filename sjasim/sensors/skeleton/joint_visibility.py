"""Visibility of joints: whether a depth image shows a person's own surface where a joint is estimated.

Two cases need this check. A limb on the far side of a person who stands sideways shows few pixels, too few to vote,
although the estimated posture puts it in the right place. And votes may agree on a limb that something occludes, or
that has left. The image tells them apart: there is surface at the joint or just in front of it, or something else
covers it, or there is free space. Trunk joints may be occluded as well: the rest of the body tells where they are, but
not to the centimetre by which people seem to move.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core import Array
from ...core.compiled import compiled_entry, compiled_inner
from ..depth_camera import Intrinsics
from .foreground import Image
from .joint_groups import LIMBS, TRUNK

SEARCH_RADIUS_M = 0.065
"""Radius around a joint in which its surface is searched: the error of a good estimate (assumed)."""

CORE_RADIUS_M = 0.02
"""Radius around a joint in which a covering surface occludes it (assumed)."""

BEFORE_M = 0.12
"""Surface up to this far in front of a joint may be the joint's own (assumed)."""

BEHIND_M = 0.03
"""Surface up to this far behind a joint may be the joint's own (assumed)."""

MIN_OWN_SHARE = 0.03
"""Share of the pixels that must show own surface for a joint to be visible.

Measured: of joints without enough votes but with this share, 99 in 100 of the visible ones are within 15 cm; of joints
with votes but no such surface, two in three are wrong.
"""

MAX_COVERED_SHARE = 0.8
"""A joint of whose core more than this share is covered is occluded (measured: 98 in 100 of those are)."""

ARM_REACH_M = 0.40
"""What is farther than this in front of a trunk joint belongs to somebody else: no own arm reaches there (assumed)."""

OCCLUDED = -1
"""Result for a joint that is occluded, or at which the image shows free space."""

UNDECIDED = 0
"""Result for a joint whose visibility the image does not determine."""

VISIBLE = 1
"""Result for a joint at which the image shows a surface of the person."""


@compiled_inner
def _classify_limb(
    image: Image, u: int, v: int, radius: int, core: int, near_mm: float, far_mm: float
) -> int:  # fmt: skip
    """Return the verdict on a limb's joint from the pixels around it.

    Args:
        image: (H + 2, W + 2) depth with a border [mm].
        u: the joint's column, without the border.
        v: the joint's row, without the border.
        radius: radius of the tested pixels.
        core: radius of the pixels that must not be covered.
        near_mm: nearest depth of own surface.
        far_mm: farthest depth of own surface.
    """
    rows = image.shape[0] - 2
    columns = image.shape[1] - 2
    pixels = 0
    own = 0
    core_pixels = 0
    covered = 0
    for row in range(max(v - radius, 0), min(v + radius + 1, rows)):
        for column in range(max(u - radius, 0), min(u + radius + 1, columns)):
            square = (column - u) ** 2 + (row - v) ** 2
            if square > radius * radius:
                continue
            depth = image[row + 1, column + 1]
            pixels += 1
            own += near_mm <= depth < far_mm
            if square <= core * core:
                core_pixels += 1
                covered += depth < near_mm

    if own == 0 or covered > MAX_COVERED_SHARE * core_pixels:
        return OCCLUDED
    return VISIBLE if own > MIN_OWN_SHARE * pixels else UNDECIDED


@compiled_entry
def _classify(
    image: Image, fx: float, fy: float, height_m: float, joints: Array, scales: Array, out: NDArray[np.int8]
) -> None:  # fmt: skip
    """Write ``out``, which holds zeros before; see `joint_visibility`."""
    middle_v = (image.shape[0] - 3) / 2
    middle_u = (image.shape[1] - 3) / 2
    for k in range(len(joints)):
        for j in LIMBS:
            x = joints[k, j, 0]
            y = joints[k, j, 1]
            z = joints[k, j, 2]
            if not z > 0.0:
                continue
            u = round(middle_u + fx * x / z)
            v = round(middle_v - fy * (y - height_m) / z)

            # Radii and depths that belong to a joint grow with the person.
            per_m = scales[k] * fx / z
            near_mm = 1000.0 * (z - BEFORE_M * scales[k])
            far_mm = 1000.0 * (z + BEHIND_M * scales[k])
            radius = round(SEARCH_RADIUS_M * per_m)
            core = round(CORE_RADIUS_M * per_m)
            out[k, j] = _classify_limb(image, u, v, radius, core, near_mm, far_mm)

        for j in TRUNK:
            x = joints[k, j, 0]
            y = joints[k, j, 1]
            z = joints[k, j, 2]
            if not z > 0.0:
                continue
            u = round(middle_u + fx * x / z)
            v = round(middle_v - fy * (y - height_m) / z)
            in_image = 0 <= u <= 2.0 * middle_u and 0 <= v <= 2.0 * middle_v
            if in_image and image[v + 1, u + 1] < 1000.0 * (z - ARM_REACH_M * scales[k]):
                out[k, j] = OCCLUDED


def joint_visibility(
    image: Image, intrinsics: Intrinsics, height_m: float, joints: Array, scales: Array
) -> NDArray[np.int8]:
    """Return whether joints are visible where they are estimated.

    Args:
        image: (H + 2, W + 2) depth with a border, see `foreground.Foreground` [mm].
        intrinsics: pinhole model of the image.
        height_m: height of the sensor above the floor.
        joints: (P, 25, 3) points [m], NaN where unknown.
        scales: (P,) statures over that of the model's person.

    Returns:
        (P, 25) `VISIBLE` where a limb's joint has surface of its own; `OCCLUDED` where something covers a joint of a
        limb or of the trunk, or where a limb has no surface; `UNDECIDED` elsewhere.
    """
    out = np.zeros(joints.shape[:2], np.int8)
    _classify(image, intrinsics.fx, intrinsics.fy, height_m, joints, scales, out)
    return out
