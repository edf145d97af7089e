"""The yaw of each person from the votes of the forest's leaves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core import Array
from ...core.compiled import compiled_entry
from .foreground import Foreground, Image, Owners, Pixels, Points
from .forest import EXTRA_FEATURES, LEAF, PERSON_SCALE, Leaves, Nodes, find_leaves, pixel_rank, write_extra_features
from .point_kernels import copy_into
from .trained_model import RuntimeModel

Floats = NDArray[np.float32]


@compiled_entry
def _sum_yaw_votes(
    nodes: Nodes, roots: Leaves, vote: Floats, image: Image, pixel: Pixels, point: Points, owner: Owners, count: int,
    fraction: Array, fx: np.float32, persons: Floats, out: Array,
) -> None:  # fmt: skip
    """Add up ``out``, which holds zeros before; see `yaw_votes`."""
    extra = np.zeros(1 + EXTRA_FEATURES, np.int32)
    current = np.zeros(len(roots), np.int32)
    for i in range(count):
        k = owner[i]
        if k < 0 or pixel_rank(pixel[i, 0], pixel[i, 1]) >= fraction[k]:
            continue

        write_extra_features(point[i], persons[k], extra)
        copy_into(current, roots)
        reach = fx * persons[k, PERSON_SCALE] / point[i, 2]
        find_leaves(nodes, image, pixel[i, 0], pixel[i, 1], reach, extra, current)

        for node in current:
            leaf = int(nodes[node, LEAF])
            # The squared length of a leaf's mean direction tells how certain it is of the yaw.
            certainty = vote[leaf, 0] ** 2 + vote[leaf, 1] ** 2
            out[k, 0] += certainty * vote[leaf, 0]
            out[k, 1] += certainty * vote[leaf, 1]
            out[k, 2] += 1.0


def yaw_votes(foreground: Foreground, model: RuntimeModel, fractions: Array, fx: float, persons: Array) -> Array:
    """Return the votes for each person's yaw, from this frame alone.

    Args:
        foreground: points with owners.
        model: the trained model.
        fractions: (P,) fraction of the points that vote.
        fx: focal length, in widths of a pixel.
        persons: (P, 6) features of the persons, as in `forest.point_features`; their yaw is not used.

    Returns:
        (P, 3) sums of cosines and sines, weighted with the leaves' certainty, and number of votes.
    """
    out = np.zeros((len(persons), 3))
    _sum_yaw_votes(
        model.yaw_nodes, model.yaw_roots, model.yaw_vote, foreground.image, foreground.pixel, foreground.point,
        foreground.owner, foreground.count, fractions, np.float32(fx), persons.astype(np.float32), out,
    )  # fmt: skip
    return out
