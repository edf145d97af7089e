"""Rays against geometric primitives, compiled: which points something hides from an eye.

Exact for planes, spheres, capsules, ellipsoids, cylinders and boxes; a test holds it against MuJoCo's own rays,
which cost several times as much for a scene of this size.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
from numba import njit

from .types import Array, BoolArray, IntArray

PLANE, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX = 0, 2, 3, 4, 5, 6
"""MuJoCo's numbers of the geom types that rays can meet."""

BUNDLE = 25
"""Rays that are tested together against a cone before each is tested alone: one person's joints."""


@njit(cache=True, inline="always")
def _root(a: float, b: float, c: float) -> float:
    """Smaller non-negative root of a x^2 + 2 b x + c, or infinity; from inside, the larger one."""
    disc = b * b - a * c
    if disc < 0.0 or a < 1e-15:
        return inf
    disc = sqrt(disc)
    x = (-b - disc) / a
    if x >= 0.0:
        return x
    x = (-b + disc) / a
    return x if x >= 0.0 else inf


@njit(cache=True)
def _round(p: Array, v: Array, radius: float, half: float, capped: bool) -> float:
    """Capsule or (capped) cylinder along z."""
    best = inf
    a, b = v[0] * v[0] + v[1] * v[1], p[0] * v[0] + p[1] * v[1]
    c = p[0] * p[0] + p[1] * p[1] - radius * radius
    x = _root(a, b, c)
    if x < inf and abs(p[2] + x * v[2]) <= half:
        best = x
    for sign in (-1.0, 1.0):
        z = p[2] - sign * half
        if capped:
            if abs(v[2]) > 1e-15:
                x = -z / v[2]
                px, py = p[0] + x * v[0], p[1] + x * v[1]
                if 0.0 <= x < best and px * px + py * py <= radius * radius:
                    best = x
        else:
            x = _root(a + v[2] * v[2], b + z * v[2], c + z * z)
            if x < best and sign * (z + x * v[2]) >= 0.0:
                best = x
    return best


@njit(cache=True)
def _box(p: Array, v: Array, size: Array) -> float:
    low, high = -inf, inf
    for k in range(3):
        if abs(v[k]) < 1e-15:
            if abs(p[k]) > size[k]:
                return inf
        else:
            a, b = (-size[k] - p[k]) / v[k], (size[k] - p[k]) / v[k]
            low, high = max(low, min(a, b)), min(high, max(a, b))
    if high < max(low, 0.0):
        return inf
    return low if low >= 0.0 else high


@njit(cache=True)
def _meet(kind: int, size: Array, p: Array, v: Array) -> float:
    """Distance to one geom along a ray in its own frame."""
    t = inf
    if kind == SPHERE:
        t = _root(1.0, p[0] * v[0] + p[1] * v[1] + p[2] * v[2], p[0] ** 2 + p[1] ** 2 + p[2] ** 2 - size[0] ** 2)
    elif kind == CAPSULE:
        t = _round(p, v, size[0], size[1], False)
    elif kind == CYLINDER:
        t = _round(p, v, size[0], size[1], True)
    elif kind == BOX:
        t = _box(p, v, size)
    elif kind == ELLIPSOID:
        a = b = c = 0.0
        for k in range(3):
            s = 1.0 / (size[k] * size[k])
            a, b, c = a + v[k] * v[k] * s, b + p[k] * v[k] * s, c + p[k] * p[k] * s
        t = _root(a, b, c - 1.0)
    elif kind == PLANE and v[2] < -1e-15 and p[2] >= 0.0:
        x = -p[2] / v[2]
        if (size[0] <= 0.0 or abs(p[0] + x * v[0]) <= size[0]) and (size[1] <= 0.0 or abs(p[1] + x * v[1]) <= size[1]):
            t = x
    return t


@njit(cache=True)
def hidden(
    origin: Array, points: Array, whose: IntArray, flesh_m: float, geoms: IntArray, owners: IntArray, kinds: IntArray,
    sizes: Array, bounds: Array, positions: Array, rotations: Array, out: BoolArray,
) -> None:  # fmt: skip
    """Write which points something hides from an origin.

    Args:
        origin: (3,) world point [m].
        points: (N, 3) world points [m].
        whose: (N,) owner of each point.
        flesh_m: how deep below its own owner's surface a point may lie and still be seen.
        geoms: (G,) rows of the geoms that hide.
        owners: (all,) owner of each geom.
        kinds: (all,) geom types.
        sizes: (all, 3) sizes as MuJoCo has them [m].
        bounds: (all,) radius of a sphere around each geom [m], 0 for a plane.
        positions: (all, 3) centres [m].
        rotations: (all, 9) row-major, world from geom.
        out: (N,) output.
    """
    p, v = np.empty(3), np.empty(3)
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
                limit = lengths[n] - (flesh_m if owners[g] == whose[n] else 0.0)
                if bounds[g] > 0.0:
                    along = x * d[0] + y * d[1] + z * d[2]
                    if along - bounds[g] > limit or far[i] * far[i] - along * along > bounds[g] * bounds[g]:
                        continue
                r = rotations[g]
                for k in range(3):
                    p[k] = -(r[k] * x + r[3 + k] * y + r[6 + k] * z)
                    v[k] = r[k] * d[0] + r[3 + k] * d[1] + r[6 + k] * d[2]
                if _meet(kinds[g], sizes[g], p, v) < limit:
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
