"""Which points something hides from an eye."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit

from ..types import Array, BoolArray, IntArray
from .primitives import meet

BUNDLE = 25
"""Rays that are tested together against a cone before each is tested alone: one person's joints."""


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


@njit(cache=True)
def hidden(
    origin: Array, points: Array, whose: IntArray, flesh_m: Array, geoms: IntArray, owners: IntArray, kinds: IntArray,
    sizes: Array, bounds: Array, positions: Array, rotations: Array, out: BoolArray,
) -> None:  # fmt: skip
    """Write which points something hides from an origin.

    Args:
        origin: (3,) world point [m].
        points: (N, 3) world points [m].
        whose: (N,) owner of each point.
        flesh_m: (N,) how deep below its own owner's surface a point may lie and still be seen.
        geoms: (G,) rows of the geoms that hide.
        owners: (all,) owner of each geom.
        kinds: (all,) geom types.
        sizes: (all, 3) sizes as MuJoCo has them [m].
        bounds: (all,) radius of a sphere around each geom [m], 0 for a plane.
        positions: (all, 3) centres [m].
        rotations: (all, 9) row-major, world from geom.
        out: (N,) output.
    """
    near, rel, far = np.empty(len(geoms), np.int64), np.empty((len(geoms), 3)), np.empty(len(geoms))
    for i in range(len(geoms)):
        for k in range(3):
            rel[i, k] = positions[geoms[i], k] - origin[k]
        far[i] = sqrt(rel[i, 0] ** 2 + rel[i, 1] ** 2 + rel[i, 2] ** 2)
    directions, lengths = _aim(origin, points)
    for first in range(0, len(points), BUNDLE):
        last = min(first + BUNDLE, len(points))
        found = _in_bundle(directions[first:last], lengths[first:last], rel, far, geoms, bounds, near)
        for n in range(first, last):
            d = directions[n]
            out[n] = False
            for i in near[:found]:
                g = geoms[i]
                x, y, z = rel[i, 0], rel[i, 1], rel[i, 2]
                limit = lengths[n] - (flesh_m[n] if owners[g] == whose[n] else 0.0)
                if bounds[g] > 0.0:
                    along = x * d[0] + y * d[1] + z * d[2]
                    if along - bounds[g] > limit or far[i] * far[i] - along * along > bounds[g] * bounds[g]:
                        continue
                if _distance(kinds[g], sizes[g], rotations[g], x, y, z, d) < limit:
                    out[n] = True
                    break


@njit(cache=True)
def _aim(origin: Array, points: Array) -> tuple[Array, Array]:
    """(N, 3) unit vectors from the origin to the points, and (N,) their distances."""
    directions, lengths = np.empty((len(points), 3)), np.empty(len(points))
    for n in range(len(points)):
        for k in range(3):
            directions[n, k] = points[n, k] - origin[k]
        lengths[n] = sqrt(directions[n, 0] ** 2 + directions[n, 1] ** 2 + directions[n, 2] ** 2)
        directions[n] /= lengths[n]
    return directions, lengths


@njit(cache=True)
def _in_bundle(
    bundle: Array, lengths: Array, rel: Array, far: Array, geoms: IntArray, bounds: Array, near: IntArray
) -> int:
    """Write which geoms (places in ``geoms``) the cone around a bundle of rays may touch; returns how many.

    A geom's sphere lies outside the cone if the angle to its centre exceeds that of the cone and its own together,
    here by the cosines of both; and beyond the rays if its nearest point is farther than the farthest of their ends.
    """
    axis = np.zeros(3)
    for d in bundle:
        axis += d
    length = sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
    cosine, sine, reach = -1.0, 0.0, 0.0
    for n in range(len(lengths)):
        reach = max(reach, lengths[n])
    if length > 0.5 * len(bundle):
        axis /= length
        least = 1.0
        for d in bundle:
            least = min(least, d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2])
        if least > 0.0:
            cosine = least - 1e-6
            sine = sqrt(1.0 - cosine * cosine)
    found = 0
    for i in range(len(geoms)):
        bound = bounds[geoms[i]]
        if bound > 0.0 and far[i] > bound:
            if far[i] - bound > reach:
                continue
            if cosine > 0.0:
                along = rel[i, 0] * axis[0] + rel[i, 1] * axis[1] + rel[i, 2] * axis[2]
                if along < cosine * sqrt(far[i] * far[i] - bound * bound) - sine * bound:
                    continue
        near[found] = i
        found += 1
    return found
