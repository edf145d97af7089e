"""Where hidden hands cannot be: where the depth image looks through.

Remembered postures tell where a hidden hand most likely is. Those whose hand would hang in the open, before something
farther or before nothing within the sensor's range, are not believed: what is hidden is behind something nearer.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ...core import Array
from .hand_localization import PALMS, ImageProjection
from .segmentation import Image

HALF_HAND_M, BEHIND_M = 0.04, 0.05
"""Half a hand's width, and how far behind its middle the surface in its place is another one (assumed)."""
OPEN = 0.8
"""With more than this share of a hand's pixels beyond it, there is no hand (measured: of hidden hands none, of visible
ones one in a hundred)."""
FREE_SPACE_WEIGHT = 0.001
"""So much is a posture believed that is looked through: another one counts, if there is one (assumed)."""


@njit(cache=True, error_model="numpy")
def is_free_space(image: Image, lens: ImageProjection, x: float, y: float, z: float, half_m: float) -> bool:
    """Whether there is nothing at a point [m] or before it; not so beyond the picture's edge."""
    fx, fy, middle_u, middle_v, height_m = lens
    if not z > half_m:
        return False
    radius = max(1, round(fx * half_m / z))
    u, v = round(middle_u + fx * x / z), round(middle_v - fy * (y - height_m) / z)
    if u - radius < 1 or v - radius < 1 or u + radius > image.shape[1] - 2 or v + radius > image.shape[0] - 2:
        return False
    beyond, limit_mm = 0, 1000.0 * (z + BEHIND_M)
    for row in range(v - radius, v + radius + 1):
        for column in range(u - radius, u + radius + 1):
            beyond += image[row, column] > limit_mm
    return bool(beyond > OPEN * (2 * radius + 1) ** 2)


@njit(cache=True, error_model="numpy")
def posture_likelihood(
    image: Image, lens: ImageProjection, place: Array, yaw_rad: float, scale: float, memory: Array, mean: Array
) -> Array:  # fmt: skip
    """How far remembered postures are believed.

    Args:
        image: of the scene.
        lens: the image's.
        place: (2,) x and z that the postures stand at [m].
        yaw_rad: heading relative to facing the sensor.
        scale: stature over 1.75 m.
        memory: (N, 75) postures, less their mean, over the scale [m].
        mean: (25, 3) mean posture [m].

    Returns:
        (N, 2) for the left and the right hand: `DOUBT` where the image looks through it, else 1.
    """
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    out = np.ones((len(memory), 2))
    for n in range(len(memory)):
        for side in range(2):
            j = PALMS[side]
            forward, left = scale * (memory[n, 3 * j] + mean[j, 0]), scale * (memory[n, 3 * j + 2] + mean[j, 2])
            up = scale * (memory[n, 3 * j + 1] + mean[j, 1])
            x, z = place[0] - sin * forward - cos * left, place[1] - cos * forward + sin * left
            if is_free_space(image, lens, x, up, z, HALF_HAND_M * scale):
                out[n, side] = FREE_SPACE_WEIGHT
    return out
