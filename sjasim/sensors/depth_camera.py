"""A depth camera: rays of a pinhole cast at the stage's primitives, compiled, without OpenGL.

Every geom is only tested against the pixels of a box that holds its image, in its own frame. Depth, geom and angle of
incidence are exact: the same as MuJoCo's rays, some forty times sooner.

Frame of the camera: x to the sensor's left (columns grow with it, as the Kinect mirrors its images), y up (rows grow
downwards), z away from the sensor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..choreography.layout import Mount
from ..core import Array, Geoms, IntArray
from .raycast.primitives import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    PLANE,
    TINY,
    ray_capsule,
    ray_distance,
    surface_normal,
)

NEAR_M = 0.05
"""A geom this near to the image plane is tested against every pixel."""


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A pinhole: size and focal lengths of the image in pixels; the axis goes through its middle.

    Attributes:
        width: columns.
        height: rows.
        fx: focal length over the width of a pixel.
        fy: focal length over the height of a pixel.
    """

    width: int
    height: int
    fx: float
    fy: float

    @classmethod
    def from_field_of_view(cls, width: int, horizontal_fov_rad: float, vertical_fov_rad: float) -> Intrinsics:
        """A Kinect v2's for 512 (512 x 424) or 256 columns (256 x 212); pixels are not quite square."""
        height = width * 424 // 512
        return cls(
            width,
            height,
            width / 2 / math.tan(horizontal_fov_rad / 2),
            height / 2 / math.tan(vertical_fov_rad / 2),
        )


@dataclass(frozen=True, slots=True)
class RenderedDepth:
    """What a camera's rays meet; the camera overwrites it with its next picture.

    Attributes:
        depth_m: (H, W) distance along the optical axis; infinite where there is nothing.
        geom: (H, W) row of `Geoms`, -1 for nothing.
        incidence: (H, W) cosine of the angle between ray and surface normal, 0 where there is nothing.
    """

    depth_m: Array
    geom: NDArray[np.int16]
    incidence: NDArray[np.float32]


@njit(cache=True, error_model="numpy")
def _span(across: float, ahead: float, radius: float, focal: float, middle: float, count: int) -> tuple[int, int]:
    """First and last pixel of a sphere's image along one axis, never too few."""
    if ahead - radius < NEAR_M:
        return (0, -1) if ahead + radius < NEAR_M else (0, count - 1)
    reach = math.sqrt(max(across * across + ahead * ahead - radius * radius, 1e-12))
    low = (across * reach - radius * ahead) / (ahead * reach + radius * across)
    high = (across * reach + radius * ahead) / (ahead * reach - radius * across)
    return max(math.floor(middle + focal * low), 0), min(math.ceil(middle + focal * high), count - 1)


@njit(cache=True, error_model="numpy")
def _floor(
    g: int, at: Array, turn: Array, size: Array, fx: float, fy: float, depth: Array, geom: Array, facing: Array
) -> None:
    """Cast every pixel at a plane; it is seen from its front only, and as far as its size says.

    `rays.primitives.plane` in other words: row by row and without a branch, so that many pixels are cast at once.
    """
    height, width = depth.shape
    middle_u, middle_v, per_x = (width - 1) / 2, (height - 1) / 2, 1.0 / fx
    above = -(turn[0, 2] * at[0] + turn[1, 2] * at[1] + turn[2, 2] * at[2])
    if above < 0.0:
        return
    wide, long = size[0] if size[0] > 0.0 else np.inf, size[1] if size[1] > 0.0 else np.inf
    start_x = turn[0, 0] * at[0] + turn[1, 0] * at[1] + turn[2, 0] * at[2]
    start_y = turn[0, 1] * at[0] + turn[1, 1] * at[1] + turn[2, 1] * at[2]
    slope_x, slope_y, slope_z = turn[0, 0], turn[0, 1], turn[0, 2]
    far, cosine = np.empty(width), np.empty(width)
    for v in range(height):
        y = (middle_v - v) / fy
        row_x, row_y = turn[1, 0] * y + turn[2, 0], turn[1, 1] * y + turn[2, 1]
        row_z, square = turn[1, 2] * y + turn[2, 2], y * y + 1.0
        if row_z - abs(slope_z) * middle_u * per_x > -TINY:
            continue
        for u in range(width):
            x = (u - middle_u) * per_x
            down = slope_z * x + row_z
            t = -above / down
            across, along = abs(t * (slope_x * x + row_x) - start_x), abs(t * (slope_y * x + row_y) - start_y)
            far[u] = t if (down < -TINY) & (across <= wide) & (along <= long) else np.inf
            cosine[u] = -down / math.sqrt(x * x + square)
        for u in range(width):
            if far[u] < depth[v, u]:
                depth[v, u], geom[v, u], facing[v, u] = far[u], g, cosine[u]


@njit(cache=True, error_model="numpy")
def _bounds(
    form: int, at: Array, turn: Array, size: Array, fx: float, fy: float, shape: tuple[int, int]
) -> tuple[int, int, int, int]:
    """First and last column, first and last row of a box that holds the geom's image."""
    height, width = shape
    middle_u, middle_v = (width - 1) / 2, (height - 1) / 2
    half, radius = 0.0, size[0]
    if form in (CAPSULE, CYLINDER):  # a capsule holds the cylinder between its ends
        half = size[1]
    elif form == BOX:
        radius = math.sqrt(size[0] ** 2 + size[1] ** 2 + size[2] ** 2)
    elif form == ELLIPSOID:
        radius = max(size[0], size[1], size[2])
    left, right, top, bottom = width, -1, height, -1
    for end in (-half, half):
        x, y, z = at[0] + end * turn[0, 2], at[1] + end * turn[1, 2], at[2] + end * turn[2, 2]
        first, last = _span(x, z, radius, fx, middle_u, width)
        left, right = min(left, first), max(right, last)
        first, last = _span(-y, z, radius, fy, middle_v, height)
        top, bottom = min(top, first), max(bottom, last)
    return left, right, top, bottom


@njit(cache=True, error_model="numpy")
def cast_rays(
    form: IntArray, size: Array, position: Array, rotation: Array, fx: float, fy: float, depth: Array,
    geom: NDArray[np.int16], facing: NDArray[np.float32],
) -> None:  # fmt: skip
    """Fill a picture.

    Bodies are capsules, which are therefore met without asking for their form at every pixel.

    Args:
        form: (G,) codes.
        size: (G, 3) [m].
        position: (G, 3) in the camera's frame [m].
        rotation: (G, 3, 3) camera from geom.
        fx: focal length over the width of a pixel.
        fy: focal length over the height of a pixel.
        depth: (H, W) output, as in `Picture`.
        geom: (H, W) output.
        facing: (H, W) output.
    """
    height, width = depth.shape
    middle_u, middle_v = (width - 1) / 2, (height - 1) / 2
    depth[:], geom[:], facing[:] = np.inf, -1, 0.0
    slopes = (np.arange(width) - middle_u) / fx
    for g in range(len(form)):
        at, turn, own, kind = position[g], rotation[g], size[g], form[g]
        if kind == PLANE:
            _floor(g, at, turn, own, fx, fy, depth, geom, facing)
            continue
        left, right, top, bottom = _bounds(kind, at, turn, own, fx, fy, (height, width))
        px = -(turn[0, 0] * at[0] + turn[1, 0] * at[1] + turn[2, 0] * at[2])
        py = -(turn[0, 1] * at[0] + turn[1, 1] * at[1] + turn[2, 1] * at[2])
        pz = -(turn[0, 2] * at[0] + turn[1, 2] * at[1] + turn[2, 2] * at[2])
        radius, half = own[0], own[1]
        for v in range(top, bottom + 1):
            y = (middle_v - v) / fy
            ax, ay, az = turn[1, 0] * y + turn[2, 0], turn[1, 1] * y + turn[2, 1], turn[1, 2] * y + turn[2, 2]
            for u in range(left, right + 1):
                x = slopes[u]
                dx, dy, dz = turn[0, 0] * x + ax, turn[0, 1] * x + ay, turn[0, 2] * x + az
                if kind == CAPSULE:
                    t = ray_capsule(px, py, pz, dx, dy, dz, radius, half)
                else:
                    t = ray_distance(kind, own, px, py, pz, dx, dy, dz)
                if t < depth[v, u]:
                    nx, ny, nz = surface_normal(kind, own, px + t * dx, py + t * dy, pz + t * dz)
                    square = (nx * nx + ny * ny + nz * nz) * (x * x + y * y + 1.0)
                    depth[v, u], geom[v, u] = t, g
                    facing[v, u] = abs(nx * dx + ny * dy + nz * dz) / math.sqrt(square)


class DepthCamera:
    """One sensor's depth camera.

    Args:
        mount: where it is.
        intrinsics: its pinhole.
    """

    def __init__(self, mount: Mount, intrinsics: Intrinsics) -> None:
        self.intrinsics = intrinsics
        self._position = np.asarray(mount.position, dtype=float)
        self._world_from_camera = np.ascontiguousarray(mount.world_from_sensor)
        self._camera_from_world = np.ascontiguousarray(mount.world_from_sensor.T)
        shape = (intrinsics.height, intrinsics.width)
        self._picture = RenderedDepth(np.empty(shape), np.empty(shape, np.int16), np.empty(shape, np.float32))

    def render(self, geoms: Geoms) -> RenderedDepth:
        """Cast one ray through every pixel.

        Args:
            geoms: what there is to see; the camera must not be inside one of them.

        Returns:
            the camera's own arrays, valid until the next call.
        """
        position = (geoms.position_m - self._position) @ self._world_from_camera
        rotation = np.matmul(self._camera_from_world, geoms.rotation)
        out = self._picture
        cast_rays(
            geoms.form, geoms.size_m, position, rotation, self.intrinsics.fx, self.intrinsics.fy, out.depth_m,
            out.geom, out.incidence,
        )  # fmt: skip
        return out
