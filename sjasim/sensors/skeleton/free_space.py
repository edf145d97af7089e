"""Free space: a hidden hand cannot be where the depth image shows that there is nothing.

Remembered postures tell where a hidden hand most likely is. A posture whose hand would lie in observed free space, in
front of a farther surface or of nothing within the sensor's range, gets a low weight: what is hidden is behind
something nearer.
"""

from __future__ import annotations

import math

import numpy as np

from ...core import Array
from ...core.compiled import compiled_entry, compiled_inner
from .foreground import Image
from .hand_localization import ImageProjection
from .joint_groups import PALMS

HALF_HAND_M = 0.04
"""Half the width of a hand (assumed)."""

BEHIND_M = 0.05
"""Surface that is farther than this behind the middle of a hand belongs to something else (assumed)."""

FREE_SHARE = 0.8
"""Share of a hand's pixels that show a farther surface, above which there is no hand.

Measured: no hidden hand and one visible hand in a hundred exceeds it.
"""

FREE_SPACE_WEIGHT = 0.001
"""Weight of a posture whose hand would lie in free space: it counts only if all others do so, too (assumed)."""


@compiled_inner
def is_free_space(image: Image, projection: ImageProjection, x: float, y: float, z: float, half_m: float) -> bool:
    """Return whether the image shows a farther surface, or nothing, around a point.

    Args:
        image: (H + 2, W + 2) depth with a border [mm].
        projection: of this image.
        x: of the point, like the next two [m].
        y: its height above the floor.
        z: its depth.
        half_m: half the edge of the square of pixels that is tested.

    Returns:
        False as well for a square that is not wholly inside the image.
    """
    fx, fy, middle_u, middle_v, height_m = projection
    if not z > half_m:
        return False

    radius = max(1, round(fx * half_m / z))
    u = round(middle_u + fx * x / z)
    v = round(middle_v - fy * (y - height_m) / z)
    if u - radius < 1 or v - radius < 1 or u + radius > image.shape[1] - 2 or v + radius > image.shape[0] - 2:
        return False

    # Of a hand that is there, few pixels beside its outline show what is behind it.
    farther = 0
    limit_mm = 1000.0 * (z + BEHIND_M)
    for row in range(v - radius, v + radius + 1):
        for column in range(u - radius, u + radius + 1):
            farther += image[row, column] > limit_mm
    return bool(farther > FREE_SHARE * (2 * radius + 1) ** 2)


@compiled_entry
def posture_likelihood(
    image: Image, projection: ImageProjection, position: Array, yaw_rad: float, scale: float, memory: Array, mean: Array
) -> Array:  # fmt: skip
    """Return the weights of remembered postures by where they put a person's hands.

    Args:
        image: (H + 2, W + 2) depth with a border [mm].
        projection: of this image.
        position: (2,) x and z at which the postures stand [m].
        yaw_rad: heading relative to facing the sensor.
        scale: stature over that of the model's person.
        memory: (N, 75) postures over the scale, less the mean posture [m].
        mean: (25, 3) mean posture [m].

    Returns:
        (N, 2) for the left and the right hand: `FREE_SPACE_WEIGHT` if the hand lies in free space, else 1.
    """
    cos = math.cos(yaw_rad)
    sin = math.sin(yaw_rad)
    out = np.zeros((len(memory), 2))
    for n in range(len(memory)):
        for side in range(2):
            j = PALMS[side]
            forward = scale * (memory[n, 3 * j] + mean[j, 0])
            up = scale * (memory[n, 3 * j + 1] + mean[j, 1])
            left = scale * (memory[n, 3 * j + 2] + mean[j, 2])
            x = position[0] - sin * forward - cos * left
            z = position[1] - cos * forward + sin * left
            free = is_free_space(image, projection, x, up, z, HALF_HAND_M * scale)
            out[n, side] = FREE_SPACE_WEIGHT if free else 1.0
    return out
