"""Pixels down a forest: what its nodes ask, and the leaf that each tree gives.

Source: shotton2013, section 3 (depth differences at offsets that shrink with distance).

All trees of a pixel descend together, in whole numbers and without branching on an answer: a processor that guesses
wrong at every other node, or waits for one image access after the other, takes several times as long.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...core import Array
from .segmentation import Foreground, Image, Pixels, Points

CLIP_MM = 600
"""Depth differences beyond this say only: something else, before or behind (assumed)."""
EXTRA_FEATURES = 9
"""Features beyond the probes: height, x and z from the trunk, chest width, scale; then, for the joints' forest only,
steps forward and to the left of the trunk, cosine and sine of the yaw."""
YAW_EXTRA_FEATURES = 5
FINE = 10_000
"""Extra features are whole numbers of this part of a metre, or of one."""
THRESHOLD, OFFSETS, CHILD, EXTRA, LEAF, NODE_COLUMNS = 0, 1, 5, 6, 7, 8
"""Columns of a node: answers up to the first go to the left child, others to the node after it [mm, or `FINE`]; two
offsets to the left and up [mm]; the left child, or the node itself for a leaf; 1 + the extra feature asked for, or 0;
the leaf's number."""

Nodes = NDArray[np.int16]
Leaves = NDArray[np.int32]
Row = NDArray[np.float32]
_ONE, _HALF, _BITS = np.int32(65536), np.int32(32768), np.int32(16)


@njit(cache=True, error_model="numpy", inline="always")
def _depth(
    image: Image, last_v: np.uint32, last_u: np.uint32, v: np.int32, u: np.int32, near: np.int32, far: np.int32
) -> np.int32:
    """Depth at a place in the image, between two bounds [mm].

    Places are in 1/65536 of a pixel, the rim counted. Whatever lies out of the image is as far as its rim, on any
    side: a negative number taken for one without a sign is beyond the last row or column, too.
    """
    row, column = min(np.uint32(v >> _BITS), last_v), min(np.uint32(u >> _BITS), last_u)
    return min(max(np.int32(image[row, column]), near), far)


@njit(cache=True, error_model="numpy", inline="always")
def _probed(
    image: Image, last_v: np.uint32, last_u: np.uint32, v: np.int32, u: np.int32, near: np.int32, far: np.int32,
    per_mm: np.int32, left: int, up: int, other_left: int, other_up: int,
) -> np.int32:  # fmt: skip
    """Difference of the depths at two offsets [mm] from a point, each no farther from its own than `CLIP_MM` [mm]."""
    first = _depth(image, last_v, last_u, v - np.int32(up) * per_mm, u + np.int32(left) * per_mm, near, far)
    other_v, other_u = v - np.int32(other_up) * per_mm, u + np.int32(other_left) * per_mm
    off: np.int32 = first - _depth(image, last_v, last_u, other_v, other_u, near, far)
    return off


@njit(cache=True, error_model="numpy", inline="always")
def write_extra_features(p: Row, person: Row, out: Leaves) -> None:
    """Write the features beyond the probes from ``out[1]`` on, in the order that `EXTRAS` tells."""
    scale, cos, sin = person[3], person[4], person[5]
    x, z = (p[0] - person[0]) / scale, (p[2] - person[1]) / scale
    fine = np.float32(FINE)
    out[1] = np.int32(fine * p[1] / scale)
    out[2], out[3] = np.int32(fine * x), np.int32(fine * z)
    out[4], out[5] = np.int32(fine * person[2]), np.int32(fine * scale)
    out[6], out[7] = np.int32(fine * (-sin * x - cos * z)), np.int32(fine * (sin * z - cos * x))
    out[8], out[9] = np.int32(fine * cos), np.int32(fine * sin)


@njit(cache=True, error_model="numpy", inline="always")
def _child(
    nodes: Nodes, at: np.int32, image: Image, last_v: np.uint32, last_u: np.uint32, v: np.int32, u: np.int32,
    near: np.int32, far: np.int32, per_mm: np.int32, extra: Leaves,
) -> np.int32:  # fmt: skip
    """The node that follows one; a leaf follows itself."""
    n = np.uint32(at)
    answer = extra[np.uint32(nodes[n, EXTRA])] + _probed(
        image, last_v, last_u, v, u, near, far, per_mm, nodes[n, 1], nodes[n, 2], nodes[n, 3], nodes[n, 4]
    )
    return np.int32(nodes[n, CHILD]) + np.int32(answer > np.int32(nodes[n, THRESHOLD]))


@njit(cache=True, error_model="numpy", inline="always")
def find_leaves(nodes: Nodes, image: Image, v: int, u: int, reach: float, extra: Leaves, at: Leaves) -> None:
    """Follow a pixel from the nodes ``at`` to its leaves.

    Three trees at a time, so that each node is in a register: with more, or in an array, it takes twice as long.

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
    near, far = z - np.int32(CLIP_MM), z + np.int32(CLIP_MM)
    last_v, last_u = np.uint32(image.shape[0] - 1), np.uint32(image.shape[1] - 1)
    row, column = np.int32(v + 1) * _ONE + _HALF, np.int32(u + 1) * _ONE + _HALF
    per_mm = np.int32(reach * np.float32(65.536))
    for t in range(0, len(at), 3):
        second, third = min(t + 1, len(at) - 1), min(t + 2, len(at) - 1)
        a, b, c = at[t], at[second], at[third]
        while True:
            d = _child(nodes, a, image, last_v, last_u, row, column, near, far, per_mm, extra)
            e = _child(nodes, b, image, last_v, last_u, row, column, near, far, per_mm, extra)
            f = _child(nodes, c, image, last_v, last_u, row, column, near, far, per_mm, extra)
            if (a ^ d) | (b ^ e) | (c ^ f) == 0:
                break
            a, b, c = d, e, f
        at[t], at[second], at[third] = a, b, c


@njit(cache=True, error_model="numpy")
def _answers(
    probes: Nodes, image: Image, pixel: Pixels, point: Points, rows: NDArray[np.int64], fx: np.float32, person: Row,
    out: NDArray[np.float32],
) -> None:  # fmt: skip
    extra = np.zeros(1 + EXTRA_FEATURES, np.int32)
    last_v, last_u = np.uint32(image.shape[0] - 1), np.uint32(image.shape[1] - 1)
    for q in range(len(rows)):
        i = rows[q]
        v, u = pixel[i, 0] + 1, pixel[i, 1] + 1
        z = np.int32(image[v, u])
        row, column = np.int32(v) * _ONE + _HALF, np.int32(u) * _ONE + _HALF
        per_mm = np.int32(fx * person[3] / point[i, 2] * np.float32(65.536))
        near, far = z - np.int32(CLIP_MM), z + np.int32(CLIP_MM)
        for k in range(len(probes)):
            p = probes[k]
            off = _probed(image, last_v, last_u, row, column, near, far, per_mm, p[0], p[1], p[2], p[3])
            out[q, k] = np.float32(0.001) * np.float32(off)
        write_extra_features(point[i], person, extra)
        for k in range(EXTRA_FEATURES):
            out[q, len(probes) + k] = np.float32(extra[1 + k]) / np.float32(FINE)


def point_features(
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
    out = np.empty((len(rows), len(probes) + EXTRA_FEATURES), np.float32)
    rough = person.astype(np.float32)
    _answers(_whole(probes), scene.image, scene.pixel, scene.point, rows, np.float32(fx), rough, out)
    return out


def _whole(probes: NDArray[np.float16]) -> Nodes:
    return np.asarray(np.rint(1000.0 * probes.astype(float)), dtype=np.int16)


def pack_nodes(
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
    node = np.zeros((len(old), NODE_COLUMNS), np.int16)
    bound = np.floor(np.where(extra, FINE, 1000) * threshold[old].astype(float))
    node[:, THRESHOLD] = np.where(leaf, limit, np.clip(bound, -limit, limit))
    offsets = _whole(probes)[np.where(extra, 0, asks)]
    node[:, OFFSETS:CHILD] = np.where((extra | leaf)[:, None], 0, offsets)
    node[:, CHILD] = np.where(leaf, np.arange(len(old)), new[child])
    node[:, EXTRA] = np.where(extra & ~leaf, 1 + asks - len(probes), 0)
    node[:, LEAF] = np.where(leaf, -1 - child, -1)
    return node, np.arange(len(roots), dtype=np.int32)
