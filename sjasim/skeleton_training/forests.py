"""Growing the forests, and what their leaves say; scikit-learn is needed here and nowhere else (extra ``train``)."""

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
"""Joints that a leaf votes for."""
QUARTERS = 4
"""Sectors of yaw whose pixels the joints' forest tells apart."""
YAW_PIXELS, SECTORS = 110_000, 36
"""Pixels that the yaws' forest is grown on, and sectors of yaw that all weigh the same in it."""
MOST_SPREAD_M = 0.5
"""An offset farther off its leaf's middle counts as this far."""
OUTLIER_M, ROUNDS = 0.12, 3
"""An offset so far off its leaf's middle counts half in it; and how often the middle is found anew (assumed)."""
VIEW_PRIOR, MOST_VIEW_M = 20.0, 0.5
"""Pixels whose worth of belief the part of an offset that does not turn starts from 0 with, and its limit (assumed)."""


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
    leaves: int = 3300
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
    """Grow the joints' forest: nodes separate pixels of different joints, and of persons who stand differently.

    What a pixel of the trunk says depends on which way the person stands; every tree draws the borders between
    quarters of yaw elsewhere, so that none is a border of all.
    """
    yaw = np.arctan2(samples.features[:, -1], samples.features[:, -2])

    def one(tree: int) -> Any:
        quarter = np.floor(QUARTERS * yaw / math.tau + tree / growth.trees).astype(np.int64) % QUARTERS
        alone = _library().RandomForestClassifier(
            1, criterion="entropy", max_leaf_nodes=growth.leaves, min_samples_leaf=10, max_features=growth.tried,
            max_samples=growth.share, random_state=seed + tree,
        )  # fmt: skip
        return alone.fit(samples.features, QUARTERS * samples.joint + quarter).estimators_[0]

    with ThreadPoolExecutor(growth.jobs) as pool:
        return _unravel(list(pool.map(one, range(growth.trees))), samples.features)


def grow_yaw(samples: Samples, growth: Growth, seed: int) -> tuple[Grown, NDArray[np.int8]]:
    """Grow the yaws' forest and its votes (V, 2); it sees no feature that knows a yaw."""
    blind = samples.features.shape[1] - (EXTRA_FEATURES - YAW_EXTRA_FEATURES)
    few = slice(None, None, max(1, len(samples.joint) // YAW_PIXELS))
    features, goal = np.ascontiguousarray(samples.features[few, :blind]), samples.yaw[few]
    sector = ((np.arctan2(goal[:, 1], goal[:, 0]) / math.tau % 1.0) * SECTORS).astype(np.int64)
    weight = 1.0 / np.bincount(sector, minlength=SECTORS)[sector]
    ensemble = _library().RandomForestRegressor(
        growth.yaw_trees, max_leaf_nodes=growth.yaw_leaves, min_samples_leaf=20, max_features=growth.tried,
        max_samples=growth.share, n_jobs=growth.jobs, random_state=seed,
    )  # fmt: skip
    ensemble.fit(features, goal, sample_weight=weight / weight.mean())
    grown = _unravel(ensemble.estimators_, features)
    votes = np.zeros((grown.leaves, 2))
    for leaf in grown.leaf:
        members = np.bincount(leaf, weight, grown.leaves)
        for c in range(2):
            votes[:, c] += np.bincount(leaf, weight * goal[:, c], grown.leaves) / np.where(members > 0, members, 1.0)
    return grown, np.rint(127 * votes).astype(np.int8)


@dataclass(frozen=True, slots=True)
class Said:
    """What the leaves of the joints' forest say, the surest first; fields as in `sensors.model.Model`."""

    joint: NDArray[np.int8]
    offset: NDArray[np.int16]
    view: NDArray[np.int16]
    spread: NDArray[np.uint8]


def leaf_votes(samples: Samples, grown: Grown) -> Said:
    """What each leaf says: its surest joints, their offsets and spreads; none that nobody would listen to."""
    shape = (grown.leaves, VOTES)
    joint, spread = np.zeros(shape, np.int8), np.full(shape, 255, np.uint8)
    offset, view = np.zeros((*shape, 3), np.int16), np.zeros((*shape, 2), np.int16)
    turned = samples.features[:, -2:].astype(np.float32)
    for leaf in grown.leaf:
        order = np.argsort(leaf, kind="stable")
        ends = (np.flatnonzero(np.diff(leaf[order], append=-1)) + 1).tolist()
        begin = 0
        for end in ends:
            members = order[begin:end]
            begin, row = end, leaf[members[0]]
            middle, wide = settle(samples.offset[members].astype(np.float32), turned[members])
            best = np.argsort(wide)[:VOTES]
            best = best[wide[best] < MAX_SPREAD_M]
            joint[row, : len(best)] = best
            offset[row, : len(best)] = np.rint(middle[best, :3] / OFFSET_UNIT_M)
            view[row, : len(best)] = np.rint(np.clip(middle[best, 3:], -MOST_VIEW_M, MOST_VIEW_M) / OFFSET_UNIT_M)
            spread[row, : len(best)] = np.minimum(np.rint(wide[best] / SPREAD_UNIT_M), 255)
    return Said(joint, offset, view, spread)


def settle(away: NDArray[np.float32], turned: NDArray[np.float32]) -> tuple[Array, Array]:
    """One leaf's offset to every joint: a part that turns with the person, and one that does not.

    A joint lies behind the surface that shows it, whichever way the person stands: a leaf that sees bellies and
    backs would, turning all offsets with the person, put the spine into the skin of either. Least squares, with less
    weight for what is far off; without yaws that differ, all of it turns.

    Args:
        away: (M, J, 3) from the leaf's pixels forward, up, left, over the scale [m].
        turned: (M, 2) cosine and sine of the yaws that these were turned by.

    Returns:
        (J, 5) offset forward, up, left, and to the sensor's left and away from it [m], and (J,) the offset's
        standard deviation, outliers cut [m].
    """
    cos, sin = turned.T
    one, none = np.ones_like(cos), np.zeros_like(cos)
    rows = np.stack([np.stack([one, none, -sin, -cos], axis=1), np.stack([none, one, -cos, sin], axis=1)], axis=1)
    squares = np.einsum("mip,miq->mpq", rows, rows).reshape(len(away), 16)
    flat, up = away[..., [0, 2]], away[..., 1]
    off = ((away - np.median(away, axis=0)) ** 2).sum(axis=2)
    for _ in range(ROUNDS):
        weight = 1.0 / (1.0 + off / OUTLIER_M**2)
        normal = (weight.T @ squares).reshape(-1, 4, 4) + np.diag([1e-3, 1e-3, VIEW_PRIOR, VIEW_PRIOR])
        pulled = np.stack([np.einsum("mp,mj,mj->jp", rows[:, i], weight, flat[..., i], optimize=True) for i in (0, 1)])
        plane = np.linalg.solve(normal, pulled.sum(axis=0)[..., None])[..., 0]
        height = (weight * up).sum(axis=0) / weight.sum(axis=0)
        told = np.stack([rows[:, i] @ plane.T for i in (0, 1)], axis=2)
        off = ((flat - told) ** 2).sum(axis=2) + (up - height) ** 2
    wide = np.sqrt(np.minimum(off, MOST_SPREAD_M**2).mean(axis=0))
    return np.column_stack([plane[:, 0], height, plane[:, 1:]]), np.asarray(wide)


def _unravel(estimators: Sequence[Any], features: NDArray[np.float32]) -> Grown:
    """All trees' nodes in one row, leaves numbered through."""
    parts: list[tuple[NDArray[Any], ...]] = []
    roots, leaf_of = [], []
    base, leaves = 0, 0
    for estimator in estimators:
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
        raise SjasimError("training needs scikit-learn: pip install scikit-learn") from error
    return ensemble
