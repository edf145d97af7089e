"""The trunk's motion along the view, from the depth of its own surface.

Votes find a joint to a centimetre or two, but lean with the body: while somebody begins to walk, the pelvis that they
see runs ahead of the true one by a frame or two. The surface before a joint moves with it. So a patch of it is
remembered, cell by cell, as depth beyond the joint, and the next frame's cells tell how far the joint has come; cells
that something else covers say nothing, and those left suffice. Votes correct what is remembered, slowly.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ...assets.names import JOINT_INDEX
from ...core import Array
from .segmentation import Foreground, Owners, Points

PATCH_JOINTS = np.array([JOINT_INDEX["SpineBase"]])
"""(A,) joints that have a patch: those whose surface moves with them as one."""
CELLS, CELL_M = 8, 0.03
"""A patch is so many cells wide and high; a cell has this size times the person's scale (assumed)."""
GATE_M, AGREE_M = 0.06, 0.015
"""A cell's depth farther from what is remembered is something else's, such as an arm's; and so is one farther than the
second from where most cells say that the surface has come: beside the outline of a hand that passes, a cell's mean
lies between the hand and the trunk (assumed)."""
MIN_AGREEING_M2 = 0.010
"""Surface that must agree for a patch to be believed: a sixth of it (assumed)."""
RELEARN_S = 0.5
"""A cell that has not agreed for so long is learnt anew (assumed)."""
_SUM, _POINTS = range(2)
_BEYOND, _STALE_S = range(2)


def initial_patches() -> Array:
    """What is remembered of somebody new.

    Returns:
        (A, C, 2) each cell's depth beyond its joint, NaN while it is not known [m], and since when it has not agreed
        [s].
    """
    known = np.zeros((len(PATCH_JOINTS), CELLS * CELLS, 2))
    known[:, :, _BEYOND] = np.nan
    return known


@njit(cache=True, error_model="numpy")
def _gather(
    count: int, point: Points, owner: Owners, joints: Array, scales: Array, anchored: Array, out: Array
) -> None:  # fmt: skip
    middle = CELLS / 2.0
    for i in range(count):
        k = owner[i]
        if k < 0:
            continue
        per = 1.0 / (CELL_M * scales[k])
        for a in range(len(anchored)):
            joint = joints[k, anchored[a]]
            u, v = (point[i, 0] - joint[0]) * per + middle, (point[i, 1] - joint[1]) * per + middle
            if 0.0 <= u < CELLS and 0.0 <= v < CELLS:
                cell = out[k, a, int(v) * CELLS + int(u)]
                cell[_SUM] += point[i, 2]
                cell[_POINTS] += 1.0


def measure_patches(scene: Foreground, joints: Array, scales: Array) -> Array:
    """Depths of the patches' cells in a frame.

    Args:
        scene: with owners.
        joints: (P, 25, 3) predicted joints as points, NaN for somebody new [m].
        scales: (P,) stature over 1.75 m.

    Returns:
        (P, A, C, 2) sum of the depths in each cell [m], and number of its points.
    """
    out = np.zeros((len(joints), len(PATCH_JOINTS), CELLS * CELLS, 2))
    _gather(scene.count, scene.point, scene.owner, joints, scales, PATCH_JOINTS, out)
    return out


@njit(cache=True, error_model="numpy")
def _median(values: Array, weights: Array) -> float:
    """Of the values, the one that half of the weight does not exceed."""
    below, half = 0.0, 0.5 * weights.sum()
    for i in np.argsort(values):
        below += weights[i]
        if below >= half:
            return float(values[i])
    return math.nan


@njit(cache=True, error_model="numpy")
def _moved(cells: Array, known: Array, depth_m: float, least: float) -> float:
    """How far one patch (C, 2) has come from its joint's predicted depth; NaN where too few points agree."""
    off, points = np.zeros(len(cells)), np.zeros(len(cells))
    for c in range(len(cells)):
        n = cells[c, _POINTS]
        away = cells[c, _SUM] / n - depth_m - known[c, _BEYOND] if n > 0.0 else math.nan
        if abs(away) < GATE_M:
            off[c], points[c] = away, n
    agree = points * (np.abs(off - _median(off, points)) < AGREE_M)
    return float((agree * off).sum() / agree.sum()) if agree.sum() >= least else math.nan


@njit(cache=True, error_model="numpy")
def _learn(cells: Array, known: Array, depth_m: float, ahead_m: float, share: float, interval_s: float) -> None:
    """Correct one patch (C, 2); ``ahead_m`` is how much farther away its joint is than votes say."""
    for c in range(len(cells)):
        known[c, _BEYOND] += share * ahead_m
        known[c, _STALE_S] += interval_s
        n = cells[c, _POINTS]
        if n == 0.0:
            continue
        off = cells[c, _SUM] / n - depth_m - known[c, _BEYOND]
        if abs(off) < GATE_M:
            known[c, _BEYOND] += share * off
            known[c, _STALE_S] = 0.0
        elif math.isnan(off) or known[c, _STALE_S] > RELEARN_S:
            known[c, _BEYOND] = cells[c, _SUM] / n - depth_m
            known[c, _STALE_S] = 0.0


@njit(cache=True, error_model="numpy")
def _anchor(
    cells: Array, known: Array, anchored: Array, predicted: Array, voted: Array, least: float, shares: Array,
    interval_s: float, joints: Array,
) -> None:  # fmt: skip
    for a in range(len(anchored)):
        j = anchored[a]
        moved = _moved(cells[a], known[a], predicted[j, 2], least)
        if not math.isnan(moved):
            joints[j, 2] += shares[2] * (predicted[j, 2] + shares[0] * moved - joints[j, 2])
        ahead = joints[j, 2] - voted[j, 2]
        _learn(cells[a], known[a], joints[j, 2], 0.0 if math.isnan(ahead) else ahead, shares[1], interval_s)


def correct_depth_from_surface(
    cells: Array, known: Array, predicted: Array, voted: Array, least: float, shares: Array, interval_s: float,
    joints: Array,
) -> None:  # fmt: skip
    """Put a person's anchored joints where their patches have come to, along the view.

    Args:
        cells: (A, C, 2) the person's, from `gathered`.
        known: (A, C, 2) what is remembered, changed in place.
        predicted: (25, 3) joints that the cells were gathered for [m].
        voted: (25, 3) where votes agree; NaN where they do not count [m].
        least: points that must agree.
        shares: (3,) of the way to go from the predicted motion to the patches', from what is remembered of the
            patches to what the votes say, and from the joint as it was found to where the patch puts it.
        interval_s: since the last frame.
        joints: (25, 3) joints of this frame, changed in place [m].
    """
    _anchor(cells, known, PATCH_JOINTS, predicted, voted, least, shares, interval_s, joints)
