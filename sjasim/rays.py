"""Rays against geometric primitives, compiled: the first surface along each ray and whose it is.

Exact for planes, spheres, capsules, ellipsoids, cylinders and boxes; a test holds it against MuJoCo's own rays,
which cost several times as much for a scene of this size.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
from numba import njit

from .types import Array, IntArray

PLANE, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX = 0, 2, 3, 4, 5, 6
"""MuJoCo's numbers of the geom types that rays can meet."""


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
    if kind == SPHERE:
        return _root(1.0, p[0] * v[0] + p[1] * v[1] + p[2] * v[2], p[0] ** 2 + p[1] ** 2 + p[2] ** 2 - size[0] ** 2)
    if kind == CAPSULE:
        return _round(p, v, size[0], size[1], False)
    if kind == CYLINDER:
        return _round(p, v, size[0], size[1], True)
    if kind == BOX:
        return _box(p, v, size)
    if kind == ELLIPSOID:
        a = b = c = 0.0
        for k in range(3):
            s = 1.0 / (size[k] * size[k])
            a, b, c = a + v[k] * v[k] * s, b + p[k] * v[k] * s, c + p[k] * p[k] * s
        return _root(a, b, c - 1.0)
    if kind == PLANE and v[2] < -1e-15 and p[2] >= 0.0:
        x = -p[2] / v[2]
        if (size[0] <= 0.0 or abs(p[0] + x * v[0]) <= size[0]) and (size[1] <= 0.0 or abs(p[1] + x * v[1]) <= size[1]):
            return x
    return inf


@njit(cache=True)
def first_hits(
    origin: Array, directions: Array, geoms: IntArray, kinds: IntArray, sizes: Array, bounds: Array,
    positions: Array, rotations: Array, distance: Array, hit: IntArray,
) -> None:  # fmt: skip
    """Write the first surface along rays from one point.

    Args:
        origin: (3,) world point [m].
        directions: (N, 3) unit vectors.
        geoms: (G,) rows of the geoms that may be met.
        kinds: (all,) geom types.
        sizes: (all, 3) sizes as MuJoCo has them [m].
        bounds: (all,) radius of a sphere around each geom [m], 0 for a plane.
        positions: (all, 3) centres [m].
        rotations: (all, 9) row-major, world from geom.
        distance: (N,) output, -1 where nothing is met [m].
        hit: (N,) output, the geom's row, -1 for none.
    """
    count = len(directions)
    p, v = np.empty(3), np.empty(3)
    rx, ry, rz = directions[:, 0].copy(), directions[:, 1].copy(), directions[:, 2].copy()
    along, apart = np.empty(count), np.empty(count)
    distance[:] = inf
    hit[:] = -1
    for g in geoms:
        x, y, z = positions[g, 0] - origin[0], positions[g, 1] - origin[1], positions[g, 2] - origin[2]
        bound = bounds[g] if bounds[g] > 0.0 else inf
        reach = x * x + y * y + z * z - bound * bound
        for n in range(count):
            along[n] = x * rx[n] + y * ry[n] + z * rz[n]
            apart[n] = reach - along[n] * along[n]
        r = rotations[g]
        for k in range(3):
            p[k] = -(r[k] * x + r[3 + k] * y + r[6 + k] * z)
        for n in range(count):
            if apart[n] > 0.0 or along[n] < -bound or along[n] - bound > distance[n]:
                continue
            for k in range(3):
                v[k] = r[k] * rx[n] + r[3 + k] * ry[n] + r[6 + k] * rz[n]
            t = _meet(kinds[g], sizes[g], p, v)
            if t < distance[n]:
                distance[n], hit[n] = t, g
    for n in range(count):
        if hit[n] < 0:
            distance[n] = -1.0
