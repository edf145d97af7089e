"""Growing the two forests, and the votes of their leaves.

This is the only module that needs scikit-learn, which the extra ``train`` installs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import Array
from ..core.clock import stream
from ..core.errors import SjasimError
from ..sensors.skeleton.forest import EXTRA_FEATURES, YAW_EXTRA_FEATURES
from ..sensors.skeleton.joint_voting import MAX_SPREAD_M
from ..sensors.skeleton.trained_model import OFFSET_UNIT_M, SPREAD_UNIT_M
from .samples import Samples

VOTES = 6
"""Number of joints for which a leaf votes."""

YAW_SECTORS = 4
"""Sectors of yaw whose pixels are separate classes of the joint forest."""

YAW_FOREST_PIXELS = 110_000
"""Number of pixels on which the yaw forest is grown."""

YAW_WEIGHT_SECTORS = 36
"""Sectors of yaw that have equal weight in the yaw forest."""

MAX_DEVIATION_M = 0.5
"""Deviations of an offset from its leaf's mean are cut at this distance."""

OUTLIER_M = 0.12
"""Deviation at which an offset has half weight in its leaf's mean (assumed)."""

REWEIGHTING_ROUNDS = 3
"""Rounds of the reweighted least squares of a leaf's mean (assumed)."""

VIEW_PRIOR_PIXELS = 20.0
"""Weight of the prior that the part of an offset that does not turn with the person is 0, in pixels (assumed)."""

MAX_VIEW_OFFSET_M = 0.5
"""Largest part of an offset that does not turn with the person (assumed)."""


@dataclass(frozen=True, slots=True)
class Growth:
    """Size of the forests.

    Attributes:
        trees: number of trees of the joint forest.
        leaves: largest number of leaves of one of them.
        yaw_trees: number of trees of the yaw forest.
        yaw_leaves: largest number of leaves of one of them.
        tried: number of features tried at a node.
        share: share of all samples of which a tree is grown.
        jobs: number of threads.
    """

    trees: int = 3
    leaves: int = 3300
    yaw_trees: int = 2
    yaw_leaves: int = 1500
    tried: int = 30
    share: float = 0.5
    jobs: int = 2


@dataclass(frozen=True, slots=True)
class Forest:
    """Nodes of a forest, as `SkeletonModel` stores them, and the leaf of each sample in each tree.

    Attributes:
        feature: (N,) feature that a node tests.
        threshold: (N,) values up to this go left.
        left: (N,) left child; -1 - leaf for a leaf.
        right: (N,) right child.
        roots: (T,) first node of each tree.
        sample_leaf: (T, samples) leaf of each sample.
        leaves: number of leaves.
    """

    feature: NDArray[np.uint8]
    threshold: NDArray[np.float16]
    left: NDArray[np.int16]
    right: NDArray[np.int16]
    roots: NDArray[np.int16]
    sample_leaf: NDArray[np.int32]
    leaves: int


@dataclass(frozen=True, slots=True)
class LeafVotes:
    """Votes of the leaves of the joint forest, smallest spread first; fields are those of `SkeletonModel`."""

    joint: NDArray[np.int8]
    offset: NDArray[np.int16]
    view: NDArray[np.int16]
    spread: NDArray[np.uint8]

    @classmethod
    def empty(cls, leaves: int) -> LeafVotes:
        """Return votes whose spreads are too large to count."""
        shape = (leaves, VOTES)
        return cls(
            joint=np.zeros(shape, np.int8),
            offset=np.zeros((*shape, 3), np.int16),
            view=np.zeros((*shape, 2), np.int16),
            spread=np.full(shape, 255, np.uint8),
        )


def draw_probes(count: int, seed: int) -> NDArray[np.float16]:
    """Return (F, 4) random pairs of offsets of 3 to 70 cm; the second offset is 0 in half of the pairs."""
    rng = stream(seed, "training", "probes")
    angle = rng.uniform(0.0, 2.0 * math.pi, (count, 2))
    # Uniform in the logarithm: hands need short offsets and trunks long ones.
    reach_m = np.exp(rng.uniform(math.log(0.03), math.log(0.70), (count, 2)))
    probes = np.stack([reach_m * np.cos(angle), reach_m * np.sin(angle)], axis=2).reshape(count, 4)
    probes[: count // 2, 2:] = 0.0
    return probes.astype(np.float16)


def grow_joint_forest(samples: Samples, growth: Growth, seed: int) -> Forest:
    """Grow the joint forest, whose nodes separate pixels of different joints and of different sectors of yaw.

    The offsets of a trunk's pixel to the joints depend on the heading of the person, so a class is a joint together
    with a sector. The borders between sectors differ from tree to tree, so that none of them is a border of all trees.
    """
    yaw = np.arctan2(samples.features[:, -1], samples.features[:, -2])

    def grow_tree(tree: int) -> Any:
        sector = np.floor(YAW_SECTORS * yaw / math.tau + tree / growth.trees).astype(np.int64) % YAW_SECTORS
        estimator = _ensemble_module().RandomForestClassifier(
            1, criterion="entropy", max_leaf_nodes=growth.leaves, min_samples_leaf=10, max_features=growth.tried,
            max_samples=growth.share, random_state=seed + tree,
        )  # fmt: skip
        return estimator.fit(samples.features, YAW_SECTORS * samples.joint + sector).estimators_[0]

    with ThreadPoolExecutor(growth.jobs) as pool:
        return _concatenate_trees(list(pool.map(grow_tree, range(growth.trees))), samples.features)


def grow_yaw_forest(samples: Samples, growth: Growth, seed: int) -> tuple[Forest, NDArray[np.int8]]:
    """Grow the yaw forest.

    The last features depend on the tracked heading and are left out: this forest has to find the heading anew.

    Returns:
        the forest, and (V, 2) mean cosine and sine of the heading in each leaf [1/127].
    """
    feature_count = samples.features.shape[1] - (EXTRA_FEATURES - YAW_EXTRA_FEATURES)
    some = slice(None, None, max(1, len(samples.joint) // YAW_FOREST_PIXELS))
    features = np.ascontiguousarray(samples.features[some, :feature_count])
    goal = samples.yaw[some]

    # Each sector of yaw has the same total weight, although persons mostly face the sensor.
    sector = ((np.arctan2(goal[:, 1], goal[:, 0]) / math.tau % 1.0) * YAW_WEIGHT_SECTORS).astype(np.int64)
    weight = 1.0 / np.bincount(sector, minlength=YAW_WEIGHT_SECTORS)[sector]
    estimator = _ensemble_module().RandomForestRegressor(
        growth.yaw_trees, max_leaf_nodes=growth.yaw_leaves, min_samples_leaf=20, max_features=growth.tried,
        max_samples=growth.share, n_jobs=growth.jobs, random_state=seed,
    )  # fmt: skip
    estimator.fit(features, goal, sample_weight=weight / weight.mean())
    forest = _concatenate_trees(estimator.estimators_, features)

    votes = np.zeros((forest.leaves, 2))
    for sample_leaf in forest.sample_leaf:
        total = np.bincount(sample_leaf, weight, forest.leaves)
        for c in range(2):
            weighted = np.bincount(sample_leaf, weight * goal[:, c], forest.leaves)
            votes[:, c] += weighted / np.where(total > 0, total, 1.0)
    return forest, np.rint(127 * votes).astype(np.int8)


def leaf_votes(samples: Samples, forest: Forest) -> LeafVotes:
    """Return the votes of each leaf: the joints with the smallest spread, up to the largest spread that counts."""
    votes = LeafVotes.empty(forest.leaves)
    heading = samples.features[:, -2:].astype(np.float32)
    for sample_leaf in forest.sample_leaf:
        # Samples sorted by leaf, and the end of each leaf's run.
        order = np.argsort(sample_leaf, kind="stable")
        ends = (np.flatnonzero(np.diff(sample_leaf[order], append=-1)) + 1).tolist()
        begin = 0
        for end in ends:
            members = order[begin:end]
            begin = end
            mean, spread_m = mean_offsets(samples.offset[members].astype(np.float32), heading[members])
            _write_leaf(votes, sample_leaf[members[0]], mean, spread_m)
    return votes


def _write_leaf(votes: LeafVotes, leaf: int, mean: Array, spread_m: Array) -> None:
    """Write the votes of one leaf in the units of `SkeletonModel`."""
    best = np.argsort(spread_m)[:VOTES]
    # Depth sensing ignores votes of a larger spread.
    best = best[spread_m[best] < MAX_SPREAD_M]
    view_m = np.clip(mean[best, 3:], -MAX_VIEW_OFFSET_M, MAX_VIEW_OFFSET_M)
    votes.joint[leaf, : len(best)] = best
    votes.offset[leaf, : len(best)] = np.rint(mean[best, :3] / OFFSET_UNIT_M)
    votes.view[leaf, : len(best)] = np.rint(view_m / OFFSET_UNIT_M)
    votes.spread[leaf, : len(best)] = np.minimum(np.rint(spread_m[best] / SPREAD_UNIT_M), 255)


def mean_offsets(offsets: NDArray[np.float32], heading: NDArray[np.float32]) -> tuple[Array, Array]:
    """Return one leaf's mean offset to each joint, as a part that turns with the person and one that does not.

    A joint lies behind the surface at which its pixels are seen, whichever way the person faces. A leaf whose pixels
    come from bellies and from backs would put the spine on the skin of both if all of the offset turned with the
    person. Both parts come from least squares, reweighted so that outliers have little weight. If all headings are
    alike, the parts cannot be told apart and the prior puts everything into the part that turns.

    Args:
        offsets: (M, J, 3) offsets from the leaf's pixels: forward, up, left, over the person's scale [m].
        heading: (M, 2) cosine and sine of the heading by which each was turned.

    Returns:
        (J, 5) mean offset forward, up, left, and to the sensor's left and away from it [m]; and (J,) the standard
        deviation of the offsets, with outliers cut [m].
    """
    cos, sin = heading.T
    ones = np.ones_like(cos)
    zeros = np.zeros_like(cos)

    # Linear equations of a pixel for the forward and the left component, in the four unknowns of the plane.
    forward_row = np.stack([ones, zeros, -sin, -cos], axis=1)
    left_row = np.stack([zeros, ones, -cos, sin], axis=1)
    rows = np.stack([forward_row, left_row], axis=1)
    squares = np.einsum("mip,miq->mpq", rows, rows).reshape(len(offsets), 16)
    plane = offsets[..., [0, 2]]
    up = offsets[..., 1]

    deviation_sq = ((offsets - np.median(offsets, axis=0)) ** 2).sum(axis=2)
    for _ in range(REWEIGHTING_ROUNDS):
        weight = 1.0 / (1.0 + deviation_sq / OUTLIER_M**2)
        prior = np.diag([1e-3, 1e-3, VIEW_PRIOR_PIXELS, VIEW_PRIOR_PIXELS])
        normal = (weight.T @ squares).reshape(-1, 4, 4) + prior
        right = np.stack([np.einsum("mp,mj,mj->jp", rows[:, i], weight, plane[..., i], optimize=True) for i in (0, 1)])
        solution = np.linalg.solve(normal, right.sum(axis=0)[..., None])[..., 0]
        height = (weight * up).sum(axis=0) / weight.sum(axis=0)

        predicted = np.stack([rows[:, i] @ solution.T for i in (0, 1)], axis=2)
        deviation_sq = ((plane - predicted) ** 2).sum(axis=2) + (up - height) ** 2
    spread = np.sqrt(np.minimum(deviation_sq, MAX_DEVIATION_M**2).mean(axis=0))
    return np.column_stack([solution[:, 0], height, solution[:, 1:]]), np.asarray(spread)


def _concatenate_trees(estimators: Sequence[Any], features: NDArray[np.float32]) -> Forest:
    """Return the nodes of all trees in one table, with leaves numbered across trees.

    Raises:
        SjasimError: there are more nodes than the model's integers can number.
    """
    parts: list[tuple[NDArray[Any], ...]] = []
    roots = []
    sample_leaf = []
    nodes = 0
    leaves = 0
    for estimator in estimators:
        tree = estimator.tree_
        is_leaf = tree.children_left < 0
        # Leaves continue the numbers of the trees before; a negative left child marks a leaf.
        number = np.cumsum(is_leaf) + (leaves - 1)
        left = np.where(is_leaf, -1 - number, tree.children_left + nodes)
        right = np.where(is_leaf, 0, tree.children_right + nodes)
        parts.append((np.maximum(tree.feature, 0), tree.threshold, left, right))
        sample_leaf.append(number[tree.apply(features)])
        roots.append(nodes)
        nodes += int(tree.node_count)
        leaves += int(is_leaf.sum())

    if nodes > np.iinfo(np.int16).max:
        raise SjasimError(f"{nodes} nodes do not fit the model's int16; grow fewer leaves")
    feature, threshold, left, right = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Forest(
        feature.astype(np.uint8), threshold.astype(np.float16), left.astype(np.int16), right.astype(np.int16),
        np.array(roots, np.int16), np.array(sample_leaf, np.int32), leaves,
    )  # fmt: skip


def _ensemble_module() -> Any:
    """Return scikit-learn's ensembles, or raise a SjasimError that says how to install them."""
    try:
        from sklearn import ensemble
    except ImportError as error:
        raise SjasimError("training needs scikit-learn: pip install scikit-learn") from error
    return ensemble
