"""Joint positions from the votes of the forest's leaves.

Source: girshick2011, section 4 (votes relative to the pixel, mean shift). Unlike there, offsets are stored in the
person's frame, rotated by the tracked yaw and scaled by the estimated stature, so that one leaf serves every heading
and every build.
"""

from __future__ import annotations

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...core import Array, IntArray
from ...core.compiled import compiled_entry, compiled_inner
from .foreground import Foreground, Image, Owners, Pixels, Points
from .forest import (
    EXTRA_FEATURES,
    LEAF,
    PERSON_COS,
    PERSON_SCALE,
    PERSON_SIN,
    PERSON_X,
    PERSON_Z,
    Leaves,
    Nodes,
    find_leaves,
    pixel_rank,
    write_extra_features,
)
from .joint_groups import IS_ARM
from .point_kernels import copy_into
from .trained_model import OFFSET_UNIT_M, SPREAD_UNIT_M, RuntimeModel

BANDWIDTHS_M = np.array([0.22, 0.09, 0.05])
"""Bandwidths of the steps of the mean shift (assumed)."""

MAX_SQUARE = 9.0
"""Votes beyond three bandwidths, squared here, are ignored."""

MIN_SPREAD_M = 0.03
"""Added to a vote's spread before it becomes a weight, so that no single vote dominates (assumed)."""

SURE_SPREAD_M = 0.10
"""Votes with a larger spread do not support the tracking of a joint (assumed)."""

MAX_SPREAD_M = 0.15
"""Votes with a larger spread are ignored: they are not worth their time (assumed)."""

START_SPREAD_M = 0.12
"""Votes with a larger spread do not count for the start of the mean shift (assumed)."""

LIMB_X_M = 0.20
"""A point that is farther than this beside the trunk belongs to a limb (assumed)."""

LIMB_AHEAD_M = 0.15
"""A point that is farther than this in front of the trunk's surface belongs to a limb (assumed)."""

LIMB_FACTOR = 16
"""How many times more of a limb's points vote (assumed)."""

MIN_VOTES = 4
"""Fewer agreeing votes than these are one stray pixel's and are not evidence for an arm.

Measured: of hands that were tracked more than 15 cm off, nine in ten had one or two votes; of those well found, one in
twenty had less than four.
"""

AGREEING_SQUARE = 4.0
"""Votes within two bandwidths of a joint, squared here, agree."""

STAY_FACTOR = 2.0
"""An arm's joint leaves its prediction only for a place with this many times the weight of votes (assumed)."""

MAX_VOTES = 4000
"""Most votes for one joint of one person; further ones are ignored.

The number is not a power of two: with one, a cache would map the votes of all joints to the same place.
"""

X = 0
"""Column of a vote: x [m]."""

Y = 1
"""Column of a vote: height [m]."""

Z = 2
"""Column of a vote: z [m]."""

WEIGHT = 3
"""Column of a vote: its weight."""

SURE = 4
"""Column of a vote: its weight if its spread is small enough to support tracking, else 0."""

VOTE_COLUMNS = 5
"""Number of columns of a vote."""

PULL_WEIGHT = 3
"""Column of a pull, after the weighted displacement: the weight of all votes nearby."""

PULL_SURE = 4
"""Column of a pull: the weight of the sure votes nearby."""

PULL_COUNT = 5
"""Column of a pull: the number of sure votes that agree."""

PULL_COLUMNS = 6
"""Number of columns of a pull."""

Floats = NDArray[np.float32]

_vectorised_inner = register_jitable(error_model="numpy", fastmath=True, no_cfunc_wrapper=True)
"""As `compiled_inner`, but sums may be reordered, so that the compiler vectorises them."""

_SPREADS_M = SPREAD_UNIT_M * np.arange(256)
_WEIGHTS = ((_SPREADS_M**2 + MIN_SPREAD_M**2) ** -2).astype(np.float32)
_MAX_SPREAD = int(np.searchsorted(_SPREADS_M, MAX_SPREAD_M))
_START_SPREAD = int(np.searchsorted(_SPREADS_M, START_SPREAD_M))
_SURE_SPREAD = int(np.searchsorted(_SPREADS_M, SURE_SPREAD_M))


@compiled_entry
def _collect_votes(
    nodes: Nodes, roots: Leaves, leaf_votes: Nodes, image: Image, pixel: Pixels, point: Points, owner: Owners,
    count: int, fraction: Array, fx: np.float32, persons: Floats, votes: Floats, vote_count: IntArray, start: Array,
) -> None:  # fmt: skip
    """Write every joint's votes, and add up where the mean shift starts.

    Args:
        nodes: (N, 8) nodes of the joints' forest.
        roots: (T,) roots of its trees.
        leaf_votes: (L, K, 7) votes of its leaves, see `trained_model.RuntimeModel`.
        image: (H + 2, W + 2) depth with a border [mm].
        pixel: (N, 2) row and column of the points.
        point: (N, 3) points [m].
        owner: (N,) person of each point.
        count: number of points.
        fraction: (P,) fraction of the points that vote.
        fx: focal length, in widths of a pixel.
        persons: (P, 6) features of the persons.
        votes: (P * 25, `MAX_VOTES`, `VOTE_COLUMNS`) output.
        vote_count: (P * 25,) output, zeros before.
        start: (P * 25, 4) output, zeros before: weighted sum of the surer votes' positions, and of their weights.
    """
    extra = np.zeros(1 + EXTRA_FEATURES, np.int32)
    current = np.zeros(len(roots), np.int32)
    for i in range(count):
        k = owner[i]
        if k < 0:
            continue

        # Limbs have few pixels, so a larger fraction of them votes, each with a smaller weight.
        rank = pixel_rank(pixel[i, 0], pixel[i, 1])
        part = min(LIMB_FACTOR * fraction[k], 1.0)
        if rank >= part:
            continue
        x = point[i, 0]
        y = point[i, 1]
        z = point[i, 2]
        scale = persons[k, PERSON_SCALE]
        beside = abs(x - persons[k, PERSON_X]) > LIMB_X_M * scale
        if not beside and z >= persons[k, PERSON_Z] - LIMB_AHEAD_M * scale:
            part = fraction[k]
            if rank >= part:
                continue

        reach = fx * scale / z
        write_extra_features(point[i], persons[k], extra)
        copy_into(current, roots)
        find_leaves(nodes, image, pixel[i, 0], pixel[i, 1], reach, extra, current)

        # A pixel counts by the surface that it shows, on a person of the model's size.
        surface = np.float32(1.0 / part) / (reach * reach)
        size = np.float32(OFFSET_UNIT_M) * scale
        cos = persons[k, PERSON_COS] * size
        sin = persons[k, PERSON_SIN] * size
        for node in current:
            leaf = np.uint32(nodes[np.uint32(node), LEAF])
            for q in range(leaf_votes.shape[1]):
                spread = leaf_votes[leaf, q, 5]
                # The votes of a leaf are sorted by their spread.
                if spread >= _MAX_SPREAD:
                    break
                row = np.uint32(k * len(JOINTS) + leaf_votes[leaf, q, 6])
                n = np.uint32(vote_count[row])
                if n == MAX_VOTES:
                    continue
                vote_count[row] = n + 1

                forward = leaf_votes[leaf, q, 0]
                up = leaf_votes[leaf, q, 1]
                left = leaf_votes[leaf, q, 2]
                weight = surface * _WEIGHTS[spread]
                votes[row, n, X] = x - sin * forward - cos * left + size * leaf_votes[leaf, q, 3]
                votes[row, n, Y] = y + size * up
                votes[row, n, Z] = z - cos * forward + sin * left + size * leaf_votes[leaf, q, 4]
                votes[row, n, WEIGHT] = weight
                votes[row, n, SURE] = weight if spread < _SURE_SPREAD else np.float32(0.0)
                if spread < _START_SPREAD:
                    for c in range(3):
                        start[row, c] += weight * votes[row, n, c]
                    start[row, 3] += weight


@_vectorised_inner
def _sum_pull(votes: Floats, n: int, joint: Array, bandwidth_m: float, pull: Array) -> None:
    """Write the pull of the votes on a joint.

    The sums are vectorised, so they may differ in the last bits from those in order.

    Args:
        votes: (`VOTE_COLUMNS`, `MAX_VOTES`) votes of the joint.
        n: their number.
        joint: (3,) current position [m].
        bandwidth_m: width of the kernel.
        pull: (`PULL_COLUMNS`,) output: weighted displacement, weights of all and of the sure votes, number of sure
            votes that agree.
    """
    a = np.float32(joint[0])
    b = np.float32(joint[1])
    c = np.float32(joint[2])
    per = np.float32(1.0 / (bandwidth_m * bandwidth_m))
    one = np.float32(1.0)
    far = np.float32(MAX_SQUARE)
    near = np.float32(AGREEING_SQUARE)
    none = np.float32(0.0)

    # Sums in single precision: twice as many fit into a vector register.
    dx = dy = dz = total = sure = agree = none
    for i in range(n):
        x = votes[X, i] - a
        y = votes[Y, i] - b
        z = votes[Z, i] - c
        square = (x * x + y * y + z * z) * per
        kernel = one / ((one + square) * (one + square)) if square < far else none
        weight = votes[WEIGHT, i] * kernel
        dx += weight * x
        dy += weight * y
        dz += weight * z
        total += weight
        sure += votes[SURE, i] * kernel
        agree += one if square < near and votes[SURE, i] > none else none
    pull[0] = dx
    pull[1] = dy
    pull[2] = dz
    pull[PULL_WEIGHT] = total
    pull[PULL_SURE] = sure
    pull[PULL_COUNT] = agree


@compiled_inner
def _shift_to_mode(votes: Floats, n: int, joint: Array, scale: float, first: int, pull: Array) -> None:
    """Move a joint by mean shift, from bandwidth number ``first`` on; ``pull`` is that of the last step."""
    for step in range(first, len(BANDWIDTHS_M)):
        _sum_pull(votes, n, joint, BANDWIDTHS_M[step] * scale, pull)
        if pull[PULL_WEIGHT] > 0.0:
            for c in range(3):
                joint[c] += pull[c] / pull[PULL_WEIGHT]


@compiled_entry
def _find_modes(
    collected: Floats, vote_count: IntArray, start: Array, persons: Floats, prior: Array, joints: Array, support: Array,
    agree: Array,
) -> None:  # fmt: skip
    """Write every joint's position by mean shift.

    The search starts half way between the mean of the surer votes and the prediction, or at the one that exists. For
    an arm a second search starts at the prediction, and its result is kept unless much more weight speaks for the
    first: a hand has few pixels, and one pixel of another limb that looks like the hand may be the only one to vote.

    Args:
        collected: (P * 25, `MAX_VOTES`, `VOTE_COLUMNS`) from `_collect_votes`.
        vote_count: (P * 25,) from there.
        start: (P * 25, 4) from there.
        persons: (P, 6) features of the persons.
        prior: (P, 25, 3) predicted joints [m].
        joints: (P, 25, 3) output [m].
        support: (P, 25) output, zeros before: weight of the sure votes.
        agree: (P, 25) output, zeros before: number of sure votes that agree.
    """
    pull = np.zeros(PULL_COLUMNS)
    first_pull = np.zeros(PULL_COLUMNS)
    votes = np.zeros((VOTE_COLUMNS, MAX_VOTES), np.float32)
    stayed = np.zeros(3)
    for row in range(len(vote_count)):
        k = row // len(JOINTS)
        j = row % len(JOINTS)
        scale = persons[k, PERSON_SCALE]
        joint = joints[k, j]
        for c in range(3):
            joint[c] = prior[k, j, c]
            stayed[c] = prior[k, j, c]

        if start[row, 3] > 0.0:
            predicted = not math.isnan(joint[0])
            for c in range(3):
                mean = start[row, c] / start[row, 3]
                joint[c] = 0.5 * (mean + joint[c]) if predicted else mean
        # Without votes the joint keeps its prediction, or stays unknown.
        if vote_count[row] == 0 or math.isnan(joint[0]):
            continue

        # Columns next to each other let the sums be vectorised.
        for n in range(vote_count[row]):
            for c in range(VOTE_COLUMNS):
                votes[c, n] = collected[row, n, c]
        _shift_to_mode(votes, vote_count[row], joint, scale, 0, pull)

        if IS_ARM[j] and not math.isnan(stayed[0]):
            copy_into(first_pull, pull)
            _shift_to_mode(votes, vote_count[row], stayed, scale, 1, pull)
            needed = pull[PULL_SURE] * (STAY_FACTOR if pull[PULL_COUNT] >= MIN_VOTES else 0.0)
            if first_pull[PULL_COUNT] >= MIN_VOTES and first_pull[PULL_SURE] > needed:
                copy_into(pull, first_pull)
            else:
                copy_into(joint, stayed)
        support[k, j] = pull[PULL_SURE]
        agree[k, j] = pull[PULL_COUNT]


class JointVoter:
    """Finds joints by the votes of a trained model.

    It owns the memory for the votes of one frame, which is reused.

    Args:
        model: the trained model.
        max_persons: most persons in a frame.
    """

    def __init__(self, model: RuntimeModel, max_persons: int) -> None:
        self._model = model
        self._votes = np.empty((max_persons * len(JOINTS), MAX_VOTES, VOTE_COLUMNS), np.float32)

    def find_joints(
        self, foreground: Foreground, fractions: Array, fx: float, persons: Array, prior: Array
    ) -> tuple[Array, Array, Array]:
        """Return the joints of all persons, and how well votes support them.

        Args:
            foreground: points with owners.
            fractions: (P,) fraction of the points that vote.
            fx: focal length, in widths of a pixel.
            persons: (P, 6) features of the persons, as in `forest.point_features`.
            prior: (P, 25, 3) predicted joints as points, NaN where nothing is known [m].

        Returns:
            (P, 25, 3) joints as points, NaN where there is neither a vote nor a prediction [m]; (P, 25) weight of the
            sure votes that agree; (P, 25) their number.
        """
        model = self._model
        rows = len(persons) * len(JOINTS)
        vote_count = np.zeros(rows, np.int64)
        start = np.zeros((rows, 4))
        person_rows = persons.astype(np.float32)
        _collect_votes(
            model.nodes, model.roots, model.votes, foreground.image, foreground.pixel, foreground.point,
            foreground.owner, foreground.count, fractions, np.float32(fx), person_rows, self._votes, vote_count, start,
        )  # fmt: skip

        joints = np.empty(prior.shape)
        support = np.zeros(prior.shape[:2])
        agree = np.zeros(prior.shape[:2])
        _find_modes(self._votes, vote_count, start, person_rows, prior, joints, support, agree)
        return joints, support, agree
