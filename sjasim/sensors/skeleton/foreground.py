"""Foreground of a depth image: the points above the floor.

Points are (x, height, z): to the sensor's left, above the floor, away from the sensor. The sensor is assumed to be
level at a known height, as the Kinect's own estimate of the floor plane would tell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.compiled import compiled_entry
from ..depth_camera import Intrinsics

Points = NDArray[np.float32]
Image = NDArray[np.int16]
Pixels = NDArray[np.int32]
Owners = NDArray[np.int8]

FLOOR_M = 0.04
"""Points below this height are floor: some five standard deviations of the floor's noise at 4 m (assumed)."""

MAX_DEPTH_MM = 8000
"""Largest depth in the image; also the depth of pixels without one."""

UNASSIGNED = -1
"""Owner of a point that belongs to no person and not to the low object."""

LOW_OBJECT = -2
"""Owner of a point of the low object, such as a robot."""


@dataclass(slots=True)
class Foreground:
    """Points above the floor in one frame. Only the first ``count`` rows are valid; the arrays are reused.

    Attributes:
        image: (H + 2, W + 2) depth with a border of one pixel; `MAX_DEPTH_MM` in the border and where there is no
            depth [mm].
        pixel: (N, 2) row and column.
        point: (N, 3) points [m].
        owner: (N,) row of the person, `UNASSIGNED` or `LOW_OBJECT`.
        count: number of valid rows.
    """

    image: Image
    pixel: Pixels
    point: Points
    owner: Owners
    count: int = 0

    @classmethod
    def allocate(cls, intrinsics: Intrinsics) -> Foreground:
        """Return empty arrays for images of this size."""
        shape = (intrinsics.height + 2, intrinsics.width + 2)
        size = intrinsics.height * intrinsics.width
        return cls(
            image=np.full(shape, MAX_DEPTH_MM, np.int16),
            pixel=np.zeros((size, 2), np.int32),
            point=np.zeros((size, 3), np.float32),
            owner=np.zeros(size, np.int8),
        )


@compiled_entry
def _extract(
    depth: NDArray[np.uint16], fx: float, fy: float, height_m: float, image: Image, pixel: Pixels, point: Points
) -> int:
    """Write ``image``, ``pixel`` and ``point``; return the number of points. See `extract_foreground`."""
    height, width = depth.shape
    middle_u = (width - 1) / 2
    middle_v = (height - 1) / 2
    n = 0
    for v in range(height):
        slope = (middle_v - v) / fy
        for u in range(width):
            if depth[v, u] == 0:
                image[v + 1, u + 1] = MAX_DEPTH_MM
                continue

            z = np.float32(depth[v, u]) * np.float32(0.001)
            image[v + 1, u + 1] = min(depth[v, u], MAX_DEPTH_MM)

            # The sensor is level, so the height grows in proportion to the depth.
            above = height_m + slope * z
            if above > FLOOR_M:
                pixel[n, 0] = v
                pixel[n, 1] = u
                point[n, 0] = (u - middle_u) / fx * z
                point[n, 1] = above
                point[n, 2] = z
                n += 1
    return n


def extract_foreground(
    depth_mm: NDArray[np.uint16], intrinsics: Intrinsics, height_m: float, out: Foreground
) -> None:  # fmt: skip
    """Extract everything above the floor from a depth image.

    Args:
        depth_mm: (H, W) depth, 0 where there is none.
        intrinsics: pinhole model of the image.
        height_m: height of the sensor above the floor.
        out: written in place, except for the owners.
    """
    out.count = _extract(depth_mm, intrinsics.fx, intrinsics.fy, height_m, out.image, out.pixel, out.point)
