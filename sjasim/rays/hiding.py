"""Which points something hides from an eye."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
from numba import njit

from ..types import Array, BoolArray, IntArray
from .primitives import meet

BUNDLE = 25
"""Rays that are tested together against a cone before each is tested alone: one person's joints."""

SQUARE, BOUND, BOUND_SQUARE, COLUMNS = 3, 4, 5, 6
"""Columns of a geom as an eye has it, after its place."""


@njit(cache=True, error_model="numpy")
def _distance(kind: int, size: Array, r: Array, x: float, y: float, z: float, d: Array) -> float:
    """Distance along ``d`` to a geom at (x, y, z) from the eye."""
    return float(
        meet(
            kind, size, -(r[0] * x + r[3] * y + r[6] * z), -(r[1] * x + r[4] * y + r[7] * z),
            -(r[2] * x + r[5] * y + r[8] * z), r[0] * d[0] + r[3] * d[1] + r[6] * d[2],
            r[1] * d[0] + r[4] * d[1] + r[7] * d[2], r[2] * d[0] + r[5] * d[1] + r[8] * d[2],
        )
    )  # fmt: skip


@njit(cache=True, error_model="numpy")
def hidden(
    origin: Array, points: Array, whose: IntArray, flesh_m: Array, geoms: IntArray, sizes: Array, positions: Array,
    rotations: Array, out: BoolArray,
) -> None:  # fmt: skip
    """Write which points something hides from an origin.

    Args:
        origin: (3,) world point [m].
        points: (N, 3) world points [m].
        whose: (N,) owner of each point.
        flesh_m: (N,) how deep below its own owner's surface a point may lie and still be seen.
        geoms: (G, 3) of each geom that hides: its row in ``positions`` and ``rotations``, its owner, its type.
        sizes: (G, 4) their sizes as MuJoCo has them, and the radius of a sphere around each, 0 for a plane [m].
        positions: (all, 3) centres [m].
        rotations: (all, 9) row-major, world from geom.
        out: (N,) output.
    """
    around = _around(origin, geoms, sizes, positions)
    near, places = np.empty((len(geoms), COLUMNS)), np.empty(len(geoms), np.int64)
    directions, lengths = _aim(origin, points)
    for start in range(0, len(points), BUNDLE):
        last = min(start + BUNDLE, len(points))
        found = _in_bundle(directions[start:last], lengths[start:last], around, near, places)
        for n in range(start, last):
            dx, dy, dz = directions[n, 0], directions[n, 1], directions[n, 2]
            out[n] = False
            for k in range(found):
                x, y, z = near[k, 0], near[k, 1], near[k, 2]
                along = x * dx + y * dy + z * dz
                if near[k, SQUARE] - along * along > near[k, BOUND_SQUARE]:
                    continue
                geom = geoms[places[k]]
                limit = lengths[n] - (flesh_m[n] if geom[1] == whose[n] else 0.0)
                if along - near[k, BOUND] > limit:
                    continue
                way = _distance(geom[2], sizes[places[k]], rotations[geom[0]], x, y, z, directions[n])
                if way < limit:
                    out[n] = True
                    break


@njit(cache=True, error_model="numpy")
def _around(origin: Array, geoms: IntArray, sizes: Array, positions: Array) -> Array:
    """(G, `COLUMNS`) every geom as an eye has it: place from there, square of the distance, bound and its square."""
    out = np.empty((len(geoms), COLUMNS))
    for i in range(len(geoms)):
        row = out[i]
        for k in range(3):
            row[k] = positions[geoms[i, 0], k] - origin[k]
        row[SQUARE] = row[0] ** 2 + row[1] ** 2 + row[2] ** 2
        row[BOUND] = sizes[i, 3] if sizes[i, 3] > 0.0 else inf
        row[BOUND_SQUARE] = row[BOUND] ** 2
    return out


@njit(cache=True, error_model="numpy")
def _aim(origin: Array, points: Array) -> tuple[Array, Array]:
    """(N, 3) unit vectors from the origin to the points, and (N,) their distances."""
    directions, lengths = np.empty((len(points), 3)), np.empty(len(points))
    for n in range(len(points)):
        x, y, z = points[n, 0] - origin[0], points[n, 1] - origin[1], points[n, 2] - origin[2]
        length = sqrt(x * x + y * y + z * z)
        directions[n, 0], directions[n, 1], directions[n, 2] = x / length, y / length, z / length
        lengths[n] = length
    return directions, lengths


@njit(cache=True, error_model="numpy")
def _in_bundle(bundle: Array, lengths: Array, around: Array, near: Array, places: IntArray) -> int:
    """Write which geoms the cone around a bundle of rays may touch, and their places; returns how many.

    A geom's sphere lies outside the cone if the angle to its centre exceeds that of the cone and its own together,
    here by the cosines of both; and beyond the rays if its nearest point is farther than the farthest of their ends.
    """
    x = y = z = reach = 0.0
    for n in range(len(bundle)):
        x, y, z = x + bundle[n, 0], y + bundle[n, 1], z + bundle[n, 2]
        reach = max(reach, lengths[n])
    length = sqrt(x * x + y * y + z * z)
    cosine, sine = -1.0, 0.0
    if length > 0.5 * len(bundle):
        x, y, z = x / length, y / length, z / length
        least = 1.0
        for n in range(len(bundle)):
            least = min(least, bundle[n, 0] * x + bundle[n, 1] * y + bundle[n, 2] * z)
        if least > 0.0:
            cosine = least - 1e-6
            sine = sqrt(1.0 - cosine * cosine)
    found = 0
    for i in range(len(around)):
        square, bound, bound_square = around[i, SQUARE], around[i, BOUND], around[i, BOUND_SQUARE]
        if square > bound_square:
            if square > (reach + bound) ** 2:
                continue
            along = around[i, 0] * x + around[i, 1] * y + around[i, 2] * z
            if cosine > 0.0 and along < cosine * sqrt(square - bound_square) - sine * bound:
                continue
        for k in range(COLUMNS):
            near[found, k] = around[i, k]
        places[found] = i
        found += 1
    return found
