"""Localization of hands by their own surface, where the votes for them are few or ambiguous.

A hand covers few pixels and therefore gets few votes. Hands that meet show only half of themselves each, and either
half looks like the other hand. But surface well in front of the trunk belongs to an arm. So a hand is visible if there
is surface around the place where votes or the last frame have it, and two hands that are close are separated by
assigning each point to the nearer one, starting from where they were in the last frame.
"""

from __future__ import annotations

import math

import numpy as np

from ...core import Array
from ...core.compiled import compiled_entry, compiled_inner
from ..depth_camera import Intrinsics
from .foreground import Foreground, Image, Owners, Points
from .joint_groups import HAND_JOINTS, PALMS
from .point_kernels import closer_than
from .posture_prior import JointMask

AHEAD_M = 0.15
"""Surface that is farther than this in front of the trunk belongs to an arm (assumed)."""

SURFACE_RADIUS_M = 0.06
"""Distance from a hand's joint within which surface belongs to the hand (assumed)."""

MIN_SURFACE_M2 = 0.002
"""Least surface within `SURFACE_RADIUS_M` that shows a hand: 40 % of a fist (assumed)."""

EXPECTED_M = 0.15
"""Few votes that are farther than this from where the hand is expected have found another surface.

Measured: of the nearer ones nine in ten are right to within 6 cm.
"""

MAX_SEPARATION_M = 0.24
"""Hands farther apart than this need no separation by their points (assumed)."""

MIN_SEPARATION_M = 0.05
"""Hands closer than this show a single surface, which cannot be separated (assumed)."""

POINT_RADIUS_M = 0.07
"""Points within this distance of a hand may belong to it (assumed)."""

ITERATIONS = 2
"""How often the points are assigned and the hands moved to their means (assumed)."""

MIN_POINTS = 3
"""Fewest points that make a hand (assumed)."""

HAND_DEPTH_M = 0.03
"""Distance from the middle of a hand's visible surface back to the middle of the hand (assumed)."""

ImageProjection = tuple[float, float, float, float, float]
"""Focal lengths and middle in pixels of `foreground.Foreground.image`, and the sensor's height [m]."""

_HAND_INDICES = HAND_JOINTS.ravel()


def image_projection(intrinsics: Intrinsics, height_m: float) -> ImageProjection:
    """Return how points project into a foreground's image, which has a border of one pixel."""
    middle_u = (intrinsics.width + 1) / 2.0
    middle_v = (intrinsics.height + 1) / 2.0
    return intrinsics.fx, intrinsics.fy, middle_u, middle_v, height_m


@compiled_inner
def visible_surface_m2(image: Image, projection: ImageProjection, point: Array, radius_m: float) -> float:
    """Return the visible surface within a radius of a point (3,) [m^2]; 0 outside of the image or for NaN."""
    fx, fy, middle_u, middle_v, height_m = projection
    x = point[0]
    y = point[1] - height_m
    z = point[2]
    if not z > radius_m:
        return 0.0

    u = middle_u + fx * x / z
    v = middle_v - fy * y / z
    radius_u = fx * radius_m / z
    radius_v = fy * radius_m / z

    count = 0
    for row in range(max(math.ceil(v - radius_v), 1), min(math.floor(v + radius_v), image.shape[0] - 2) + 1):
        for column in range(max(math.ceil(u - radius_u), 1), min(math.floor(u + radius_u), image.shape[1] - 2) + 1):
            depth = 0.001 * image[row, column]
            off_x = (column - middle_u) / fx * depth - x
            off_y = (middle_v - row) / fy * depth - y
            count += off_x * off_x + off_y * off_y + (depth - z) ** 2 < radius_m * radius_m
    return float(count * z * z / (fx * fy))


@compiled_inner
def _move_to_means(
    point: Points, owner: Owners, person: int, ahead_m: float, radius_m: float, hands: Array
) -> bool:  # fmt: skip
    """Move two hands (2, 3) to the means of the points that are nearer to the one or the other.

    Args:
        point: (N, 3) points [m].
        owner: (N,) person of each point.
        person: the person whose points count.
        ahead_m: depth beyond which points belong to the trunk.
        radius_m: largest distance of a point from its hand.
        hands: (2, 3) changed in place [m].

    Returns:
        False if a hand has too few points; nothing is changed then.
    """
    sums = np.zeros((2, 3))
    counts = np.zeros(2)
    for i in range(len(point)):
        if owner[i] != person or point[i, 2] > ahead_m:
            continue

        best = radius_m * radius_m
        nearest = -1
        for side in range(2):
            x = point[i, 0] - hands[side, 0]
            y = point[i, 1] - hands[side, 1]
            z = point[i, 2] - hands[side, 2]
            square = x * x + y * y + z * z
            if square < best:
                best = square
                nearest = side

        if nearest >= 0:
            counts[nearest] += 1.0
            for c in range(3):
                sums[nearest, c] += point[i, c]

    # One hand hides the other: there is nothing to separate.
    if min(counts[0], counts[1]) < MIN_POINTS:
        return False
    for side in range(2):
        for c in range(3):
            hands[side, c] = sums[side, c] / counts[side]
    return True


@compiled_inner
def _separate_hands(
    point: Points, owner: Owners, person: int, ahead_m: float, scale: float, prior: Array, joints: Array
) -> None:  # fmt: skip
    """Move a person's hands (25, 3) to their own surfaces if they are close but do not touch.

    Nothing is changed if either hand lacks points.
    """
    left = prior[PALMS[0]]
    right = prior[PALMS[1]]
    if not closer_than(left, right, MAX_SEPARATION_M * scale) or closer_than(left, right, MIN_SEPARATION_M * scale):
        return
    if left[2] > ahead_m or right[2] > ahead_m:
        return

    hands = np.zeros((2, 3))
    for side in range(2):
        for c in range(3):
            hands[side, c] = prior[PALMS[side], c]
        hands[side, 2] -= HAND_DEPTH_M * scale

    # 2-means clustering that starts from the predicted hands.
    for _ in range(ITERATIONS):
        if not _move_to_means(point, owner, person, ahead_m, POINT_RADIUS_M * scale, hands):
            return

    for side in range(2):
        for c in range(3):
            joints[PALMS[side], c] = hands[side, c]
        joints[PALMS[side], 2] += HAND_DEPTH_M * scale


@compiled_entry
def _localize(
    image: Image, projection: ImageProjection, point: Points, owner: Owners, trunk_m: Array, scales: Array,
    prior: Array, joints: Array, seen: JointMask,
) -> None:  # fmt: skip
    """Write ``joints`` and ``seen``; see `localize_hands`."""
    for k in range(len(joints)):
        scale = scales[k]
        # Only surface well in front of the trunk can be a hand's.
        ahead_m = trunk_m[k] - AHEAD_M * scales[k]
        _separate_hands(point, owner, k, ahead_m, scale, prior[k], joints[k])

        for j in _HAND_INDICES:
            candidate = not seen[k, j] and joints[k, j, 2] < ahead_m
            if candidate and closer_than(joints[k, j], prior[k, j], EXPECTED_M * scale):
                surface_m2 = visible_surface_m2(image, projection, joints[k, j], SURFACE_RADIUS_M * scale)
                seen[k, j] = surface_m2 > MIN_SURFACE_M2 * scale * scale


def localize_hands(
    foreground: Foreground,
    projection: ImageProjection,
    trunk_m: Array,
    scales: Array,
    prior: Array,
    joints: Array,
    seen: JointMask,
) -> None:
    """Correct the hands of all persons by their surface.

    Args:
        foreground: points with owners.
        projection: of the foreground's image.
        trunk_m: (P,) depths of the trunks.
        scales: (P,) statures over that of the model's person.
        prior: (P, 25, 3) predicted joints, NaN where nothing is known [m].
        joints: (P, 25, 3) joints by the votes [m]; those of hands that are close are changed.
        seen: (P, 25) which joints are supported; those of hands with enough surface are added.
    """
    used = slice(foreground.count)
    _localize(
        foreground.image, projection, foreground.point[used], foreground.owner[used], trunk_m, scales, prior, joints,
        seen,
    )  # fmt: skip
