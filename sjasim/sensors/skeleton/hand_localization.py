"""Hands by their own surface, where the leaves' votes are few or muddled.

A hand shows few pixels, so few votes; hands that meet show each half of themselves, and either looks like the other.
But what lies well before the trunk is an arm's. So a hand is in sight if there is surface about the place where votes
or the last frames have it, and hands that are close are told apart by the points that are nearer to the one or the
other, as they were a frame ago.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ...core import Array
from ...core.memory import put
from ..depth_camera import Intrinsics
from .person_tracking import HAND_JOINTS, closer_than
from .posture_prior import JointMask
from .segmentation import Foreground, Image, Owners, Points

AHEAD_M = 0.15
"""So far before the trunk, surface is an arm's (assumed)."""
ABOUT_M, LEAST_M2 = 0.06, 0.002
"""So much surface within this distance of a hand's joint is the hand's: 40 % of a fist's (assumed)."""
SAME_M = 0.15
"""Few votes that are farther from where the hand is expected found another surface (measured: nine in ten of those
nearer are right to 6 cm)."""
PART_M, MET_M = 0.24, 0.05
"""Hands between so close and so close are told apart by their points; closer ones show a single surface (assumed)."""
MINE_M, STEPS, LEAST_POINTS = 0.07, 2, 3
"""Points so near a hand may be its own; how often they are shared out, and the fewest that are a hand (assumed)."""
DEEP_M = 0.03
"""A hand's middle is so far behind that of its visible surface (assumed)."""

ImageProjection = tuple[float, float, float, float, float]
"""Focal lengths and middle in pixels of `segmentation.Foreground.image`, and the sensor's height [m]."""
PALMS = HAND_JOINTS[1]
"""(2,) left and right."""


def image_projection(intrinsics: Intrinsics, height_m: float) -> ImageProjection:
    """How points meet the pixels of a scene's image, which has a rim."""
    middle_u, middle_v = (intrinsics.width + 1) / 2.0, (intrinsics.height + 1) / 2.0
    return intrinsics.fx, intrinsics.fy, middle_u, middle_v, height_m


@njit(cache=True, error_model="numpy")
def visible_surface_m2(image: Image, image_projection: ImageProjection, place: Array, about_m: float) -> float:
    """How much surface there is within a distance of a point (3,) [m^2]; 0 for a point out of the picture."""
    fx, fy, middle_u, middle_v, height_m = image_projection
    x, y, z = place[0], place[1] - height_m, place[2]
    if not z > about_m:
        return 0.0
    u, v, wide, high = middle_u + fx * x / z, middle_v - fy * y / z, fx * about_m / z, fy * about_m / z
    count = 0
    for row in range(max(math.ceil(v - high), 1), min(math.floor(v + high), image.shape[0] - 2) + 1):
        for column in range(max(math.ceil(u - wide), 1), min(math.floor(u + wide), image.shape[1] - 2) + 1):
            depth = 0.001 * image[row, column]
            across, up = (column - middle_u) / fx * depth - x, (middle_v - row) / fy * depth - y
            count += across * across + up * up + (depth - z) ** 2 < about_m * about_m
    return float(count * z * z / (fx * fy))


@njit(cache=True, error_model="numpy")
def _share(point: Points, owner: Owners, who: int, ahead_m: float, reach_m: float, fists: Array) -> bool:
    """Move two places (2, 3) on a person's surface to the middles of the points nearer to the one or the other."""
    sums, many = np.zeros((2, 3)), np.zeros(2)
    for i in range(len(point)):
        if owner[i] != who or point[i, 2] > ahead_m:
            continue
        best, mine = reach_m * reach_m, -1
        for f in range(2):
            x, y, z = point[i, 0] - fists[f, 0], point[i, 1] - fists[f, 1], point[i, 2] - fists[f, 2]
            square = x * x + y * y + z * z
            if square < best:
                best, mine = square, f
        if mine >= 0:
            many[mine] += 1.0
            for c in range(3):
                sums[mine, c] += point[i, c]
    if many.min() < LEAST_POINTS:
        return False
    for f in range(2):
        put(fists[f], sums[f] / many[f])
    return True


@njit(cache=True, error_model="numpy")
def _part(
    point: Points, owner: Owners, who: int, ahead_m: float, scale: float, prior: Array, joints: Array
) -> None:  # fmt: skip
    """Tell a person's hands apart that are close and have not met."""
    left, right = prior[PALMS[0]], prior[PALMS[1]]
    if not closer_than(left, right, PART_M * scale) or closer_than(left, right, MET_M * scale):
        return
    if left[2] > ahead_m or right[2] > ahead_m:
        return
    fists = prior[PALMS]
    for f in range(2):
        fists[f, 2] -= DEEP_M * scale
    for _ in range(STEPS):
        if not _share(point, owner, who, ahead_m, MINE_M * scale, fists):
            return
    for f in range(2):
        put(joints[PALMS[f]], fists[f])
        joints[PALMS[f], 2] += DEEP_M * scale


@njit(cache=True, error_model="numpy")
def _settle(
    image: Image, image_projection: ImageProjection, point: Points, owner: Owners, trunk_m: Array, scales: Array, prior: Array, joints: Array,
    seen: JointMask,
) -> None:  # fmt: skip
    for k in range(len(joints)):
        scale, ahead_m = scales[k], trunk_m[k] - AHEAD_M * scales[k]
        _part(point, owner, k, ahead_m, scale, prior[k], joints[k])
        for j in HAND_JOINTS.ravel():
            if not seen[k, j] and joints[k, j, 2] < ahead_m and closer_than(joints[k, j], prior[k, j], SAME_M * scale):
                seen[k, j] = (
                    visible_surface_m2(image, image_projection, joints[k, j], ABOUT_M * scale)
                    > LEAST_M2 * scale * scale
                )


def localize_hands(
    scene: Foreground,
    image_projection: ImageProjection,
    trunk_m: Array,
    scales: Array,
    prior: Array,
    joints: Array,
    seen: JointMask,
) -> None:
    """Correct the hands of all persons by their surface.

    Args:
        scene: with owners.
        lens: of the scene's image.
        trunk_m: (P,) depths of the trunks.
        scales: (P,) statures over 1.75 m.
        prior: (P, 25, 3) predicted joints, NaN where nothing is known [m].
        joints: (P, 25, 3) where votes agree; those of hands that are close are changed [m].
        seen: (P, 25) which joints are supported; those of hands that show surface are added.
    """
    points = slice(scene.count)
    _settle(
        scene.image, image_projection, scene.point[points], scene.owner[points], trunk_m, scales, prior, joints, seen
    )
