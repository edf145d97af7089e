"""Segmentation: the points above the floor are assigned to the tracked persons, and new persons are found.

Points are (x, height, z): to the sensor's left, above the floor, away from the sensor.
"""

from __future__ import annotations

import math

import numpy as np

from ...core import Array
from ...core.compiled import compiled_entry, compiled_inner
from ..depth_camera import Intrinsics
from .foreground import LOW_OBJECT, UNASSIGNED, Foreground, Owners, Points

REACH_M = 0.85
"""Largest floor distance between a person's trunk and a point of the person: an arm's length (assumed)."""

LOW_M = 0.50
"""Height of a robot: below it only legs belong to a person (assumed)."""

LOW_REACH_M = 0.50
"""Largest floor distance between a trunk and a point of the legs (assumed)."""

LONELY_M = 0.45
"""A point farther than this from the trunk must be near one of the joints, even if nobody else is near (assumed)."""

JOINT_DISTANCE_M = 0.40
"""Largest distance of such a point from the nearest joint (assumed)."""

LOW_OBJECT_M = 0.30
"""Largest floor distance between the middle of a low object and its points (assumed)."""

MAX_NEW_PERSONS = 8
"""Most new persons found in one frame."""

MIN_NEW_HEIGHT_M = 1.2
"""Least height of the highest point of a new person (assumed)."""

NEW_RADIUS_M = 0.3
"""Floor distance from its strongest cell within which a new person's surface counts for its position (assumed)."""

LOW_OBJECT_GAIN = 0.3
"""Share by which the low object's position follows its points in each frame (assumed)."""

_CELL_M = 0.06
"""Edge of a cell of the floor plan."""

_PLAN_X_M = (-3.5, 3.5)
"""Extent of the floor plan in x."""

_PLAN_Z_M = (0.4, 4.6)
"""Extent of the floor plan in z."""

_TORSO_M = (0.75, 1.60)
"""Heights between which surface counts for a new person."""

_WINDOW = 3
"""Half the window, in cells, in which a new person's surface is added up: .42 m, with the cell in its middle."""


@compiled_inner
def _nearest_joint_square(point: Points, joints: Array) -> float:
    """Return the squared distance from a point to the nearest joint [m^2]."""
    best = np.inf
    for j in range(len(joints)):
        x = point[0] - joints[j, 0]
        y = point[1] - joints[j, 1]
        z = point[2] - joints[j, 2]
        best = min(best, x * x + y * y + z * z)
    return best


@compiled_entry
def _assign(count: int, point: Points, positions: Array, joints: Array, low: Array, owner: Owners) -> None:
    """Write ``owner``; see `assign_owners`."""
    for i in range(count):
        is_low = point[i, 1] < LOW_M
        reach = LOW_REACH_M if is_low else REACH_M

        # Nearest trunk within reach, and whether there is another one.
        best = reach * reach
        person = UNASSIGNED
        contested = False
        for k in range(len(positions)):
            x = point[i, 0] - positions[k, 0]
            z = point[i, 2] - positions[k, 1]
            square = x * x + z * z
            if square < reach * reach:
                contested = contested or person >= 0
                if square < best:
                    best = square
                    person = k

        # A leg nearer than the object keeps its point.
        if is_low and not math.isnan(low[0]):
            x = point[i, 0] - low[0]
            z = point[i, 2] - low[1]
            if x * x + z * z < min(best, LOW_OBJECT_M * LOW_OBJECT_M):
                owner[i] = LOW_OBJECT
                continue

        # The nearest joint decides, or tells that the point belongs to somebody else.
        if contested or (person >= 0 and best > LONELY_M * LONELY_M):
            nearest = np.inf if contested else JOINT_DISTANCE_M * JOINT_DISTANCE_M
            person = UNASSIGNED
            for k in range(len(positions)):
                x = point[i, 0] - positions[k, 0]
                z = point[i, 2] - positions[k, 1]
                if x * x + z * z < reach * reach:
                    square = _nearest_joint_square(point[i], joints[k])
                    if square < nearest:
                        nearest = square
                        person = k
        owner[i] = person


def assign_owners(foreground: Foreground, positions: Array, joints: Array, low: Array) -> None:
    """Assign every point to a person, to the low object, or to nobody.

    A point within reach of one person belongs to this person. Within reach of several it belongs to the one with the
    nearest joint, as predicted from the last frame, so that trunks that pass each other at arm's length stay apart. A
    point far from the only trunk within reach must be near one of the joints; otherwise it stays unassigned, because
    somebody new may be standing there.

    Args:
        foreground: gets its owners.
        positions: (P, 2) predicted x and z of the persons' trunks [m].
        joints: (P, 25, 3) predicted joints as points [m].
        low: (2,) x and z of the low object, NaN without one [m].
    """
    _assign(foreground.count, foreground.point, positions, joints, low, foreground.owner)


@compiled_entry
def _fill_floor_plan(count: int, point: Points, owner: Owners, per_pixel: float, area: Array, top: Array) -> None:
    """Add up the unassigned points' surface ``area`` and highest point ``top`` in cells of the floor."""
    for i in range(count):
        if owner[i] != UNASSIGNED or not _TORSO_M[0] < point[i, 1]:
            continue
        a = int((point[i, 0] - _PLAN_X_M[0]) / _CELL_M)
        b = int((point[i, 2] - _PLAN_Z_M[0]) / _CELL_M)
        if 0 <= a < area.shape[0] and 0 <= b < area.shape[1]:
            top[a, b] = max(top[a, b], point[i, 1])
            if point[i, 1] < _TORSO_M[1]:
                area[a, b] += per_pixel * point[i, 2] * point[i, 2]


def _window_sums(area: Array) -> Array:
    """Return the sum of a floor plan in a window around every cell."""
    # Differences of an integral image.
    sums = np.pad(area, _WINDOW).cumsum(axis=0).cumsum(axis=1)
    span = 2 * _WINDOW
    inside = sums[span:, span:] - sums[:-span, span:] - sums[span:, :-span] + sums[:-span, :-span]
    return np.pad(inside, ((0, area.shape[0] - inside.shape[0]), (0, area.shape[1] - inside.shape[1])))


def find_new_persons(
    foreground: Foreground, intrinsics: Intrinsics, min_area_m2: float, separation_m: float
) -> list[tuple[float, float]]:
    """Return where unassigned points are as high as a person and show enough surface.

    Args:
        foreground: points with owners.
        intrinsics: pinhole model of the image.
        min_area_m2: least surface at the height of the trunk, within a window of .42 m.
        separation_m: least distance between two new persons.

    Returns:
        x and z of each [m], the one with the largest surface first; at most `MAX_NEW_PERSONS`.
    """
    shape = (
        round((_PLAN_X_M[1] - _PLAN_X_M[0]) / _CELL_M),
        round((_PLAN_Z_M[1] - _PLAN_Z_M[0]) / _CELL_M),
    )
    area = np.zeros(shape)
    top = np.zeros(shape)
    per_pixel = 1.0 / (intrinsics.fx * intrinsics.fy)
    _fill_floor_plan(foreground.count, foreground.point, foreground.owner, per_pixel, area, top)
    if area.sum() < min_area_m2:
        return []

    inside = _window_sums(area)
    xs = _PLAN_X_M[0] + _CELL_M * (np.arange(shape[0]) + 0.5)
    zs = _PLAN_Z_M[0] + _CELL_M * (np.arange(shape[1]) + 0.5)
    found: list[tuple[float, float]] = []
    while len(found) < MAX_NEW_PERSONS:
        a, b = np.unravel_index(int(inside.argmax()), shape)
        if inside[a, b] < min_area_m2:
            break

        distance = np.hypot(xs[:, None] - xs[a], zs[None] - zs[b])
        near = distance < max(separation_m, _CELL_M)
        weight = np.where(near & (distance < NEW_RADIUS_M), area, 0.0)
        if top[near].max() > MIN_NEW_HEIGHT_M and weight.sum() > 0.0:
            x = float((weight * xs[:, None]).sum() / weight.sum())
            z = float((weight * zs[None]).sum() / weight.sum())
            found.append((x, z))
        # The same surface must not be found a second time.
        inside[near] = 0.0
    return found


@compiled_entry
def _sum_low_points(count: int, point: Points, owner: Owners, before: Array, reach_m: float, sums: Array) -> None:
    """Add up x, z, squared z and the number of low points, near the object's last position if that is known."""
    known = not math.isnan(before[0])
    for i in range(count):
        if owner[i] == LOW_OBJECT or (owner[i] == UNASSIGNED and point[i, 1] < LOW_M):
            x = point[i, 0]
            z = point[i, 2]
            if not known or (x - before[0]) ** 2 + (z - before[1]) ** 2 < reach_m * reach_m:
                sums[0] += x
                sums[1] += z
                sums[2] += z * z
                sums[3] += 1.0


def locate_low_object(foreground: Foreground, before: Array, intrinsics: Intrinsics, min_area_m2: float) -> Array:
    """Return the position of the low object that is no person's leg: most likely a robot.

    Args:
        foreground: points with owners.
        before: (2,) its last position, NaN if unknown [m].
        intrinsics: pinhole model of the image.
        min_area_m2: least surface that it must show.

    Returns:
        (2,) x and z [m]; ``before`` while too little of it is visible.
    """
    sums = np.zeros(4)
    _sum_low_points(foreground.count, foreground.point, foreground.owner, before, 1.5 * LOW_OBJECT_M, sums)
    if sums[3] == 0.0 or sums[2] / (intrinsics.fx * intrinsics.fy) < min_area_m2:
        return before

    middle = sums[:2] / sums[3]
    return middle if math.isnan(before[0]) else np.asarray(before + LOW_OBJECT_GAIN * (middle - before))
