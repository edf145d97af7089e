"""Position and size of each person, measured from all of its pixels together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core import Array
from ...core.compiled import compiled_entry, compiled_inner
from .foreground import Foreground, Owners, Points
from .trained_model import MODEL_STATURE_M

CROWN_M2 = 0.002
"""Surface of a person above the height that counts as the crown; it is the same from any side of a head (assumed)."""

PERSON_MEASURES = 5
"""Number of columns of `measure_persons`."""

_BIN_M = 0.01
"""Width of a bin of the histograms of positions."""

_BINS = 200
"""Number of bins across and along: 1 m to each side of the predicted trunk."""

_HEIGHT_BINS = 240
"""Number of bins of heights."""

_MIN_POINTS = 12
"""Fewest points of the trunk from which its position is measured."""

_TRUNK_HEIGHT = (0.42, 0.80)
"""Heights of the trunk, over stature."""

_CHEST_HEIGHT = (0.60, 0.72)
"""Heights of the chest, over stature."""


@compiled_inner
def _total(histogram: NDArray[np.int32]) -> int:
    """Return the number of entries of a histogram."""
    total = 0
    for k in range(len(histogram)):
        total += histogram[k]
    return total


@compiled_inner
def _quantile(histogram: NDArray[np.int32], share_below: float) -> float:
    """Return the position, in bins, below which a share of a histogram's entries lies; 0 if it is empty."""
    goal = share_below * _total(histogram)
    below = 0.0
    for k in range(len(histogram)):
        if histogram[k] and below + histogram[k] >= goal:
            return float(k + (goal - below) / histogram[k])
        below += histogram[k]
    return 0.0


@compiled_entry
def _measure(
    count: int, point: Points, owner: Owners, positions: Array, scales: Array, per_pixel: float, out: Array
) -> None:
    """Write ``out``, which holds zeros before; see `measure_persons`."""
    persons = len(positions)
    across = np.zeros((persons, _BINS), np.int32)
    along = np.zeros((persons, _BINS), np.int32)
    chest = np.zeros((persons, _BINS), np.int32)
    heights = np.zeros((persons, _HEIGHT_BINS), np.int32)
    done = np.zeros(persons, np.bool_)

    # The trunk's points are used, or all points of a person whose trunk is occluded.
    for lowest in (_TRUNK_HEIGHT[0], 0.0):
        for i in range(count):
            k = owner[i]
            if k < 0 or done[k]:
                continue
            # Bins around the predicted trunk.
            x = int((point[i, 0] - positions[k, 0]) / _BIN_M + 0.5 * _BINS)
            z = int((point[i, 2] - positions[k, 1]) / _BIN_M + 0.5 * _BINS)
            if lowest > 0.0:
                out[k, 0] += 1.0
                heights[k, min(int(point[i, 1] / _BIN_M), _HEIGHT_BINS - 1)] += 1

            height = point[i, 1] / (MODEL_STATURE_M * scales[k])
            in_trunk = lowest == 0.0 or lowest < height < _TRUNK_HEIGHT[1]
            if 0 <= x < _BINS and 0 <= z < _BINS and in_trunk:
                across[k, x] += 1
                along[k, z] += 1
                if _CHEST_HEIGHT[0] < height < _CHEST_HEIGHT[1]:
                    chest[k, x] += 1

        all_done = True
        for k in range(persons):
            done[k] = out[k, 0] == 0.0 or _total(across[k]) >= _MIN_POINTS
            all_done = all_done and done[k]
        if all_done:
            break

    for k in range(persons):
        if out[k, 0] == 0.0:
            continue
        out[k, 1] = positions[k, 0] + (_quantile(across[k], 0.5) - 0.5 * _BINS) * _BIN_M
        out[k, 2] = positions[k, 1] + (_quantile(along[k], 0.5) - 0.5 * _BINS) * _BIN_M
        # A fixed surface above the crown, as a share of the person's points at this depth.
        above = CROWN_M2 / (per_pixel * out[k, 2] ** 2 * _total(heights[k]))
        out[k, 3] = _quantile(heights[k], 1.0 - min(above, 0.5)) * _BIN_M
        # Quantiles, because single points of the arms reach the height of the chest.
        out[k, 4] = (_quantile(chest[k], 0.9) - _quantile(chest[k], 0.1)) * _BIN_M


def measure_persons(foreground: Foreground, positions: Array, scales: Array, per_pixel: float) -> Array:
    """Return position and size of each person from its pixels as a whole.

    Args:
        foreground: points with owners.
        positions: (P, 2) predicted x and z of the trunks [m].
        scales: (P,) statures over 1.75 m.
        per_pixel: surface that a pixel shows at a depth of 1 m [m^2].

    Returns:
        (P, `PERSON_MEASURES`) number of points, median x and z of the trunk's surface, height of the crown, width of
        the chest [m]; all 0 for a person without points.
    """
    out = np.zeros((len(positions), PERSON_MEASURES))
    if len(positions):
        _measure(foreground.count, foreground.point, foreground.owner, positions, scales, per_pixel, out)
    return out
