"""Growing the forests, and what their leaves say; scikit-learn is needed here and nowhere else (extra ``train``)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..clock import stream
from ..errors import SjasimError
from ..sensors.forest import EXTRAS, YAW_EXTRAS
from ..sensors.model import MILLI
from .samples import Samples

VOTES = 6
"""Joints that a leaf votes for."""
YAW_PIXELS, SECTORS = 110_000, 36
"""Pixels that the yaws' forest is grown on, and sectors of yaw that all weigh the same in it."""
MOST_SPREAD_M = 0.5
"""An offset farther off its leaf's median counts as this far."""


@dataclass(frozen=True, slots=True)
class Growth:
    """How large the forests become.

    Attributes:
        trees: trees of the joints' forest.
        leaves: most leaves of one of them.
        yaw_trees: trees of the yaws' forest.
        yaw_leaves: most leaves of one of them.
        tried: features tried at a node.
        share: of all samples that a tree sees.
        jobs: processes' worth of threads.
    """

    trees: int = 3
    leaves: int = 3000
    yaw_trees: int = 2
    yaw_leaves: int = 1500
    tried: int = 30
    share: float = 0.5
    jobs: int = 2


@dataclass(frozen=True, slots=True)
class Grown:
    """A forest's nodes, as `sensors.model.Model` stores them, and the leaf of every sample in every tree.

    Attributes:
        feature: (N,) what a node asks for.
        threshold: (N,) answers up to this go left.
        left: (N,) left child, -1 - leaf for a leaf.
        right: (N,) right child.
        roots: (T,) first nodes.
        leaf: (T, samples) leaf numbers.
        leaves: how many there are.
    """

    feature: NDArray[np.uint8]
    threshold: NDArray[np.float16]
    left: NDArray[np.int16]
    right: NDArray[np.int16]
    roots: NDArray[np.int16]
    leaf: NDArray[np.int32]
    leaves: int


def draw_probes(count: int, seed: int) -> NDArray[np.float16]:
    """(F, 4) random offsets between 3 and 70 cm; half of the probes have one end only."""
    rng = stream(seed, "training", "probes")
    angle = rng.uniform(0.0, 2.0 * math.pi, (count, 2))
    reach = np.exp(rng.uniform(math.log(0.03), math.log(0.70), (count, 2)))
    probes = np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=2).reshape(count, 4)
    probes[: count // 2, 2:] = 0.0
    return probes.astype(np.float16)


def grow(samples: Samples, growth: Growth, seed: int) -> Grown:
    """Grow the joints' forest: nodes separate pixels of different joints."""
    ensemble = _library().RandomForestClassifier(
        growth.trees, criterion="entropy", max_leaf_nodes=growth.leaves, min_samples_leaf=10,
        max_features=growth.tried, max_samples=growth.share, n_jobs=growth.jobs, random_state=seed,
    )  # fmt: skip
    ensemble.fit(samples.features, samples.joint)
    return _unravel(ensemble, samples.features)


def grow_yaw(samples: Samples, growth: Growth, seed: int) -> tuple[Grown, NDArray[np.int8]]:
    """Grow the yaws' forest and its votes (V, 2); it sees no feature that knows a yaw."""
    blind = samples.features.shape[1] - (EXTRAS - YAW_EXTRAS)
    few = slice(None, None, max(1, len(samples.joint) // YAW_PIXELS))
    features, goal = np.ascontiguousarray(samples.features[few, :blind]), samples.yaw[few]
    sector = ((np.arctan2(goal[:, 1], goal[:, 0]) / math.tau % 1.0) * SECTORS).astype(np.int64)
    weight = 1.0 / np.bincount(sector, minlength=SECTORS)[sector]
    ensemble = _library().RandomForestRegressor(
        growth.yaw_trees, max_leaf_nodes=growth.yaw_leaves, min_samples_leaf=20, max_features=growth.tried,
        max_samples=growth.share, n_jobs=growth.jobs, random_state=seed,
    )  # fmt: skip
    ensemble.fit(features, goal, sample_weight=weight / weight.mean())
    grown = _unravel(ensemble, features)
    votes = np.zeros((grown.leaves, 2))
    for leaf in grown.leaf:
        members = np.bincount(leaf, weight, grown.leaves)
        for c in range(2):
            votes[:, c] += np.bincount(leaf, weight * goal[:, c], grown.leaves) / np.where(members > 0, members, 1.0)
    return grown, np.rint(127 * votes).astype(np.int8)


def leaf_votes(samples: Samples, grown: Grown) -> tuple[NDArray[np.int8], NDArray[np.int16], NDArray[np.uint8]]:
    """What each leaf of the joints' forest says: its surest joints, their median offsets and spreads."""
    joint = np.zeros((grown.leaves, VOTES), np.int8)
    offset = np.zeros((grown.leaves, VOTES, 3), np.int16)
    spread = np.full((grown.leaves, VOTES), 255, np.uint8)
    for leaf in grown.leaf:
        order = np.argsort(leaf, kind="stable")
        ends = (np.flatnonzero(np.diff(leaf[order], append=-1)) + 1).tolist()
        begin = 0
        for end in ends:
            members = order[begin:end]
            begin, row = end, leaf[members[0]]
            away = samples.offset[members].astype(np.float32)
            middle = np.median(away, axis=0)
            off = np.minimum(((away - middle) ** 2).sum(axis=2), MOST_SPREAD_M**2)
            wide = np.sqrt(off.mean(axis=0))
            best = np.argsort(wide)[:VOTES]
            joint[row], offset[row] = best, np.rint(middle[best] / MILLI)
            spread[row] = np.minimum(np.rint(wide[best] / (4 * MILLI)), 255)
    return joint, offset, spread


def _unravel(ensemble: Any, features: NDArray[np.float32]) -> Grown:
    """All trees' nodes in one row, leaves numbered through."""
    parts: list[tuple[NDArray[Any], ...]] = []
    roots, leaf_of = [], []
    base, leaves = 0, 0
    for estimator in ensemble.estimators_:
        tree = estimator.tree_
        ends = tree.children_left < 0
        number = np.cumsum(ends) + (leaves - 1)
        left = np.where(ends, -1 - number, tree.children_left + base)
        parts.append((np.maximum(tree.feature, 0), tree.threshold, left, np.where(ends, 0, tree.children_right + base)))
        leaf_of.append(number[tree.apply(features)])
        roots.append(base)
        base, leaves = base + int(tree.node_count), leaves + int(ends.sum())
    feature, threshold, left, right = (np.concatenate(column) for column in zip(*parts, strict=True))
    if base > np.iinfo(np.int16).max:
        raise SjasimError(f"{base} nodes do not fit the model's int16; grow fewer leaves")
    return Grown(
        feature.astype(np.uint8), threshold.astype(np.float16), left.astype(np.int16), right.astype(np.int16),
        np.array(roots, np.int16), np.array(leaf_of, np.int32), leaves,
    )  # fmt: skip


def _library() -> Any:
    try:
        from sklearn import ensemble
    except ImportError as error:
        raise SjasimError("training needs scikit-learn: pip install 'sjasim[train]'") from error
    return ensemble
