"""Depth correction of trunk joints from the frame-to-frame motion of the surface in front of them.

Votes find a joint to within a centimetre or two, but lean with the body: while a person begins to walk, the estimated
pelvis runs ahead of the true one by a frame or two. The surface in front of a joint moves with it. So a patch of this
surface is remembered, cell by cell, as depth relative to the joint, and the cells of the next frame tell how far the
joint has moved along the view. Cells that something else covers are ignored; those left suffice. The votes correct the
remembered patch slowly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...core import Array
from ...core.compiled import compiled_entry, compiled_inner
from .foreground import Foreground, Owners, Points
from .joint_groups import SPINE_BASE

PATCH_JOINTS = np.array([SPINE_BASE])
"""(A,) joints that have a patch: those whose surface moves with them rigidly."""

CELLS = 8
"""Number of cells across and along a patch (assumed)."""

CELL_M = 0.03
"""Edge of a cell, for a person of the model's size (assumed)."""

GATE_M = 0.06
"""A cell whose depth differs by more than this from the remembered one shows another surface, as an arm (assumed)."""

AGREE_M = 0.015
"""So does a cell that differs by more than this from the median motion of all cells (assumed).

Beside the outline of a passing hand, a cell's mean depth lies between hand and trunk.
"""

MIN_AGREEING_M2 = 0.010
"""Least surface that must agree for a patch to count: a sixth of it (assumed)."""

RELEARN_S = 0.5
"""A cell that has not agreed for this long is learnt anew (assumed)."""

DEPTH_SUM = 0
"""Column of a measured cell: sum of the depths of its points [m]."""

POINTS = 1
"""Column of a measured cell: number of its points."""

RELATIVE_DEPTH = 0
"""Column of a remembered cell: depth relative to the joint, NaN while unknown [m]."""

STALE = 1
"""Column of a remembered cell: time since it last agreed [s]."""

CELL_COLUMNS = 2
"""Number of columns of a cell, measured or remembered."""


class PatchGains(NamedTuple):
    """Filter gains of the depth correction, each from 0 to 1.

    Attributes:
        motion: from the joint's predicted motion to that of its patch.
        learning: from the remembered patch to what the votes say.
        correction: from the joint's depth by the votes to that by the patch.
    """

    motion: float
    learning: float
    correction: float


def initial_patches() -> Array:
    """Return the patches of a new person, (A, C, `CELL_COLUMNS`), of which nothing is known."""
    patches = np.zeros((len(PATCH_JOINTS), CELLS * CELLS, CELL_COLUMNS))
    patches[:, :, RELATIVE_DEPTH] = np.nan
    return patches


@compiled_entry
def _sum_depths(count: int, point: Points, owner: Owners, joints: Array, scales: Array, out: Array) -> None:
    """Add up ``out``, which holds zeros before; see `measure_patches`."""
    middle = CELLS / 2.0
    for i in range(count):
        k = owner[i]
        if k < 0:
            continue
        per_m = 1.0 / (CELL_M * scales[k])
        for a in range(len(PATCH_JOINTS)):
            j = PATCH_JOINTS[a]
            u = (point[i, 0] - joints[k, j, 0]) * per_m + middle
            v = (point[i, 1] - joints[k, j, 1]) * per_m + middle
            if 0.0 <= u < CELLS and 0.0 <= v < CELLS:
                cell = int(v) * CELLS + int(u)
                out[k, a, cell, DEPTH_SUM] += point[i, 2]
                out[k, a, cell, POINTS] += 1.0


def measure_patches(foreground: Foreground, joints: Array, scales: Array) -> Array:
    """Return the depths of all persons' patches in a frame.

    Args:
        foreground: points with owners.
        joints: (P, 25, 3) predicted joints as points, NaN for a new person [m].
        scales: (P,) statures over 1.75 m.

    Returns:
        (P, A, C, `CELL_COLUMNS`) sum of the depths in each cell [m], and number of points.
    """
    out = np.zeros((len(joints), len(PATCH_JOINTS), CELLS * CELLS, CELL_COLUMNS))
    _sum_depths(foreground.count, foreground.point, foreground.owner, joints, scales, out)
    return out


@compiled_inner
def _weighted_median(values: Array, weights: Array) -> float:
    """Return the smallest value that half of the weight does not exceed; infinity without any weight.

    The weights are numbers of points, so their sums are exact in any order. Comparing all pairs is fast enough for the
    few cells of a patch, and sorting would compile ten more functions.
    """
    half = 0.0
    for i in range(len(weights)):
        half += weights[i]
    half *= 0.5

    median = math.inf
    for i in range(len(values)):
        if weights[i] > 0.0 and values[i] < median:
            below = 0.0
            for k in range(len(values)):
                if values[k] <= values[i]:
                    below += weights[k]
            if below >= half:
                median = values[i]
    return median


@compiled_inner
def _patch_motion_m(cells: Array, patch: Array, depth_m: float, min_points: float) -> float:
    """Return how far a patch has moved from its joint's predicted depth; NaN if too few points agree.

    Args:
        cells: (C, `CELL_COLUMNS`) measured cells.
        patch: (C, `CELL_COLUMNS`) remembered cells.
        depth_m: predicted depth of the joint.
        min_points: least number of points that must agree.
    """
    moved = np.zeros(len(cells))
    points = np.zeros(len(cells))
    for c in range(len(cells)):
        n = cells[c, POINTS]
        away = cells[c, DEPTH_SUM] / n - depth_m - patch[c, RELATIVE_DEPTH] if n > 0.0 else math.nan
        if abs(away) < GATE_M:
            moved[c] = away
            points[c] = n

    # The median rejects a minority of cells that something else covers; the mean of the others is more precise.
    median = _weighted_median(moved, points)
    total = 0.0
    agreeing = 0.0
    for c in range(len(cells)):
        if abs(moved[c] - median) < AGREE_M:
            total += points[c] * moved[c]
            agreeing += points[c]
    return total / agreeing if agreeing >= min_points else math.nan


@compiled_inner
def _update_patch(
    cells: Array, patch: Array, depth_m: float, ahead_m: float, gain: float, interval_s: float
) -> None:  # fmt: skip
    """Correct a remembered patch in place.

    Args:
        cells: (C, `CELL_COLUMNS`) measured cells.
        patch: (C, `CELL_COLUMNS`) remembered cells.
        depth_m: estimated depth of the joint.
        ahead_m: how much farther away the joint is than the votes say.
        gain: share of each correction that is made.
        interval_s: time since the last frame.
    """
    for c in range(len(cells)):
        patch[c, RELATIVE_DEPTH] += gain * ahead_m
        patch[c, STALE] += interval_s
        n = cells[c, POINTS]
        if n == 0.0:
            continue

        error = cells[c, DEPTH_SUM] / n - depth_m - patch[c, RELATIVE_DEPTH]
        if abs(error) < GATE_M:
            patch[c, RELATIVE_DEPTH] += gain * error
            patch[c, STALE] = 0.0
        elif math.isnan(error) or patch[c, STALE] > RELEARN_S:
            patch[c, RELATIVE_DEPTH] = cells[c, DEPTH_SUM] / n - depth_m
            patch[c, STALE] = 0.0


@compiled_entry
def _correct(
    cells: Array, patches: Array, predicted: Array, voted: Array, min_points: float, motion_gain: float,
    learning_gain: float, correction_gain: float, interval_s: float, joints: Array,
) -> None:  # fmt: skip
    """Change ``patches`` and ``joints``; see `correct_depth_from_surface`."""
    for a in range(len(PATCH_JOINTS)):
        j = PATCH_JOINTS[a]
        moved = _patch_motion_m(cells[a], patches[a], predicted[j, 2], min_points)
        if not math.isnan(moved):
            joints[j, 2] += correction_gain * (predicted[j, 2] + motion_gain * moved - joints[j, 2])
        ahead = joints[j, 2] - voted[j, 2]
        if math.isnan(ahead):
            ahead = 0.0
        _update_patch(cells[a], patches[a], joints[j, 2], ahead, learning_gain, interval_s)


def correct_depth_from_surface(
    cells: Array,
    patches: Array,
    predicted: Array,
    voted: Array,
    min_points: float,
    gains: PatchGains,
    interval_s: float,
    joints: Array,
) -> None:
    """Correct the depth of a person's joints by the motion of their patches.

    Args:
        cells: (A, C, `CELL_COLUMNS`) the person's measured cells, from `measure_patches`.
        patches: (A, C, `CELL_COLUMNS`) the remembered patches, changed in place.
        predicted: (25, 3) predicted joints that the cells were measured for [m].
        voted: (25, 3) joints by the votes; NaN where they do not count [m].
        min_points: least number of points of a patch that must agree.
        gains: filter gains.
        interval_s: time since the last frame.
        joints: (25, 3) joints of this frame, changed in place [m].
    """
    _correct(cells, patches, predicted, voted, min_points, *gains, interval_s, joints)
