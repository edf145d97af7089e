"""Evaluation of the random forests: the features of a pixel, and the leaf that it reaches in every tree.

A feature is a difference of depths at two offsets from the pixel; the offsets shrink with distance.
Source: shotton2013, section 3.

All trees of a pixel are descended together, in integer arithmetic and without a branch on the answer. A processor that
mispredicts every other node, or waits for one memory access after the other, takes several times as long.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...core import Array
from ...core.compiled import compiled_entry, compiled_inner
from .foreground import Foreground, Image, Pixels, Points

CLIP_MM = 600
"""Bound of a depth difference; beyond it the offset hits another object, in front or behind (assumed)."""

EXTRA_FEATURES = 9
"""Number of features besides depth differences.

Height, x and z relative to the trunk, chest width and scale; then, for the joints' forest only, the distances forward
and to the left of the trunk, and cosine and sine of the yaw.
"""

YAW_EXTRA_FEATURES = 5
"""Number of extra features that the yaw's forest may use: those that do not depend on the yaw."""

EXTRA_UNIT = 10_000
"""Extra features are stored as integers in this fraction of a metre, or of one."""

THRESHOLD = 0
"""Column of a node: answers up to this go to the left child, others to the next node [mm, or 1 / `EXTRA_UNIT`]."""

OFFSETS = 1
"""First of four columns of a node: two offsets, each to the left and up [mm]."""

CHILD = 5
"""Column of a node: its left child; the right child is the next node. A leaf is its own child."""

EXTRA = 6
"""Column of a node: 1 + the extra feature that it tests, or 0 for a depth difference."""

LEAF = 7
"""Column of a node: the number of the leaf, or -1."""

NODE_COLUMNS = 8
"""Number of columns of a node."""

PERSON_X = 0
"""Column of a person's features: x of the trunk's surface [m]."""

PERSON_Z = 1
"""Column of a person's features: z of the trunk's surface [m]."""

PERSON_WIDTH = 2
"""Column of a person's features: chest width over scale [m]."""

PERSON_SCALE = 3
"""Column of a person's features: stature over that of the model's person."""

PERSON_COS = 4
"""Column of a person's features: cosine of the yaw relative to facing the sensor."""

PERSON_SIN = 5
"""Column of a person's features: sine of the yaw."""

Nodes = NDArray[np.int16]
Leaves = NDArray[np.int32]
Row = NDArray[np.float32]

# Image positions are fixed-point numbers, in 1/65536 of a pixel.
_ONE = np.int32(65536)
_HALF = np.int32(32768)
_FRACTION_BITS = np.int32(16)


@compiled_inner
def pixel_rank(v: int, u: int) -> float:
    """Return a number in [0, 1) that is always the same at a pixel and evenly spread over any patch of pixels.

    The pixels with a rank below a fraction are that fraction of all pixels. A person who stands still is therefore
    sampled at the same pixels in every frame.
    Source: roberts2018, the generalised golden ratio in two dimensions.
    """
    along = 0.7548776662466927 * u + 0.5698402909980532 * v
    return float(along - math.floor(along))


@compiled_inner
def _clipped_depth_mm(
    image: Image, last_v: np.uint32, last_u: np.uint32, v: np.int32, u: np.int32, near: np.int32, far: np.int32
) -> np.int32:
    """Return the depth at a position of the image, between two bounds [mm].

    Positions outside of the image have the depth of its border, whichever side they are on: a negative index becomes
    a large one when it is read as an unsigned number.
    """
    row = min(np.uint32(v >> _FRACTION_BITS), last_v)
    column = min(np.uint32(u >> _FRACTION_BITS), last_u)
    return min(max(np.int32(image[row, column]), near), far)


@compiled_inner
def _depth_difference_mm(
    image: Image, last_v: np.uint32, last_u: np.uint32, v: np.int32, u: np.int32, near: np.int32, far: np.int32,
    per_mm: np.int32, left: int, up: int, other_left: int, other_up: int,
) -> np.int32:  # fmt: skip
    """Return the difference of the depths at two offsets [mm] from a point, each clipped to `CLIP_MM` around it."""
    first = _clipped_depth_mm(image, last_v, last_u, v - np.int32(up) * per_mm, u + np.int32(left) * per_mm, near, far)
    other_v = v - np.int32(other_up) * per_mm
    other_u = u + np.int32(other_left) * per_mm
    difference: np.int32 = first - _clipped_depth_mm(image, last_v, last_u, other_v, other_u, near, far)
    return difference


@compiled_inner
def write_extra_features(point: Row, person: Row, out: Leaves) -> None:
    """Write a point's extra features from ``out[1]`` on, in the order given at `EXTRA_FEATURES`."""
    scale = person[PERSON_SCALE]
    cos = person[PERSON_COS]
    sin = person[PERSON_SIN]
    x = (point[0] - person[PERSON_X]) / scale
    z = (point[2] - person[PERSON_Z]) / scale
    unit = np.float32(EXTRA_UNIT)

    out[1] = np.int32(unit * point[1] / scale)
    out[2] = np.int32(unit * x)
    out[3] = np.int32(unit * z)
    out[4] = np.int32(unit * person[PERSON_WIDTH])
    out[5] = np.int32(unit * scale)
    out[6] = np.int32(unit * (-sin * x - cos * z))
    out[7] = np.int32(unit * (sin * z - cos * x))
    out[8] = np.int32(unit * cos)
    out[9] = np.int32(unit * sin)


@compiled_inner
def _next_node(
    nodes: Nodes, node: np.int32, image: Image, last_v: np.uint32, last_u: np.uint32, v: np.int32, u: np.int32,
    near: np.int32, far: np.int32, per_mm: np.int32, extra: Leaves,
) -> np.int32:  # fmt: skip
    """Return the node that follows a node; a leaf follows itself."""
    n = np.uint32(node)
    answer = extra[np.uint32(nodes[n, EXTRA])] + _depth_difference_mm(
        image, last_v, last_u, v, u, near, far, per_mm, nodes[n, 1], nodes[n, 2], nodes[n, 3], nodes[n, 4]
    )
    return np.int32(nodes[n, CHILD]) + np.int32(answer > np.int32(nodes[n, THRESHOLD]))


@compiled_inner
def find_leaves(nodes: Nodes, image: Image, v: int, u: int, reach: float, extra: Leaves, current: Leaves) -> None:
    """Follow a pixel from the nodes ``current`` to the leaves that it reaches.

    Three trees are descended at a time, so that their nodes stay in registers: more of them, or an array, take twice
    as long.

    Args:
        nodes: (N, `NODE_COLUMNS`) all trees.
        image: (H + 2, W + 2) depth with a border [mm].
        v: the pixel's row, without the border.
        u: its column, without the border.
        reach: pixels per metre of the model's person at that depth.
        extra: (1 + `EXTRA_FEATURES`,) from `write_extra_features`; the first one is 0.
        current: (T,) roots; replaced by the nodes of the leaves.
    """
    z = np.int32(image[v + 1, u + 1])
    near = z - np.int32(CLIP_MM)
    far = z + np.int32(CLIP_MM)
    last_v = np.uint32(image.shape[0] - 1)
    last_u = np.uint32(image.shape[1] - 1)
    row = np.int32(v + 1) * _ONE + _HALF
    column = np.int32(u + 1) * _ONE + _HALF
    per_mm = np.int32(reach * np.float32(65.536))

    for t in range(0, len(current), 3):
        second = min(t + 1, len(current) - 1)
        third = min(t + 2, len(current) - 1)
        a = current[t]
        b = current[second]
        c = current[third]
        while True:
            next_a = _next_node(nodes, a, image, last_v, last_u, row, column, near, far, per_mm, extra)
            next_b = _next_node(nodes, b, image, last_v, last_u, row, column, near, far, per_mm, extra)
            next_c = _next_node(nodes, c, image, last_v, last_u, row, column, near, far, per_mm, extra)
            if (a ^ next_a) | (b ^ next_b) | (c ^ next_c) == 0:
                break
            a = next_a
            b = next_b
            c = next_c
        current[t] = a
        current[second] = b
        current[third] = c


@compiled_entry
def _write_features(
    probes: Nodes, image: Image, pixel: Pixels, point: Points, rows: NDArray[np.int64], fx: np.float32, person: Row,
    out: NDArray[np.float32],
) -> None:  # fmt: skip
    """Write ``out``; see `point_features`."""
    extra = np.zeros(1 + EXTRA_FEATURES, np.int32)
    last_v = np.uint32(image.shape[0] - 1)
    last_u = np.uint32(image.shape[1] - 1)
    for q in range(len(rows)):
        i = rows[q]
        v = pixel[i, 0] + 1
        u = pixel[i, 1] + 1
        z = np.int32(image[v, u])
        near = z - np.int32(CLIP_MM)
        far = z + np.int32(CLIP_MM)
        row = np.int32(v) * _ONE + _HALF
        column = np.int32(u) * _ONE + _HALF
        per_mm = np.int32(fx * person[PERSON_SCALE] / point[i, 2] * np.float32(65.536))

        for k in range(len(probes)):
            p = probes[k]
            difference = _depth_difference_mm(
                image, last_v, last_u, row, column, near, far, per_mm, p[0], p[1], p[2], p[3]
            )
            out[q, k] = np.float32(0.001) * np.float32(difference)

        write_extra_features(point[i], person, extra)
        for k in range(EXTRA_FEATURES):
            out[q, len(probes) + k] = np.float32(extra[1 + k]) / np.float32(EXTRA_UNIT)


def point_features(
    foreground: Foreground, rows: NDArray[np.int64], probes: NDArray[np.float16], fx: float, person: Array
) -> Points:
    """Return all features of some points, for training.

    Args:
        foreground: points of one frame.
        rows: (Q,) rows of the points.
        probes: (F, 4) pairs of offsets [m].
        fx: focal length, in widths of a pixel.
        person: (6,) features of the person: `PERSON_X` and so on.

    Returns:
        (Q, F + 9) features [m, or one].
    """
    out = np.empty((len(rows), len(probes) + EXTRA_FEATURES), np.float32)
    person_row = person.astype(np.float32)
    _write_features(
        _in_millimetres(probes), foreground.image, foreground.pixel, foreground.point, rows, np.float32(fx),
        person_row, out,
    )  # fmt: skip
    return out


def _in_millimetres(probes: NDArray[np.float16]) -> Nodes:
    return np.asarray(np.rint(1000.0 * probes.astype(float)), dtype=np.int16)


def pack_nodes(
    probes: NDArray[np.float16], feature: NDArray[np.uint8], threshold: NDArray[np.float16], left: NDArray[np.int16],
    right: NDArray[np.int16], roots: NDArray[np.int16],
) -> tuple[Nodes, Leaves]:  # fmt: skip
    """Return a forest's nodes and roots as `find_leaves` takes them, with siblings side by side.

    Args:
        probes: as in `trained_model.SkeletonModel`, like the other arguments.
        feature: the same.
        threshold: the same.
        left: the same.
        right: the same.
        roots: the same.
    """
    # Breadth-first order: the list grows while it is read.
    order = [int(root) for root in roots]
    for k in order:
        if left[k] >= 0:
            order += [int(left[k]), int(right[k])]
    old = np.array(order)
    new = np.empty(len(left), np.int64)
    new[old] = np.arange(len(old))

    tested = feature[old].astype(np.int64)
    child = left[old].astype(np.int64)
    leaf = child < 0
    extra = tested >= len(probes)

    limit = np.iinfo(np.int16).max
    bound = np.floor(np.where(extra, EXTRA_UNIT, 1000) * threshold[old].astype(float))
    offsets = _in_millimetres(probes)[np.where(extra, 0, tested)]
    node = np.zeros((len(old), NODE_COLUMNS), np.int16)
    node[:, THRESHOLD] = np.where(leaf, limit, np.clip(bound, -limit, limit))
    node[:, OFFSETS:CHILD] = np.where((extra | leaf)[:, None], 0, offsets)
    node[:, CHILD] = np.where(leaf, np.arange(len(old)), new[child])
    node[:, EXTRA] = np.where(extra & ~leaf, 1 + tested - len(probes), 0)
    node[:, LEAF] = np.where(leaf, -1 - child, -1)
    return node, np.arange(len(roots), dtype=np.int32)
