"""Occlusion test: which points a scene's geoms hide from a sensor. Compiled.

All geometry is expressed in the sensor's frame: x and y across the image, z away from the sensor. The ray to a point
is a pair of slopes, x / z and y / z. Every geom has a bounding rectangle of slopes and a nearest depth. A geom whose
rectangle the ray misses, or which begins behind the point, cannot occlude it; only the remaining geoms are intersected
with the ray.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from ...core import Array, BoolArray, IntArray
from ...core.compiled import compiled_inner
from .primitives import BOX, CAPSULE, CYLINDER, ELLIPSOID, PLANE, ray_distance

ROW = 0
"""Column of a geom's integers: its row in the arrays of positions and rotations."""

OWNER = 1
"""Column of a geom's integers: the dancer that it belongs to, or -1."""

FORM = 2
"""Column of a geom's integers: MuJoCo's geom type."""

BOX_M = 3
"""First column of a bounding shape after the size: the half edges of a box [m]."""

RADIUS_M = 6
"""Column of a bounding shape: the radius of a sphere around each point of the box [m]."""

SHAPE_COLUMNS = 7
"""Number of columns of a bounding shape."""

CENTRE = 0
"""First column of a projected geom: its centre in the sensor's frame [m]."""

AXES = 3
"""First column of a projected geom: the rotation from geom to sensor, row-major."""

BOUNDS = 12
"""First column of a projected geom: its bounds, whose own columns follow."""

PROJECTED_COLUMNS = 17
"""Number of columns of a projected geom."""

LOW_X = 0
"""Column of bounds: smallest slope x / z."""

HIGH_X = 1
"""Column of bounds: largest slope x / z."""

LOW_Y = 2
"""Column of bounds: smallest slope y / z."""

HIGH_Y = 3
"""Column of bounds: largest slope y / z."""

NEAREST = 4
"""Column of bounds: nearest depth [m]."""

IS_OWN = 5
"""Column of a candidate: 1 if the geom belongs to the same dancer as the points, else 0; bounds stand before it."""

CANDIDATE_COLUMNS = 6
"""Number of columns of a candidate: a geom that may occlude one dancer's points."""

_MARGIN_M = 1e-9
"""Bounds are widened by this, so that rounding never excludes a geom."""


def bounding_shapes(forms: IntArray, sizes: Array) -> Array:
    """Return the geoms' sizes and, for each, a box and a radius: the geom lies within the radius of some box point.

    Args:
        forms: (G,) MuJoCo's geom types.
        sizes: (G, 3) MuJoCo's geom sizes [m].

    Returns:
        (G, `SHAPE_COLUMNS`) size, half edges and radius [m]; the radius of a plane is infinite.
    """
    out = np.zeros((len(forms), SHAPE_COLUMNS))
    out[:, :BOX_M] = sizes

    boxed = np.isin(forms, (ELLIPSOID, BOX))
    out[boxed, BOX_M:RADIUS_M] = sizes[boxed]
    elongated = np.isin(forms, (CAPSULE, CYLINDER))
    out[elongated, RADIUS_M - 1] = sizes[elongated, 1]

    out[~boxed, RADIUS_M] = sizes[~boxed, 0]
    out[forms == PLANE, RADIUS_M] = inf
    return out


@compiled_inner
def project_geoms(
    sensor: Array, rows: IntArray, shape: Array, position: Array, rotation: Array, projected: Array
) -> None:
    """Write every geom's centre, axes and bounds in a sensor's frame.

    Args:
        sensor: (12,) or more: rotation from the world into the sensor's frame, row-major, and its position [m].
        rows: (G, 3) integers of the geoms: `ROW`, `OWNER`, `FORM`.
        shape: (G, `SHAPE_COLUMNS`) from `bounding_shapes` [m].
        position: (all, 3) centres in the world [m].
        rotation: (all, 9) world from geom, row-major.
        projected: (G, `PROJECTED_COLUMNS`) output.
    """
    half = np.zeros(3)
    for g in range(len(rows)):
        row = rows[g, ROW]
        x = position[row, 0] - sensor[9]
        y = position[row, 1] - sensor[10]
        z = position[row, 2] - sensor[11]

        for i in range(3):
            a = sensor[3 * i]
            b = sensor[3 * i + 1]
            c = sensor[3 * i + 2]
            projected[g, CENTRE + i] = a * x + b * y + c * z

            # Half extent of the rotated bounding box along this axis of the sensor.
            half[i] = shape[g, RADIUS_M] + _MARGIN_M
            for j in range(3):
                entry = a * rotation[row, j] + b * rotation[row, 3 + j] + c * rotation[row, 6 + j]
                projected[g, AXES + 3 * i + j] = entry
                half[i] += abs(entry) * shape[g, BOX_M + j]

        near = projected[g, CENTRE + 2] - half[2]
        far = projected[g, CENTRE + 2] + half[2]
        projected[g, BOUNDS + NEAREST] = near if far > 0.0 else inf

        for i in range(2):
            # The slopes of a geom that reaches the sensor's own plane are unbounded.
            low = -inf
            high = inf
            if near > 0.0:
                low = projected[g, CENTRE + i] - half[i]
                high = projected[g, CENTRE + i] + half[i]
                low = low / (far if low > 0.0 else near)
                high = high / (near if high > 0.0 else far)
            projected[g, BOUNDS + 2 * i] = low
            projected[g, BOUNDS + 2 * i + 1] = high


@compiled_inner
def mark_occluded(
    points: Array, owner: int, body_depth_m: Array, rows: IntArray, shape: Array, projected: Array, visible: BoolArray
) -> None:
    """Clear the marks of one dancer's points that a geom occludes.

    Args:
        points: (N, 3) in the sensor's frame, with z > 0 where marked [m].
        owner: the dancer that the points belong to.
        body_depth_m: (N,) how deep below the surface of its own body a point may lie and still count as visible [m].
        rows: (G, 3) integers of the geoms.
        shape: (G, `SHAPE_COLUMNS`) from `bounding_shapes` [m].
        projected: (G, `PROJECTED_COLUMNS`) from `project_geoms`.
        visible: (N,) the points to test; cleared in place where a point is occluded.
    """
    candidates = np.zeros((len(rows), CANDIDATE_COLUMNS))
    geoms = np.zeros(len(rows), np.int64)
    count = _select_candidates(points, visible, owner, rows, projected, candidates, geoms)

    for n in range(len(points)):
        if not visible[n]:
            continue

        x = points[n, 0]
        y = points[n, 1]
        z = points[n, 2]
        slope_x = x / z
        slope_y = y / z
        body_share = body_depth_m[n] / sqrt(x * x + y * y + z * z)

        for k in range(count):
            # `&` instead of `and`: one branch per candidate is faster than four.
            hit = (candidates[k, LOW_X] <= slope_x) & (slope_x <= candidates[k, HIGH_X])
            hit &= (candidates[k, LOW_Y] <= slope_y) & (slope_y <= candidates[k, HIGH_Y])
            # Distances are multiples of the vector to the point: the point itself is at 1.
            limit = 1.0 - candidates[k, IS_OWN] * body_share
            if hit & (candidates[k, NEAREST] < limit * z):
                g = geoms[k]
                if _distance_along(rows[g, FORM], shape, projected, g, x, y, z) < limit:
                    visible[n] = False
                    break


@compiled_inner
def _select_candidates(
    points: Array, tested: BoolArray, owner: int, rows: IntArray, projected: Array, candidates: Array, geoms: IntArray
) -> int:
    """Write the geoms that may lie before a dancer's points; return how many.

    A candidate overlaps the bounding rectangle of the tested points and begins before the deepest of them.
    """
    # Bounding rectangle of the points, in slopes, and their largest depth.
    low_x = inf
    low_y = inf
    high_x = -inf
    high_y = -inf
    deepest = -inf
    for n in range(len(points)):
        if tested[n]:
            x = points[n, 0] / points[n, 2]
            y = points[n, 1] / points[n, 2]
            low_x = min(low_x, x)
            high_x = max(high_x, x)
            low_y = min(low_y, y)
            high_y = max(high_y, y)
            deepest = max(deepest, points[n, 2])

    found = 0
    for g in range(len(projected)):
        overlap = (projected[g, BOUNDS + LOW_X] <= high_x) & (low_x <= projected[g, BOUNDS + HIGH_X])
        overlap &= (projected[g, BOUNDS + LOW_Y] <= high_y) & (low_y <= projected[g, BOUNDS + HIGH_Y])
        if overlap & (projected[g, BOUNDS + NEAREST] < deepest):
            # The floor has no bounds and would be a candidate in every frame, although all points are above it.
            if rows[g, FORM] == PLANE and _all_in_front(points, tested, projected, g):
                continue
            for k in range(IS_OWN):
                candidates[found, k] = projected[g, BOUNDS + k]
            candidates[found, IS_OWN] = rows[g, OWNER] == owner
            geoms[found] = g
            found += 1
    return found


@compiled_inner
def _all_in_front(points: Array, tested: BoolArray, projected: Array, g: int) -> bool:
    """Return whether all tested points lie in front of a plane, where it occludes none of them."""
    x = projected[g, AXES + 2]
    y = projected[g, AXES + 5]
    z = projected[g, AXES + 8]
    level = x * projected[g, CENTRE] + y * projected[g, CENTRE + 1] + z * projected[g, CENTRE + 2]

    in_front = True
    for n in range(len(points)):
        if tested[n] and x * points[n, 0] + y * points[n, 1] + z * points[n, 2] < level:
            in_front = False
    return in_front


@compiled_inner
def _distance_along(form: int, shape: Array, projected: Array, g: int, x: float, y: float, z: float) -> float:
    """Return the distance to a geom along a vector from the sensor, as a multiple of this vector."""
    a = projected[g, CENTRE]
    b = projected[g, CENTRE + 1]
    c = projected[g, CENTRE + 2]
    r = projected[g, AXES : AXES + 9]
    return float(
        ray_distance(
            form, shape[g], -(r[0] * a + r[3] * b + r[6] * c), -(r[1] * a + r[4] * b + r[7] * c),
            -(r[2] * a + r[5] * b + r[8] * c), r[0] * x + r[3] * y + r[6] * z, r[1] * x + r[4] * y + r[7] * z,
            r[2] * x + r[5] * y + r[8] * z,
        )
    )  # fmt: skip
