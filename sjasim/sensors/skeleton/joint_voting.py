"""What the leaves of the forests vote for: joints and the yaw, and where the votes for a joint agree.

Source: girshick2011, section 4 (votes relative to the pixel, mean shift). Unlike there, offsets live in the person's
frame: turned by the tracked yaw and scaled by the estimated stature, so that one leaf serves every heading and every
build.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...core import Array, IntArray
from ...core.memory import put
from .forest import EXTRA_FEATURES, LEAF, Leaves, Nodes, find_leaves, write_extra_features
from .segmentation import Foreground, Image, Owners, Pixels, Points
from .trained_model import OFFSET_UNIT_M, SPREAD_UNIT_M, RuntimeModel

BANDWIDTHS_M = np.array([0.22, 0.09, 0.05])
"""Of the mean shift, one for every step (assumed)."""
FAR = 9.0
"""Votes beyond three bandwidths, here squared, are not looked at."""
FLOOR_SPREAD_M = 0.03
"""Added to a vote's spread before it becomes a weight (assumed)."""
SURE_M = 0.10
"""Votes with a larger spread do not make a joint tracked (assumed)."""
MAX_SPREAD_M = 0.15
"""Votes with a larger spread are not worth their time (assumed)."""
FIRST_M = 0.12
"""Votes with a larger spread do not say where to begin (assumed)."""
LIMB_M, LIMB_SHARE = (0.20, 0.15), 16
"""A point so far beside the trunk, or before it, is a limb's; so many times more of these vote (assumed)."""
MIN_VOTES = 4
"""Fewer votes than these say nothing of an arm: they are one stray pixel's (measured: of hands that were tracked more
than 15 cm off, nine in ten had one or two, of those well found one in twenty had less than four)."""
AGREE = 4.0
"""Votes within two bandwidths, here squared, agree."""
STAY = 2.0
"""An arm's joint is looked for at its prediction, too; elsewhere so many times the weight must agree (assumed)."""
MAX_VOTES = 4000
"""Room for so many votes for one joint of one person; more are not counted. Not a power of two: a cache would have a
single place for the votes of all joints."""

_ARM = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb")) for name in JOINTS])
Floats = NDArray[np.float32]
_SPREADS_M = SPREAD_UNIT_M * np.arange(256)
_WEIGHTS = ((_SPREADS_M**2 + FLOOR_SPREAD_M**2) ** -2).astype(np.float32)
_LOOSE, _FIRST, _SURE = (int(np.searchsorted(_SPREADS_M, limit_m)) for limit_m in (MAX_SPREAD_M, FIRST_M, SURE_M))
X, Y, Z, WEIGHT, SURE = range(5)
"""Columns of a vote: where [m], how much they count, and how much for being tracked."""


@njit(cache=True, error_model="numpy", inline="always")
def _rank(v: int, u: int) -> float:
    """A number from 0 to 1 that is spread evenly over any patch of pixels, and always the same at a pixel.

    Those below a share are that share of the pixels; one who stands still is asked at the same pixels in every frame.
    Source: roberts2018, the generalised golden ratio in two dimensions.
    """
    along = 0.7548776662466927 * u + 0.5698402909980532 * v
    return float(along - math.floor(along))


@njit(cache=True, error_model="numpy")
def _yaws(
    nodes: Nodes, roots: Leaves, vote: Floats, image: Image, pixel: Pixels, point: Points, owner: Owners, count: int,
    share: Array, fx: np.float32, persons: Floats, out: Array,
) -> None:  # fmt: skip
    extra, at = np.zeros(1 + EXTRA_FEATURES, np.int32), np.empty(len(roots), np.int32)
    for i in range(count):
        k = owner[i]
        if k < 0 or _rank(pixel[i, 0], pixel[i, 1]) >= share[k]:
            continue
        write_extra_features(point[i], persons[k], extra)
        put(at, roots)
        find_leaves(nodes, image, pixel[i, 0], pixel[i, 1], fx * persons[k, 3] / point[i, 2], extra, at)
        for node in at:
            leaf = int(nodes[node, LEAF])
            sure = vote[leaf, 0] ** 2 + vote[leaf, 1] ** 2
            out[k, 0] += sure * vote[leaf, 0]
            out[k, 1] += sure * vote[leaf, 1]
            out[k, 2] += 1.0


def yaw_votes(scene: Foreground, model: RuntimeModel, shares: Array, fx: float, persons: Array) -> Array:
    """How the persons stand, each frame for itself.

    Args:
        scene: with owners.
        model: the trained model.
        shares: (P,) which part of the points is asked.
        fx: focal length over the width of a pixel.
        persons: (P, 6) as in `forest.answers`; the yaw is not looked at.

    Returns:
        (P, 3) sums of cosines and sines, weighted with the leaves' certainty, and number of votes.
    """
    out = np.zeros((len(persons), 3))
    _yaws(
        model.yaw_nodes, model.yaw_roots, model.yaw_vote, scene.image, scene.pixel, scene.point, scene.owner,
        scene.count, shares, np.float32(fx), persons.astype(np.float32), out,
    )  # fmt: skip
    return out


@njit(cache=True, error_model="numpy")
def _cast_votes(
    nodes: Nodes, roots: Leaves, votes: Nodes, image: Image, pixel: Pixels, point: Points, owner: Owners, count: int,
    share: Array, fx: np.float32, persons: Floats, cast: Floats, many: IntArray, first: Array,
) -> None:  # fmt: skip
    """Write every joint's votes (``cast``, ``many``), and add up the sure ones' places and weights (``first``)."""
    extra, at = np.zeros(1 + EXTRA_FEATURES, np.int32), np.empty(len(roots), np.int32)
    for i in range(count):
        k = owner[i]
        if k < 0:
            continue
        rank = _rank(pixel[i, 0], pixel[i, 1])
        part = min(LIMB_SHARE * share[k], 1.0)
        if rank >= part:
            continue
        x, y, z, scale = point[i, 0], point[i, 1], point[i, 2], persons[k, 3]
        if abs(x - persons[k, 0]) <= LIMB_M[0] * scale and z >= persons[k, 1] - LIMB_M[1] * scale:
            part = share[k]
            if rank >= part:
                continue
        reach = fx * scale / z
        write_extra_features(point[i], persons[k], extra)
        put(at, roots)
        find_leaves(nodes, image, pixel[i, 0], pixel[i, 1], reach, extra, at)
        surface = np.float32(1.0 / part) / (reach * reach)
        size = np.float32(OFFSET_UNIT_M) * scale
        cos, sin = persons[k, 4] * size, persons[k, 5] * size
        for node in at:
            leaf = np.uint32(nodes[np.uint32(node), LEAF])
            for q in range(votes.shape[1]):
                wide = votes[leaf, q, 5]
                if wide >= _LOOSE:
                    break
                row = np.uint32(k * len(JOINTS) + votes[leaf, q, 6])
                n = np.uint32(many[row])
                if n == MAX_VOTES:
                    continue
                many[row] = n + 1
                ahead, up, left = votes[leaf, q, 0], votes[leaf, q, 1], votes[leaf, q, 2]
                weight = surface * _WEIGHTS[wide]
                cast[row, n, X] = x - sin * ahead - cos * left + size * votes[leaf, q, 3]
                cast[row, n, Y] = y + size * up
                cast[row, n, Z] = z - cos * ahead + sin * left + size * votes[leaf, q, 4]
                cast[row, n, WEIGHT] = weight
                cast[row, n, SURE] = weight if wide < _SURE else np.float32(0.0)
                if wide < _FIRST:
                    for c in range(3):
                        first[row, c] += weight * cast[row, n, c]
                    first[row, 3] += weight


@njit(cache=True, error_model="numpy", fastmath=True)
def _pull(votes: Floats, n: int, joint: Array, wide_m: float, pull: Array) -> None:
    """Write what the votes near a joint pull it by, their weight, that of sure ones, and how many of these agree."""
    a, b, c = np.float32(joint[0]), np.float32(joint[1]), np.float32(joint[2])
    per = np.float32(1.0 / (wide_m * wide_m))
    one, far, near, none = np.float32(1.0), np.float32(FAR), np.float32(AGREE), np.float32(0.0)
    dx = dy = dz = total = sure = agree = none
    for i in range(n):
        x, y, z = votes[X, i] - a, votes[Y, i] - b, votes[Z, i] - c
        away = (x * x + y * y + z * z) * per
        kernel = one / ((one + away) * (one + away)) if away < far else none
        weight = votes[WEIGHT, i] * kernel
        dx += weight * x
        dy += weight * y
        dz += weight * z
        total += weight
        sure += votes[SURE, i] * kernel
        agree += one if away < near and votes[SURE, i] > none else none
    pull[0], pull[1], pull[2], pull[3], pull[4], pull[5] = dx, dy, dz, total, sure, agree


@njit(cache=True, error_model="numpy")
def _shift(votes: Floats, n: int, joint: Array, scale: float, first: int, pull: Array) -> None:
    """Mean shift of one joint, from the bandwidth of that number on; ``pull`` is that of the last step."""
    for step in range(first, len(BANDWIDTHS_M)):
        _pull(votes, n, joint, BANDWIDTHS_M[step] * scale, pull)
        if pull[3] > 0.0:
            joint += pull[:3] / pull[3]


@njit(cache=True, error_model="numpy")
def _find_modes(
    cast: Floats, many: IntArray, first: Array, persons: Floats, prior: Array, joints: Array, support: Array,
    agree: Array,
) -> None:  # fmt: skip
    """Mean shift of every joint, from half way between the sure votes' mean and the prediction, if there are both.

    That of an arm begins at the prediction, too, and stays there unless much more speaks for the other place: a hand
    shows few pixels, and one of another limb's that takes itself for it is soon the only one.
    """
    pull, there, votes = np.zeros(6), np.zeros(6), np.empty((5, MAX_VOTES), np.float32)
    here = np.zeros(3)
    for row in range(len(many)):
        k, j = row // len(JOINTS), row % len(JOINTS)
        joint = joints[k, j]
        put(joint, prior[k, j])
        put(here, prior[k, j])
        if first[row, 3] > 0.0:
            known = 0.0 if math.isnan(joint[0]) else 0.5
            for c in range(3):
                mean = first[row, c] / first[row, 3]
                joint[c] = mean if known == 0.0 else 0.5 * (mean + joint[c])
        if many[row] == 0 or math.isnan(joint[0]):
            continue
        for n in range(many[row]):
            for c in range(5):
                votes[c, n] = cast[row, n, c]
        _shift(votes, many[row], joint, persons[k, 3], 0, pull)
        if _ARM[j] and not math.isnan(here[0]):
            put(there, pull)
            _shift(votes, many[row], here, persons[k, 3], 1, pull)
            if there[5] >= MIN_VOTES and there[4] > pull[4] * (STAY if pull[5] >= MIN_VOTES else 0.0):
                put(pull, there)
            else:
                put(joint, here)
        support[k, j], agree[k, j] = pull[4], pull[5]


class JointVoter:
    """Room for the votes of one frame, and the model they come from.

    Args:
        model: the trained model.
        most: how many persons there is room for.
    """

    def __init__(self, model: RuntimeModel, most: int) -> None:
        self._model = model
        self._cast = np.empty((most * len(JOINTS), MAX_VOTES, 5), np.float32)

    def find_joints(
        self, scene: Foreground, shares: Array, fx: float, persons: Array, prior: Array
    ) -> tuple[Array, Array, Array]:
        """Find the joints of all persons.

        Args:
            scene: with owners.
            shares: (P,) which part of the points votes.
            fx: focal length over the width of a pixel.
            persons: (P, 6) as in `forest.answers`.
            prior: (P, 25, 3) predicted joints as points, NaN where nothing is known [m].

        Returns:
            (P, 25, 3) joints as points, NaN where neither a vote nor the prediction says anything [m]; (P, 25) the
            weight of the votes that agree, and how many they are.
        """
        m, rows = self._model, len(persons) * len(JOINTS)
        many, first = np.zeros(rows, np.int64), np.zeros((rows, 4))
        rough = persons.astype(np.float32)
        _cast_votes(
            m.nodes, m.roots, m.votes, scene.image, scene.pixel, scene.point, scene.owner, scene.count, shares,
            np.float32(fx), rough, self._cast, many, first,
        )  # fmt: skip
        joints, support, agree = np.empty(prior.shape), np.zeros(prior.shape[:2]), np.zeros(prior.shape[:2])
        _find_modes(self._cast, many, first, rough, prior, joints, support, agree)
        return joints, support, agree
