"""Pixels down a forest: as somebody would who followed one tree after the other."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from sjasim.sensors.skeleton.forest import (
    CHILD,
    CLIP_MM,
    EXTRA,
    EXTRA_FEATURES,
    NODE_COLUMNS,
    OFFSETS,
    THRESHOLD,
    find_leaves,
)

DEPTH = 6
"""Of every tree here."""
SHAPE = (20, 30)


def tree(rng: np.random.Generator, root: int) -> NDArray[np.int16]:
    """The nodes of a full tree, the first of which is row ``root`` of its forest."""
    count = 2 ** (DEPTH + 1) - 1
    node = np.zeros((count, NODE_COLUMNS), np.int16)
    node[:, OFFSETS : OFFSETS + 4] = rng.integers(-900, 900, (count, 4))
    node[:, THRESHOLD] = rng.integers(-CLIP_MM, CLIP_MM, count)
    node[:, CHILD] = root + 2 * np.arange(count) + 1
    asks = rng.random(count) < 0.2
    node[asks, EXTRA] = rng.integers(1, 1 + EXTRA_FEATURES, int(asks.sum()))
    node[asks, OFFSETS : OFFSETS + 4] = 0
    leaf = np.arange(count) >= count // 2
    node[leaf, CHILD] = root + np.flatnonzero(leaf)
    node[leaf, EXTRA], node[leaf, OFFSETS : OFFSETS + 4], node[leaf, THRESHOLD] = 0, 0, np.iinfo(np.int16).max
    return node


def walked(node: NDArray[np.int16], image: NDArray[np.int16], v: int, u: int, per_mm: int, extra: list[int]) -> int:
    """Where one tree leads, from its first node on, whose children are counted from there."""
    z, at = int(image[v + 1, u + 1]), 0
    while int(node[at, CHILD]) != at:
        a, b, c, d = (int(offset) * per_mm for offset in node[at, OFFSETS : OFFSETS + 4])
        found = []
        for left, up in ((a, b), (c, d)):
            row, column = ((v + 1) * 65536 + 32768 - up) // 65536, ((u + 1) * 65536 + 32768 + left) // 65536
            row, column = min(max(row, 0), image.shape[0] - 1), min(max(column, 0), image.shape[1] - 1)
            found.append(min(max(int(image[row, column]) - z, -CLIP_MM), CLIP_MM))
        answer = found[0] - found[1] + extra[int(node[at, EXTRA])]
        at = int(node[at, CHILD]) + int(answer > int(node[at, THRESHOLD]))
    return at


@pytest.mark.parametrize("trees", [1, 2, 3, 4])
def test_trees_that_descend_together_lead_to_the_leaves_that_each_alone_leads_to(trees: int) -> None:
    rng = np.random.default_rng(trees)
    image = np.full((SHAPE[0] + 2, SHAPE[1] + 2), 8000, np.int16)
    image[1:-1, 1:-1] = rng.integers(1000, 4000, SHAPE)
    count = 2 ** (DEPTH + 1) - 1
    nodes = np.concatenate([tree(rng, k * count) for k in range(trees)])
    extra = np.array([0, *rng.integers(-CLIP_MM, CLIP_MM, EXTRA_FEATURES)], np.int32)
    reach = np.float32(12.0)
    per_mm = int(reach * np.float32(65.536))
    for v in range(SHAPE[0]):
        for u in range(SHAPE[1]):
            at = np.arange(trees, dtype=np.int32) * count
            find_leaves(nodes, image, v, u, reach, extra, at)
            for k in range(trees):
                alone = nodes[k * count : (k + 1) * count].copy()
                alone[:, CHILD] -= k * count
                assert at[k] == k * count + walked(alone, image, v, u, per_mm, extra.tolist())
