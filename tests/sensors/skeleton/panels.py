"""Depth images of a floor with upright panels, which stand for persons and robots."""

from __future__ import annotations

import math

import numpy as np

from sjasim.assets.names import JOINTS
from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton import segmentation
from sjasim.sensors.skeleton.foreground import Foreground, extract_foreground

INTRINSICS = Intrinsics.from_field_of_view(256, math.radians(70.6), math.radians(60.0))
HEIGHT_M = 0.91
PER_PIXEL = 1.0 / (INTRINSICS.fx * INTRINSICS.fy)
NO_OBJECT = np.full(2, np.nan)

Panel = tuple[float, float, float, float]
"""x, z, width and height of the upper edge [m]; the lower edge is .05 m above the floor."""


def depth_image(*panels: Panel) -> np.ndarray:
    """Return the depth image of a floor and panels."""
    row, column = np.mgrid[: INTRINSICS.height, : INTRINSICS.width]
    x = (column - (INTRINSICS.width - 1) / 2) / INTRINSICS.fx
    y = ((INTRINSICS.height - 1) / 2 - row) / INTRINSICS.fy
    with np.errstate(divide="ignore"):
        depth = np.where(y < 0, -HEIGHT_M / y, np.inf)
    depth[depth > 4.5] = 0.0

    for panel_x, z, width, top in sorted(panels, key=lambda panel: -panel[1]):
        above = HEIGHT_M + y * z
        depth[(np.abs(x * z - panel_x) < width / 2) & (above > 0.05) & (above < top)] = z
    return np.rint(1000 * depth).astype(np.uint16)


def foreground_of(*panels: Panel) -> Foreground:
    """Return the points of panels above the floor."""
    foreground = Foreground.allocate(INTRINSICS)
    extract_foreground(depth_image(*panels), INTRINSICS, HEIGHT_M, foreground)
    return foreground


def assign(
    foreground: Foreground, positions: list[tuple[float, float]], low: np.ndarray = NO_OBJECT
) -> np.ndarray:  # fmt: skip
    """Assign the points to persons whose joints are all above their position, and return the owners."""
    joints = np.zeros((len(positions), len(JOINTS), 3))
    joints[:, :, 1] = np.linspace(0.1, 1.7, len(JOINTS))
    joints[:, :, [0, 2]] = np.array(positions).reshape(-1, 1, 2)
    segmentation.assign_owners(foreground, np.array(positions).reshape(-1, 2), joints, low)
    return foreground.owner[: foreground.count]
