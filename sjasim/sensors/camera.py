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
from ..types import Array, Geoms, IntArray

PLANE, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX = 0, 2, 3, 4, 5, 6
"""Codes of `Geoms.form`, as MuJoCo numbers them."""

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
    def of(cls, width: int, horizontal_fov_rad: float, vertical_fov_rad: float) -> Intrinsics:
        """A Kinect v2's for 512 (512 x 424) or 256 columns (256 x 212); pixels are not quite square."""
        height = width * 424 // 512
        return cls(
            width,
            height,
            width / 2 / math.tan(horizontal_fov_rad / 2),
            height / 2 / math.tan(vertical_fov_rad / 2),
        )


@dataclass(frozen=True, slots=True)
class Picture:
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
def _quadric(a: float, b: float, c: float) -> float:
    """Smaller root of a t^2 + 2 b t + c, or -1 where there is none before the eye."""
    root = b * b - a * c
    if root < 0.0 or a < 1e-15:
        return -1.0
    return (-b - math.sqrt(root)) / a


@njit(cache=True, error_model="numpy")
def _capsule(p: tuple[float, float, float], d: tuple[float, float, float], radius: float, half: float) -> float:
    t = _quadric(d[0] * d[0] + d[1] * d[1], p[0] * d[0] + p[1] * d[1], p[0] * p[0] + p[1] * p[1] - radius * radius)
    along = p[2] + t * d[2]
    if t > 0.0 and abs(along) <= half:
        return float(t)
    best = -1.0
    square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    for end in (-half, half):
        z = p[2] - end
        t = _quadric(square, p[0] * d[0] + p[1] * d[1] + z * d[2], p[0] * p[0] + p[1] * p[1] + z * z - radius * radius)
        beyond = (p[2] + t * d[2]) * end >= half * abs(end)
        if t > 0.0 and beyond and (best < 0.0 or t < best):
            best = t
    return best


@njit(cache=True, error_model="numpy")
def _cylinder(p: tuple[float, float, float], d: tuple[float, float, float], radius: float, half: float) -> float:
    t = _quadric(d[0] * d[0] + d[1] * d[1], p[0] * d[0] + p[1] * d[1], p[0] * p[0] + p[1] * p[1] - radius * radius)
    best = t if t > 0.0 and abs(p[2] + t * d[2]) <= half else -1.0
    if abs(d[2]) > 1e-12:
        t = (-half if d[2] > 0.0 else half) / d[2] - p[2] / d[2]
        x, y = p[0] + t * d[0], p[1] + t * d[1]
        if t > 0.0 and x * x + y * y <= radius * radius and (best < 0.0 or t < best):
            best = t
    return best


@njit(cache=True, error_model="numpy")
def _box(p: tuple[float, float, float], d: tuple[float, float, float], size: Array) -> float:
    enter, leave = -np.inf, np.inf
    for k in range(3):
        if abs(d[k]) < 1e-15:
            if abs(p[k]) > size[k]:
                return -1.0
            continue
        first, last = (-size[k] - p[k]) / d[k], (size[k] - p[k]) / d[k]
        enter = max(enter, min(first, last))
        leave = min(leave, max(first, last))
    return enter if enter <= leave else -1.0


@njit(cache=True, error_model="numpy")
def _hit(form: int, p: tuple[float, float, float], d: tuple[float, float, float], size: Array) -> float:
    """Where a ray from ``p`` along ``d``, both in the geom's frame, enters it; not positive where it does not."""
    if form == CAPSULE:
        return float(_capsule(p, d, size[0], size[1]))
    if form == CYLINDER:
        return float(_cylinder(p, d, size[0], size[1]))
    if form == BOX:
        return float(_box(p, d, size))
    x, y, z = (size[0], size[0], size[0]) if form == SPHERE else (size[0], size[1], size[2])
    px, py, pz, dx, dy, dz = p[0] / x, p[1] / y, p[2] / z, d[0] / x, d[1] / y, d[2] / z
    c = px * px + py * py + pz * pz - 1.0
    return float(_quadric(dx * dx + dy * dy + dz * dz, px * dx + py * dy + pz * dz, c))


@njit(cache=True, error_model="numpy")
def _facing(form: int, q: tuple[float, float, float], d: tuple[float, float, float], size: Array) -> float:
    """Cosine of incidence at a surface point ``q`` of the geom's frame, for a ray along ``d``."""
    x, y, z = q
    if form == CAPSULE:
        z -= min(max(z, -size[1]), size[1])
    elif form == CYLINDER:
        if abs(z) > size[1] * (1.0 - 1e-9) and x * x + y * y < size[0] * size[0] * (1.0 - 1e-9):
            x, y = 0.0, 0.0
        else:
            z = 0.0
    elif form == BOX:
        a, b, c = abs(abs(x) - size[0]), abs(abs(y) - size[1]), abs(abs(z) - size[2])
        x, y, z = (1.0, 0.0, 0.0) if a <= b and a <= c else ((0.0, 1.0, 0.0) if b <= c else (0.0, 0.0, 1.0))
    elif form == ELLIPSOID:
        x, y, z = x / (size[0] * size[0]), y / (size[1] * size[1]), z / (size[2] * size[2])
    normal = math.sqrt(x * x + y * y + z * z)
    length = math.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    return abs(x * d[0] + y * d[1] + z * d[2]) / (normal * length)


@njit(cache=True, error_model="numpy")
def _floor(
    g: int, at: Array, turn: Array, size: Array, fx: float, fy: float, depth: Array, geom: Array, facing: Array
) -> None:
    """Cast every pixel at a plane; it is seen from its front only, and as far as its size says."""
    height, width = depth.shape
    middle_u, middle_v = (width - 1) / 2, (height - 1) / 2
    above = -(turn[0, 2] * at[0] + turn[1, 2] * at[1] + turn[2, 2] * at[2])
    if above <= 0.0:
        return
    for v in range(height):
        y = (middle_v - v) / fy
        for u in range(width):
            x = (u - middle_u) / fx
            down = turn[0, 2] * x + turn[1, 2] * y + turn[2, 2]
            if down > -1e-15:
                continue
            t = -above / down
            if t >= depth[v, u]:
                continue
            dx, dy, dz = t * x - at[0], t * y - at[1], t - at[2]
            across = abs(turn[0, 0] * dx + turn[1, 0] * dy + turn[2, 0] * dz)
            along = abs(turn[0, 1] * dx + turn[1, 1] * dy + turn[2, 1] * dz)
            if (size[0] <= 0.0 or across <= size[0]) and (size[1] <= 0.0 or along <= size[1]):
                depth[v, u], geom[v, u] = t, g
                facing[v, u] = -down / math.sqrt(x * x + y * y + 1.0)


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
def cast(
    form: IntArray,
    size: Array,
    position: Array,
    rotation: Array,
    fx: float,
    fy: float,
    depth: Array,
    geom: NDArray[np.int16],
    facing: NDArray[np.float32],
) -> None:
    """Fill a picture.

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
    for g in range(len(form)):
        at, turn, own = position[g], rotation[g], size[g]
        if form[g] == PLANE:
            _floor(g, at, turn, own, fx, fy, depth, geom, facing)
            continue
        left, right, top, bottom = _bounds(form[g], at, turn, own, fx, fy, (height, width))
        px = -(turn[0, 0] * at[0] + turn[1, 0] * at[1] + turn[2, 0] * at[2])
        py = -(turn[0, 1] * at[0] + turn[1, 1] * at[1] + turn[2, 1] * at[2])
        pz = -(turn[0, 2] * at[0] + turn[1, 2] * at[1] + turn[2, 2] * at[2])
        for v in range(top, bottom + 1):
            y = (middle_v - v) / fy
            ax, ay, az = turn[1, 0] * y + turn[2, 0], turn[1, 1] * y + turn[2, 1], turn[1, 2] * y + turn[2, 2]
            for u in range(left, right + 1):
                x = (u - middle_u) / fx
                d = (turn[0, 0] * x + ax, turn[0, 1] * x + ay, turn[0, 2] * x + az)
                t = _hit(form[g], (px, py, pz), d, own)
                if 0.0 < t < depth[v, u]:
                    depth[v, u], geom[v, u] = t, g
                    facing[v, u] = _facing(form[g], (px + t * d[0], py + t * d[1], pz + t * d[2]), d, own)


class Camera:
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
        self._picture = Picture(np.empty(shape), np.empty(shape, np.int16), np.empty(shape, np.float32))

    def picture(self, geoms: Geoms) -> Picture:
        """Cast one ray through every pixel.

        Args:
            geoms: what there is to see; the camera must not be inside one of them.

        Returns:
            the camera's own arrays, valid until the next call.
        """
        position = (geoms.position_m - self._position) @ self._world_from_camera
        rotation = np.matmul(self._camera_from_world, geoms.rotation)
        out = self._picture
        cast(
            geoms.form, geoms.size_m, position, rotation, self.intrinsics.fx, self.intrinsics.fy, out.depth_m,
            out.geom, out.incidence,
        )  # fmt: skip
        return out
