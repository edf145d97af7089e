"""Pixels down a forest: what its nodes ask, and the leaf that each tree gives.

Source: shotton2013, section 3 (depth differences at offsets that shrink with distance).

All trees of a pixel descend together, in whole numbers and without branching on an answer: a processor that guesses
wrong at every other node, or waits for one image access after the other, takes several times as long.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..types import Array
from .segmentation import Foreground, Image, Pixels, Points

CLIP_MM = 600
"""Depth differences beyond this say only: something else, before or behind (assumed)."""
EXTRAS = 9
"""Features beyond the probes: height, x and z from the trunk, chest width, scale; then, for the joints' forest only,
steps forward and to the left of the trunk, cosine and sine of the yaw."""
YAW_EXTRAS = 5
FINE = 10_000
"""Extra features are whole numbers of this part of a metre, or of one."""
THRESHOLD, OFFSETS, CHILD, EXTRA, LEAF, COLUMNS = 0, 1, 5, 6, 7, 8
"""Columns of a node: answers up to the first go to the left child, others to the node after it [mm, or `FINE`]; two
offsets to the left and up [mm]; the left child, or the node itself for a leaf; 1 + the extra feature asked for, or 0;
the leaf's number."""

Nodes = NDArray[np.int16]
Leaves = NDArray[np.int32]
Row = NDArray[np.float32]
_ONE, _HALF, _BITS = np.int32(65536), np.int32(32768), np.int32(16)


@njit(cache=True, error_model="numpy", inline="always")
def _depth(image: Image, v: np.int32, u: np.int32, z: np.int32, left: np.int32, up: np.int32) -> np.int32:
    """Depth difference between a point and a pixel, clipped [mm].

    Everything but depth is in 1/65536 of a pixel: ``v`` and ``u`` the pixel's middle, with the rim counted, and how
    far the point is to the left of it and above. Whatever lies farther out is as far as the image's rim.
    """
    row, column = np.int32((v - up) >> _BITS), np.int32((u + left) >> _BITS)
    row = min(max(row, np.int32(0)), np.int32(image.shape[0] - 1))
    column = min(max(column, np.int32(0)), np.int32(image.shape[1] - 1))
    off = np.int32(image[np.uint32(row), np.uint32(column)]) - z
    return min(max(off, np.int32(-CLIP_MM)), np.int32(CLIP_MM))


@njit(cache=True, error_model="numpy")
def extras(p: Row, person: Row, out: Leaves) -> None:
    """Write the features beyond the probes from ``out[1]`` on, in the order that `EXTRAS` tells."""
    scale, cos, sin = person[3], person[4], person[5]
    x, z = (p[0] - person[0]) / scale, (p[2] - person[1]) / scale
    fine = np.float32(FINE)
    out[1] = np.int32(fine * p[1] / scale)
    out[2], out[3] = np.int32(fine * x), np.int32(fine * z)
    out[4], out[5] = np.int32(fine * person[2]), np.int32(fine * scale)
    out[6], out[7] = np.int32(fine * (-sin * x - cos * z)), np.int32(fine * (sin * z - cos * x))
    out[8], out[9] = np.int32(fine * cos), np.int32(fine * sin)


@njit(cache=True, error_model="numpy")
def descend(nodes: Nodes, image: Image, v: int, u: int, reach: float, extra: Leaves, at: Leaves) -> None:
    """Follow a pixel from the nodes ``at`` to its leaves.

    Args:
        nodes: (N, 8) all trees, see `COLUMNS`.
        image: (H + 2, W + 2) depth with a rim [mm].
        v: the pixel's row, without the rim.
        u: its column.
        reach: pixels per metre of the model's person at that depth.
        extra: (10,) from `extras`.
        at: (T,) roots, and afterwards the nodes of the leaves.
    """
    z = np.int32(image[v + 1, u + 1])
    row, column = np.int32(v + 1) * _ONE + _HALF, np.int32(u + 1) * _ONE + _HALF
    per_mm = np.int32(reach * np.float32(65.536))
    moving = True
    while moving:
        moving = False
        for t in range(len(at)):
            node = nodes[np.uint32(at[t])]
            answer = _depth(image, row, column, z, np.int32(node[1]) * per_mm, np.int32(node[2]) * per_mm)
            answer -= _depth(image, row, column, z, np.int32(node[3]) * per_mm, np.int32(node[4]) * per_mm)
            answer += extra[np.uint32(node[EXTRA])]
            child = np.int32(node[CHILD]) + np.int32(answer > np.int32(node[THRESHOLD]))
            moving |= child != at[t]
            at[t] = child


@njit(cache=True, error_model="numpy")
def _answers(
    probes: Nodes, image: Image, pixel: Pixels, point: Points, rows: NDArray[np.int64], fx: np.float32, person: Row,
    out: NDArray[np.float32],
) -> None:  # fmt: skip
    extra = np.zeros(1 + EXTRAS, np.int32)
    for q in range(len(rows)):
        i = rows[q]
        v, u = pixel[i, 0] + 1, pixel[i, 1] + 1
        z = np.int32(image[v, u])
        row, column = np.int32(v) * _ONE + _HALF, np.int32(u) * _ONE + _HALF
        per_mm = np.int32(fx * person[3] / point[i, 2] * np.float32(65.536))
        for k in range(len(probes)):
            first = _depth(image, row, column, z, np.int32(probes[k, 0]) * per_mm, np.int32(probes[k, 1]) * per_mm)
            other = _depth(image, row, column, z, np.int32(probes[k, 2]) * per_mm, np.int32(probes[k, 3]) * per_mm)
            out[q, k] = np.float32(0.001) * np.float32(first - other)
        extras(point[i], person, extra)
        for k in range(EXTRAS):
            out[q, len(probes) + k] = np.float32(extra[1 + k]) / np.float32(FINE)


def answers(
    scene: Foreground, rows: NDArray[np.int64], probes: NDArray[np.float16], fx: float, person: Array
) -> Points:
    """All features of some points, for training.

    Args:
        scene: the frame.
        rows: (Q,) rows of its points.
        probes: (F, 4) offsets [m].
        fx: focal length over the width of a pixel.
        person: (6,) x, z, chest width [m], scale, cosine and sine of the yaw.

    Returns:
        (Q, F + 9) features [m, or one].
    """
    out = np.empty((len(rows), len(probes) + EXTRAS), np.float32)
    rough = person.astype(np.float32)
    _answers(_whole(probes), scene.image, scene.pixel, scene.point, rows, np.float32(fx), rough, out)
    return out


def _whole(probes: NDArray[np.float16]) -> Nodes:
    return np.asarray(np.rint(1000.0 * probes.astype(float)), dtype=np.int16)


def packed(
    probes: NDArray[np.float16], feature: NDArray[np.uint8], threshold: NDArray[np.float16], left: NDArray[np.int16],
    right: NDArray[np.int16], roots: NDArray[np.int16],
) -> tuple[Nodes, Leaves]:  # fmt: skip
    """Nodes as `descend` takes them, children side by side, and their roots; arguments as in `model.Model`."""
    order = [int(root) for root in roots]
    for k in order:
        if left[k] >= 0:
            order += [int(left[k]), int(right[k])]
    old = np.array(order)
    new = np.empty(len(left), np.int64)
    new[old] = np.arange(len(old))
    asks, child = feature[old].astype(np.int64), left[old].astype(np.int64)
    leaf, extra = child < 0, asks >= len(probes)
    limit = np.iinfo(np.int16).max
    node = np.zeros((len(old), COLUMNS), np.int16)
    bound = np.floor(np.where(extra, FINE, 1000) * threshold[old].astype(float))
    node[:, THRESHOLD] = np.where(leaf, limit, np.clip(bound, -limit, limit))
    offsets = _whole(probes)[np.where(extra, 0, asks)]
    node[:, OFFSETS:CHILD] = np.where((extra | leaf)[:, None], 0, offsets)
    node[:, CHILD] = np.where(leaf, np.arange(len(old)), new[child])
    node[:, EXTRA] = np.where(extra & ~leaf, 1 + asks - len(probes), 0)
    node[:, LEAF] = np.where(leaf, -1 - child, -1)
    return node, np.arange(len(roots), dtype=np.int32)
