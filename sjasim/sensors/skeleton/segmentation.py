"""From a depth image to persons' pixels: the floor removed, what is left shared among the persons that are tracked.

Points are (x, height, z): to the sensor's left, above the floor, away from the sensor. That the sensor stands level
at a known height is assumed known, as the Kinect's own floor plane would tell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...core import Array
from ..depth_camera import Intrinsics

Points = NDArray[np.float32]
Image = NDArray[np.int16]
Pixels = NDArray[np.int32]
Owners = NDArray[np.int8]

FLOOR_M = 0.04
"""Lower points are floor: some five standard deviations of the floor's noise at 4 m (assumed)."""
MAX_DEPTH_MM = 8000
"""Depth that the image is given where there is none, and at most."""
REACH_M = 0.85
"""Nothing of a person is farther from the trunk over the floor: an arm's length (assumed)."""
LOW_M, LOW_REACH_M = 0.50, 0.50
"""Below this height, a robot's, only legs count, which reach so far (assumed)."""
LONELY_M, STRANGE_M = 0.45, 0.40
"""Farther than the first from the trunk a point must be nearer than the second to one of the joints (assumed)."""
OBJECT_M = 0.30
"""A low object's points are within this distance of its middle (assumed)."""
CROWN_M2 = 0.002
"""The crown's height is that above which a person shows so much surface: the same of a head from any side (assumed)."""
UNASSIGNED, LOW_OBJECT = -1, -2
"""Owners that are no person: nothing known, and a low object such as a robot."""

_CELL_M, _X_M, _Z_M = 0.06, (-3.5, 3.5), (0.4, 4.6)
_TORSO_M = (0.75, 1.60)
_WINDOW = 3
_BIN_M = 0.01
_LEAST_POINTS = 12


@dataclass(slots=True)
class Foreground:
    """What stands on the floor in one frame; the first ``count`` rows count, the rest is room.

    Attributes:
        image: (H + 2, W + 2) depth, `FAR_MM` where there is none and in the rim around it [mm].
        pixel: (N, 2) row and column.
        point: (N, 3) [m].
        owner: (N,) row of the person, `NOBODY` or `OBJECT`.
        count: number of rows.
    """

    image: Image
    pixel: Pixels
    point: Points
    owner: Owners
    count: int = 0

    @classmethod
    def allocate(cls, intrinsics: Intrinsics) -> Foreground:
        """Empty arrays for images of this size."""
        shape, size = (intrinsics.height + 2, intrinsics.width + 2), intrinsics.height * intrinsics.width
        pixel, point = np.zeros((size, 2), np.int32), np.zeros((size, 3), np.float32)
        return cls(np.full(shape, MAX_DEPTH_MM, np.int16), pixel, point, np.zeros(size, np.int8))


@njit(cache=True, error_model="numpy")
def _lift(
    depth: NDArray[np.uint16], fx: float, fy: float, height_m: float, image: Image, pixel: Pixels, point: Points
) -> int:
    height, width = depth.shape
    middle_u, middle_v = (width - 1) / 2, (height - 1) / 2
    n = 0
    for v in range(height):
        slope = (middle_v - v) / fy
        for u in range(width):
            if depth[v, u] == 0:
                image[v + 1, u + 1] = MAX_DEPTH_MM
                continue
            z = np.float32(depth[v, u]) * np.float32(0.001)
            image[v + 1, u + 1] = min(depth[v, u], MAX_DEPTH_MM)
            above = height_m + slope * z
            if above > FLOOR_M:
                pixel[n, 0], pixel[n, 1] = v, u
                point[n, 0], point[n, 1], point[n, 2] = (u - middle_u) / fx * z, above, z
                n += 1
    return n


def extract_foreground(depth_mm: NDArray[np.uint16], intrinsics: Intrinsics, height_m: float, out: Foreground) -> None:
    """Take everything above the floor out of a depth image.

    Args:
        depth_mm: (H, W), 0 where there is none.
        intrinsics: the image's pinhole.
        height_m: of the sensor above the floor.
        out: filled in place, but for the owners.
    """
    out.count = _lift(depth_mm, intrinsics.fx, intrinsics.fy, height_m, out.image, out.pixel, out.point)


@njit(cache=True)
def _joint_distance(point: Points, joints: Array) -> float:
    """Squared distance to the nearest joint."""
    best = np.inf
    for j in range(len(joints)):
        x, y, z = point[0] - joints[j, 0], point[1] - joints[j, 1], point[2] - joints[j, 2]
        best = min(best, x * x + y * y + z * z)
    return best


@njit(cache=True)
def _share(count: int, point: Points, places: Array, joints: Array, low: Array, owner: Owners) -> None:
    for i in range(count):
        short = point[i, 1] < LOW_M
        reach = LOW_REACH_M if short else REACH_M
        best, who, rival = reach * reach, UNASSIGNED, False
        for k in range(len(places)):
            x, z = point[i, 0] - places[k, 0], point[i, 2] - places[k, 1]
            square = x * x + z * z
            if square < reach * reach:
                rival = rival or who >= 0
                if square < best:
                    best, who = square, k
        if short and not math.isnan(low[0]):
            x, z = point[i, 0] - low[0], point[i, 2] - low[1]
            if x * x + z * z < min(best, OBJECT_M * OBJECT_M):
                owner[i] = LOW_OBJECT
                continue
        if rival or (who >= 0 and best > LONELY_M * LONELY_M):
            nearest = np.inf if rival else STRANGE_M * STRANGE_M
            who = UNASSIGNED
            for k in range(len(places)):
                x, z = point[i, 0] - places[k, 0], point[i, 2] - places[k, 1]
                if x * x + z * z < reach * reach:
                    square = _joint_distance(point[i], joints[k])
                    if square < nearest:
                        nearest, who = square, k
        owner[i] = who


def assign_owners(scene: Foreground, places: Array, joints: Array, low: Array) -> None:
    """Give every point to a person, to the low object, or to nobody.

    A point within reach of one person is that person's. Where several could have it the nearest of their joints
    decides, as predicted from the last frame: trunks that pass each other at arm's length stay apart. A point beyond
    a lonely person's trunk must be near one of the joints, or it is nobody's: somebody else may be standing there.

    Args:
        scene: gets its owners.
        places: (P, 2) predicted x and z of the persons' trunks [m].
        joints: (P, 25, 3) predicted joints as points [m].
        low: (2,) x and z of the low object, NaN without one [m].
    """
    _share(scene.count, scene.point, places, joints, low, scene.owner)


@njit(cache=True)
def _quantile(histogram: NDArray[np.int32], share_below: float) -> float:
    """Bin, with a fraction, below which a share of a histogram's entries lies."""
    goal, below = share_below * histogram.sum(), 0.0
    for k in range(len(histogram)):
        if histogram[k] and below + histogram[k] >= goal:
            return float(k + (goal - below) / histogram[k])
        below += histogram[k]
    return 0.0


@njit(cache=True)
def _measure(
    count: int, point: Points, owner: Owners, places: Array, scales: Array, per_pixel: float, out: Array
) -> None:
    across = np.zeros((len(places), 200), np.int32)
    away = np.zeros((len(places), 200), np.int32)
    chest = np.zeros((len(places), 200), np.int32)
    up = np.zeros((len(places), 240), np.int32)
    known = np.zeros(len(places), np.bool_)
    for least in (0.42, 0.0):  # the trunk's points; all of them for somebody whose trunk is hidden
        for i in range(count):
            k = owner[i]
            if k < 0 or known[k]:
                continue
            x = int((point[i, 0] - places[k, 0]) / _BIN_M + 100.0)
            z = int((point[i, 2] - places[k, 1]) / _BIN_M + 100.0)
            if least > 0.0:
                out[k, 0] += 1.0
                up[k, min(int(point[i, 1] / _BIN_M), 239)] += 1
            height = point[i, 1] / (1.75 * scales[k])
            if 0 <= x < 200 and 0 <= z < 200 and (least == 0.0 or least < height < 0.80):
                across[k, x] += 1
                away[k, z] += 1
                if 0.60 < height < 0.72:
                    chest[k, x] += 1
        for k in range(len(places)):
            known[k] = out[k, 0] == 0.0 or across[k].sum() >= _LEAST_POINTS
        if known.all():
            break
    for k in range(len(places)):
        if out[k, 0] == 0.0:
            continue
        out[k, 1] = places[k, 0] + (_quantile(across[k], 0.5) - 100.0) * _BIN_M
        out[k, 2] = places[k, 1] + (_quantile(away[k], 0.5) - 100.0) * _BIN_M
        above = CROWN_M2 / (per_pixel * out[k, 2] ** 2 * up[k].sum())
        out[k, 3] = _quantile(up[k], 1.0 - min(above, 0.5)) * _BIN_M
        out[k, 4] = (_quantile(chest[k], 0.9) - _quantile(chest[k], 0.1)) * _BIN_M


def measure_persons(scene: Foreground, places: Array, scales: Array, per_pixel: float) -> Array:
    """What the pixels of each person say as a whole.

    Args:
        scene: with owners.
        places: (P, 2) predicted x and z of the trunks [m].
        scales: (P,) stature over 1.75 m.
        per_pixel: surface that a pixel shows at 1 m [m^2].

    Returns:
        (P, 5) number of points, median x and z of the trunk's surface, height of the crown, width of the chest [m].
    """
    out = np.zeros((len(places), 5))
    if len(places):
        _measure(scene.count, scene.point, scene.owner, places, scales, per_pixel, out)
    return out


@njit(cache=True)
def _plan(count: int, point: Points, owner: Owners, per_pixel: float, area: Array, top: Array) -> None:
    """Add up the surface of nobody's points by cells of the floor."""
    for i in range(count):
        if owner[i] != UNASSIGNED or not _TORSO_M[0] < point[i, 1]:
            continue
        a = int((point[i, 0] - _X_M[0]) / _CELL_M)
        b = int((point[i, 2] - _Z_M[0]) / _CELL_M)
        if 0 <= a < area.shape[0] and 0 <= b < area.shape[1]:
            top[a, b] = max(top[a, b], point[i, 1])
            if point[i, 1] < _TORSO_M[1]:
                area[a, b] += per_pixel * point[i, 2] * point[i, 2]


def find_new_persons(
    scene: Foreground, intrinsics: Intrinsics, area_m2: float, apart_m: float
) -> list[tuple[float, float]]:
    """Places where nobody's points stand as high as a person and show enough surface.

    Args:
        scene: with owners.
        intrinsics: the image's pinhole.
        area_m2: least surface at the height of the trunk, inside a window of .42 m.
        apart_m: distance between two such places.

    Returns:
        x and z of each [m], the surest first.
    """
    shape = round((_X_M[1] - _X_M[0]) / _CELL_M), round((_Z_M[1] - _Z_M[0]) / _CELL_M)
    area, top = np.zeros(shape), np.zeros(shape)
    _plan(scene.count, scene.point, scene.owner, 1.0 / (intrinsics.fx * intrinsics.fy), area, top)
    if area.sum() < area_m2:
        return []
    sums = np.pad(area, _WINDOW).cumsum(axis=0).cumsum(axis=1)
    span = 2 * _WINDOW
    inside = sums[span:, span:] - sums[:-span, span:] - sums[span:, :-span] + sums[:-span, :-span]
    inside = np.pad(inside, ((0, shape[0] - inside.shape[0]), (0, shape[1] - inside.shape[1])))
    xs = _X_M[0] + _CELL_M * (np.arange(shape[0]) + 0.5)
    zs = _Z_M[0] + _CELL_M * (np.arange(shape[1]) + 0.5)
    found: list[tuple[float, float]] = []
    while len(found) < 8:
        a, b = np.unravel_index(int(inside.argmax()), shape)
        if inside[a, b] < area_m2:
            break
        near = np.hypot(xs[:, None] - xs[a], zs[None] - zs[b]) < max(apart_m, _CELL_M)
        weight = np.where(near & (np.hypot(xs[:, None] - xs[a], zs[None] - zs[b]) < 0.3), area, 0.0)
        if top[near].max() > 1.2 and weight.sum() > 0.0:
            x = float((weight * xs[:, None]).sum() / weight.sum())
            found.append((x, float((weight * zs[None]).sum() / weight.sum())))
        inside[near] = 0.0
    return found


@njit(cache=True)
def _low(count: int, point: Points, owner: Owners, before: Array, reach_m: float, sums: Array) -> None:
    """Add up x, z and squared z of what is low and nobody's, near where the object was if that is known; and count."""
    known = not math.isnan(before[0])
    for i in range(count):
        if owner[i] == LOW_OBJECT or (owner[i] == UNASSIGNED and point[i, 1] < LOW_M):
            x, z = point[i, 0], point[i, 2]
            if not known or (x - before[0]) ** 2 + (z - before[1]) ** 2 < reach_m * reach_m:
                sums[0] += x
                sums[1] += z
                sums[2] += z * z
                sums[3] += 1.0


def locate_low_object(scene: Foreground, before: Array, intrinsics: Intrinsics, area_m2: float) -> Array:
    """Where something low stands that is nobody's leg: a robot, most likely.

    Args:
        scene: with owners.
        before: (2,) where it was, NaN if it was not known [m].
        intrinsics: the image's pinhole.
        area_m2: least surface that it must show.

    Returns:
        (2,) x and z, as ``before`` while too little of it can be seen.
    """
    sums = np.zeros(4)
    _low(scene.count, scene.point, scene.owner, before, 1.5 * OBJECT_M, sums)
    if sums[3] == 0.0 or sums[2] / (intrinsics.fx * intrinsics.fy) < area_m2:
        return before
    middle = sums[:2] / sums[3]
    return middle if math.isnan(before[0]) else np.asarray(before + 0.3 * (middle - before))
