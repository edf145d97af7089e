"""The forest's evaluation against a plain one that follows one tree after the other."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
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
    pixel_rank,
)

DEPTH = 6
"""Depth of every tree in these tests."""

SHAPE = (20, 30)

find_leaves_compiled = njit(find_leaves)
"""Compiled, because integers overflow and wrap there as in a session, and the test takes less time."""


def tree(rng: np.random.Generator, root: int) -> NDArray[np.int16]:
    """Return the nodes of a full tree whose root is row ``root`` of its forest."""
    count = 2 ** (DEPTH + 1) - 1
    node = np.zeros((count, NODE_COLUMNS), np.int16)
    node[:, OFFSETS : OFFSETS + 4] = rng.integers(-900, 900, (count, 4))
    node[:, THRESHOLD] = rng.integers(-CLIP_MM, CLIP_MM, count)
    node[:, CHILD] = root + 2 * np.arange(count) + 1

    tests_extra = rng.random(count) < 0.2
    node[tests_extra, EXTRA] = rng.integers(1, 1 + EXTRA_FEATURES, int(tests_extra.sum()))
    node[tests_extra, OFFSETS : OFFSETS + 4] = 0

    leaf = np.arange(count) >= count // 2
    node[leaf, CHILD] = root + np.flatnonzero(leaf)
    node[leaf, EXTRA] = 0
    node[leaf, OFFSETS : OFFSETS + 4] = 0
    node[leaf, THRESHOLD] = np.iinfo(np.int16).max
    return node


def plain_descent(
    node: NDArray[np.int16], image: NDArray[np.int16], v: int, u: int, per_mm: int, extra: list[int]
) -> int:
    """Return the leaf that a pixel reaches in one tree whose children are counted from its own root."""
    z = int(image[v + 1, u + 1])
    current = 0
    while int(node[current, CHILD]) != current:
        a, b, c, d = (int(offset) * per_mm for offset in node[current, OFFSETS : OFFSETS + 4])
        depths = []
        for left, up in ((a, b), (c, d)):
            row = ((v + 1) * 65536 + 32768 - up) // 65536
            column = ((u + 1) * 65536 + 32768 + left) // 65536
            row = min(max(row, 0), image.shape[0] - 1)
            column = min(max(column, 0), image.shape[1] - 1)
            depths.append(min(max(int(image[row, column]) - z, -CLIP_MM), CLIP_MM))

        answer = depths[0] - depths[1] + extra[int(node[current, EXTRA])]
        current = int(node[current, CHILD]) + int(answer > int(node[current, THRESHOLD]))
    return current


@pytest.mark.parametrize("trees", [1, 2, 3, 4])
def test_trees_descended_together_reach_the_leaves_that_each_reaches_alone(trees: int) -> None:
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
            current = np.arange(trees, dtype=np.int32) * count
            find_leaves_compiled(nodes, image, v, u, reach, extra, current)
            for k in range(trees):
                alone = nodes[k * count : (k + 1) * count].copy()
                alone[:, CHILD] -= k * count
                assert current[k] == k * count + plain_descent(alone, image, v, u, per_mm, extra.tolist())


@pytest.mark.parametrize("fraction", [0.1, 0.3, 0.8])
def test_the_pixels_below_a_rank_are_that_fraction_of_any_patch(fraction: float) -> None:
    for top, left in ((0, 0), (57, 130), (180, 200)):
        ranks = [pixel_rank(v, u) for v in range(top, top + 30) for u in range(left, left + 30)]
        assert np.mean(np.array(ranks) < fraction) == pytest.approx(fraction, abs=0.01)
