"""Which points something hides from an eye, compiled.

Everything is looked at in the eye's own frame: x and y across, z away from it. A ray to a point is a pair of slopes
there, x / z and y / z, and every solid has an outline: a rectangle of slopes that holds it, and how near it comes. A
solid whose outline a ray misses, or that begins behind the point, cannot hide it; the others the ray is held against.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
from numba import njit

from ...core import Array, BoolArray, IntArray
from .primitives import BOX, CAPSULE, CYLINDER, ELLIPSOID, PLANE, ray_distance

ROW, OWNER, FORM = 0, 1, 2
"""Columns of the whole numbers of `types.Solids`."""

BOX_M, BALL_M, SHAPE = 3, 6, 7
"""Columns of their shapes after the size: half edges of a box, and the radius of a ball round each of its points."""

CENTRE, AXES, OUTLINE, PROJECTED_COLUMNS = 0, 3, 12, 17
"""Columns of a solid as an eye has it: centre [m], rotation (eye from solid, row-major), then the outline."""

LOW_X, HIGH_X, LOW_Y, HIGH_Y, NEAREST, OWN, NUMBERS = 0, 1, 2, 3, 4, 5, 6
"""An outline's numbers: least and largest slopes, nearest depth [m]; and among a person's, whether it is their own."""

_SLACK_M = 1e-9
"""Outlines are wider by this, whatever rounding does."""


def bounding_shapes(forms: IntArray, sizes: Array) -> Array:
    """(G, `SHAPE`) sizes, and for each solid a box and a ball: it lies within the ball round some point of the box.

    Args:
        forms: (G,) MuJoCo's numbers.
        sizes: (G, 3) MuJoCo's sizes [m].
    """
    out = np.zeros((len(forms), SHAPE))
    out[:, :BOX_M] = sizes
    edged, long = np.isin(forms, (ELLIPSOID, BOX)), np.isin(forms, (CAPSULE, CYLINDER))
    out[edged, BOX_M:BALL_M] = sizes[edged]
    out[long, BALL_M - 1] = sizes[long, 1]
    out[~edged, BALL_M] = sizes[~edged, 0]
    out[forms == PLANE, BALL_M] = inf
    return out


@njit(cache=True, error_model="numpy")
def project_geoms(eye: Array, rows: IntArray, shape: Array, position: Array, rotation: Array, seen: Array) -> None:
    """Write how an eye has every solid.

    Args:
        eye: (12,) or more: rotation from the world into its frame, row-major, and its place [m].
        rows: of `types.Solids`, as the next three.
        shape: sizes, and what bounds them.
        position: centres in the world [m].
        rotation: world from solid.
        seen: (G, `COLUMNS`) output.
    """
    half = np.empty(3)
    for g in range(len(rows)):
        at = rows[g, ROW]
        x, y, z = position[at, 0] - eye[9], position[at, 1] - eye[10], position[at, 2] - eye[11]
        for i in range(3):
            a, b, c = eye[3 * i], eye[3 * i + 1], eye[3 * i + 2]
            seen[g, CENTRE + i] = a * x + b * y + c * z
            half[i] = shape[g, BALL_M] + _SLACK_M
            for j in range(3):
                turn = a * rotation[at, j] + b * rotation[at, 3 + j] + c * rotation[at, 6 + j]
                seen[g, AXES + 3 * i + j] = turn
                half[i] += abs(turn) * shape[g, BOX_M + j]
        _outline(seen, g, half)


@njit(cache=True, error_model="numpy")
def _outline(seen: Array, g: int, half: Array) -> None:
    """Write the outline of what lies within half widths of its centre; endless if it reaches the eye's own plane."""
    near, far = seen[g, CENTRE + 2] - half[2], seen[g, CENTRE + 2] + half[2]
    seen[g, OUTLINE + NEAREST] = near if far > 0.0 else inf
    for i in range(2):
        low, high = -inf, inf
        if near > 0.0:
            low, high = seen[g, CENTRE + i] - half[i], seen[g, CENTRE + i] + half[i]
            low, high = low / (far if low > 0.0 else near), high / (near if high > 0.0 else far)
        seen[g, OUTLINE + 2 * i], seen[g, OUTLINE + 2 * i + 1] = low, high


@njit(cache=True, error_model="numpy")
def mark_occluded(
    points: Array, owner: int, flesh_m: Array, rows: IntArray, shape: Array, seen: Array, visible: BoolArray
) -> None:
    """Clear the marks of those of one person's points that something hides.

    Args:
        points: (N, 3) in the eye's frame; before it, where marked [m].
        owner: whose they are.
        flesh_m: (N,) how deep below its owner's surface a point may lie and still be seen.
        rows: of `types.Solids`, as the next.
        shape: sizes, and what bounds them.
        seen: what `outlines` wrote.
        visible: (N,) which points are looked for; cleared where one is hidden.
    """
    near, places = np.empty((len(rows), NUMBERS)), np.empty(len(rows), np.int64)
    found = _before(points, visible, owner, rows, seen, near, places)
    for n in range(len(points)):
        if not visible[n]:
            continue
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        slope_x, slope_y = x / z, y / z
        flesh = flesh_m[n] / sqrt(x * x + y * y + z * z)
        for k in range(found):
            across = (near[k, LOW_X] <= slope_x) & (slope_x <= near[k, HIGH_X])
            across &= (near[k, LOW_Y] <= slope_y) & (slope_y <= near[k, HIGH_Y])
            limit = 1.0 - near[k, OWN] * flesh
            if across & (near[k, NEAREST] < limit * z):
                g = places[k]
                if _distance(rows[g, FORM], shape, seen, g, x, y, z) < limit:
                    visible[n] = False
                    break


@njit(cache=True, error_model="numpy")
def _before(
    points: Array, wanted: BoolArray, owner: int, rows: IntArray, seen: Array, near: Array, places: IntArray
) -> int:
    """Write the outlines that reach before the rectangle of a person's points, and their places; returns how many."""
    low_x = low_y = inf
    high_x = high_y = deepest = -inf
    for n in range(len(points)):
        if wanted[n]:
            x, y = points[n, 0] / points[n, 2], points[n, 1] / points[n, 2]
            low_x, high_x, low_y, high_y = min(low_x, x), max(high_x, x), min(low_y, y), max(high_y, y)
            deepest = max(deepest, points[n, 2])
    found = 0
    for g in range(len(seen)):
        across = (seen[g, OUTLINE + LOW_X] <= high_x) & (low_x <= seen[g, OUTLINE + HIGH_X])
        across &= (seen[g, OUTLINE + LOW_Y] <= high_y) & (low_y <= seen[g, OUTLINE + HIGH_Y])
        if across & (seen[g, OUTLINE + NEAREST] < deepest):
            if rows[g, FORM] == PLANE and _above(points, wanted, seen, g):
                continue
            for k in range(OWN):
                near[found, k] = seen[g, OUTLINE + k]
            near[found, OWN] = rows[g, OWNER] == owner
            places[found] = g
            found += 1
    return found


@njit(cache=True, error_model="numpy")
def _above(points: Array, wanted: BoolArray, seen: Array, g: int) -> bool:
    """Whether all wanted points are on a plane's front, where it hides none of them."""
    x, y, z = seen[g, AXES + 2], seen[g, AXES + 5], seen[g, AXES + 8]
    level = x * seen[g, CENTRE] + y * seen[g, CENTRE + 1] + z * seen[g, CENTRE + 2]
    for n in range(len(points)):
        if wanted[n] and x * points[n, 0] + y * points[n, 1] + z * points[n, 2] < level:
            return False
    return True


@njit(cache=True, error_model="numpy")
def _distance(form: int, shape: Array, seen: Array, g: int, x: float, y: float, z: float) -> float:
    """Distance to a solid along a vector from the eye, in multiples of it."""
    a, b, c, r = seen[g, CENTRE], seen[g, CENTRE + 1], seen[g, CENTRE + 2], seen[g, AXES : AXES + 9]
    return float(
        ray_distance(
            form, shape[g], -(r[0] * a + r[3] * b + r[6] * c), -(r[1] * a + r[4] * b + r[7] * c),
            -(r[2] * a + r[5] * b + r[8] * c), r[0] * x + r[3] * y + r[6] * z, r[1] * x + r[4] * y + r[7] * z,
            r[2] * x + r[5] * y + r[8] * z,
        )
    )  # fmt: skip
