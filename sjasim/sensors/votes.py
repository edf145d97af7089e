"""Pixels through the forests, their votes for joints and for the yaw, and where the votes for a joint agree.

Source: shotton2013, section 3 (depth differences at offsets that shrink with distance); girshick2011, section 4
(votes relative to the pixel, mean shift). Unlike there, offsets live in the person's frame: turned by the tracked
yaw and scaled by the estimated stature, so that one leaf serves every heading and every build.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..types import Array
from .model import EXTRAS, Unpacked
from .segmentation import Foreground, Image, Owners, Pixels, Points

CLIP_M = 0.6
"""Depth differences beyond this say only: something else, before or behind (assumed)."""
BANDWIDTHS_M = (0.22, 0.09, 0.05)
"""Of the mean shift, one for every step (assumed)."""
FLOOR_SPREAD_M = 0.03
"""Added to a vote's spread before it becomes a weight (assumed)."""
SURE_M = 0.10
"""Votes with a larger spread do not make a joint tracked (assumed)."""
LOOSE_M = 0.20
"""Votes with a larger spread are not worth their time (assumed)."""
FIRST_M = 0.12
"""Votes with a larger spread do not say where to begin (assumed)."""
LIMB_M, LIMB_SHARE = (0.20, 0.15), 4
"""A point so far beside the trunk, or before it, is a limb's; so many times more of these vote (assumed)."""

Column = NDArray[np.float64]
Nodes = NDArray[np.float32]


@njit(cache=True, error_model="numpy")
def _probe(image: Image, v: int, u: int, z: float, left: float, up: float) -> float:
    """Depth difference to the point so many pixels to the left of a pixel and above it, clipped [m]."""
    row, column = v - (int(up + 4096.5) - 4096), u + (int(left + 4096.5) - 4096)
    if row < 0 or row >= image.shape[0] or column < 0 or column >= image.shape[1]:
        return CLIP_M
    return float(min(max(image[row, column] - z, -CLIP_M), CLIP_M))


@njit(cache=True, error_model="numpy")
def _extra(k: int, p: Points, person: Column) -> float:
    """Features beyond the probes, in the order that `model.EXTRAS` tells."""
    scale = person[3]
    if k == 0:
        return float(p[1] / scale)
    x, z = (p[0] - person[0]) / scale, (p[2] - person[1]) / scale
    if k <= 2:
        return float(x if k == 1 else z)
    if k <= 4:
        return float(person[2] if k == 3 else scale)
    cos, sin = person[4], person[5]
    if k <= 6:
        return float(-sin * x - cos * z if k == 5 else -cos * x + sin * z)
    return float(cos if k == 7 else sin)


@njit(cache=True, error_model="numpy")
def _leaf(root: int, nodes: Nodes, image: Image, v: int, u: int, p: Points, reach: float, person: Column) -> int:
    """Number of the leaf that a pixel falls into; ``reach`` is pixels per metre of the model's person."""
    k, z = root, p[2]
    left = nodes[k, 5]
    while left >= 0.0:
        asks = nodes[k, 7]
        if asks < 2.0:
            answer = _probe(image, v, u, z, nodes[k, 1] * reach, nodes[k, 2] * reach)
            if asks == 1.0:
                answer -= _probe(image, v, u, z, nodes[k, 3] * reach, nodes[k, 4] * reach)
        else:
            answer = _extra(int(asks) - 2, p, person)
        k = int(left) if answer <= nodes[k, 0] else int(nodes[k, 6])
        left = nodes[k, 5]
    return -1 - int(left)


@njit(cache=True, error_model="numpy")
def _answers(
    probes: NDArray[np.float32], image: Image, pixel: Pixels, point: Points, rows: NDArray[np.int64], fx: float,
    person: Column, out: NDArray[np.float32],
) -> None:  # fmt: skip
    for q in range(len(rows)):
        i = rows[q]
        reach = fx * person[3] / point[i, 2]
        v, u, z = pixel[i, 0], pixel[i, 1], point[i, 2]
        for k in range(len(probes)):
            out[q, k] = _probe(image, v, u, z, probes[k, 0] * reach, probes[k, 1] * reach)
            if probes[k, 2] != 0.0 or probes[k, 3] != 0.0:
                out[q, k] -= _probe(image, v, u, z, probes[k, 2] * reach, probes[k, 3] * reach)
        for k in range(out.shape[1] - len(probes)):
            out[q, len(probes) + k] = _extra(k, point[i], person)


def answers(
    scene: Foreground, rows: NDArray[np.int64], probes: NDArray[np.float32], fx: float, person: Array
) -> Points:
    """All features of some points, for training.

    Args:
        scene: the frame.
        rows: (Q,) rows of its points.
        probes: (F, 4) offsets [m].
        fx: focal length over the width of a pixel.
        person: (6,) x, z, chest width [m], scale, cosine and sine of the yaw.

    Returns:
        (Q, F + 9) features.
    """
    out = np.empty((len(rows), len(probes) + EXTRAS), np.float32)
    _answers(probes, scene.image, scene.pixel, scene.point, rows, fx, person, out)
    return out


@njit(cache=True, error_model="numpy")
def _yaws(
    nodes: Nodes, roots: NDArray[np.int32], vote: NDArray[np.float32], image: Image, pixel: Pixels,
    point: Points, owner: Owners, count: int, stride: NDArray[np.int64], fx: float, persons: Array, out: Array,
) -> None:  # fmt: skip
    seen = np.zeros(len(persons), np.int64)
    for i in range(count):
        k = owner[i]
        if k < 0:
            continue
        seen[k] += 1
        if seen[k] % stride[k]:
            continue
        reach = fx * persons[k, 3] / point[i, 2]
        for t in range(len(roots)):
            leaf = _leaf(roots[t], nodes, image, pixel[i, 0], pixel[i, 1], point[i], reach, persons[k])
            sure = vote[leaf, 0] ** 2 + vote[leaf, 1] ** 2
            out[k, 0] += sure * vote[leaf, 0]
            out[k, 1] += sure * vote[leaf, 1]
            out[k, 2] += 1.0


def yaw_votes(scene: Foreground, model: Unpacked, strides: NDArray[np.int64], fx: float, persons: Array) -> Array:
    """How the persons stand, each frame for itself.

    Args:
        scene: with owners.
        model: the trained model.
        strides: (P,) one in so many points is asked.
        fx: focal length over the width of a pixel.
        persons: (P, 6) as in `answers`; the yaw is not looked at.

    Returns:
        (P, 3) sums of cosines and sines, weighted with the leaves' certainty, and number of votes.
    """
    out = np.zeros((len(persons), 3))
    _yaws(
        model.yaws.node, model.yaws.roots, model.yaw_vote, scene.image, scene.pixel, scene.point,
        scene.owner, scene.count, strides, fx, persons, out,
    )  # fmt: skip
    return out


@njit(cache=True, error_model="numpy")
def _votes(
    nodes: Nodes, roots: NDArray[np.int32], joint: NDArray[np.int32], offset: NDArray[np.float32],
    spread: NDArray[np.float32], image: Image, pixel: Pixels, point: Points, owner: Owners, count: int,
    stride: NDArray[np.int64], fx: float, persons: Array, where: NDArray[np.int32], place: NDArray[np.float32],
) -> int:  # fmt: skip
    """Write every vote's person and joint (``where``), its position, weight and spread (``place``)."""
    seen = np.zeros((len(persons), 2), np.int64)
    n, most = 0, len(where) - joint.shape[1] * len(roots)
    for i in range(count):
        k = owner[i]
        if k < 0:
            continue
        scale, cos, sin = persons[k, 3], persons[k, 4], persons[k, 5]
        aside = abs(point[i, 0] - persons[k, 0]) > LIMB_M[0] * scale
        apart = aside or point[i, 2] < persons[k, 1] - LIMB_M[1] * scale
        step = max(stride[k] // LIMB_SHARE, 1) if apart else stride[k]
        seen[k, int(apart)] += 1
        if seen[k, int(apart)] % step or n >= most:
            continue
        reach = fx * scale / point[i, 2]
        surface = step * (point[i, 2] / (scale * fx)) ** 2
        for t in range(len(roots)):
            leaf = _leaf(roots[t], nodes, image, pixel[i, 0], pixel[i, 1], point[i], reach, persons[k])
            for q in range(joint.shape[1]):
                wide = spread[leaf, q]
                if wide > LOOSE_M:
                    continue
                forward, up, left = offset[leaf, q, 0] * scale, offset[leaf, q, 1] * scale, offset[leaf, q, 2] * scale
                where[n, 0], where[n, 1] = k, joint[leaf, q]
                place[n, 0] = point[i, 0] - sin * forward - cos * left
                place[n, 1] = point[i, 1] + up
                place[n, 2] = point[i, 2] - cos * forward + sin * left
                place[n, 3] = surface / (wide * wide + FLOOR_SPREAD_M * FLOOR_SPREAD_M) ** 2
                place[n, 4] = wide
                n += 1
    return n


@njit(cache=True, error_model="numpy")
def _begin(n: int, where: NDArray[np.int32], place: NDArray[np.float32], prior: Array, joints: Array) -> None:
    """Start from the sure votes' mean, half way to the prediction where there is one."""
    total = np.zeros((joints.shape[0], joints.shape[1], 4))
    for i in range(n):
        if place[i, 4] < FIRST_M:
            row = total[where[i, 0], where[i, 1]]
            row[3] += place[i, 3]
            for c in range(3):
                row[c] += place[i, 3] * place[i, c]
    for k in range(joints.shape[0]):
        for j in range(joints.shape[1]):
            known = not math.isnan(prior[k, j, 0])
            for c in range(3):
                if total[k, j, 3] > 0.0:
                    joints[k, j, c] = total[k, j, c] / total[k, j, 3]
                    if known:
                        joints[k, j, c] = 0.5 * (joints[k, j, c] + prior[k, j, c])
                else:
                    joints[k, j, c] = prior[k, j, c]


@njit(cache=True, error_model="numpy")
def _shift(
    n: int, where: NDArray[np.int32], place: NDArray[np.float32], persons: Array, prior: Array, joints: Array,
    support: Array,
) -> None:  # fmt: skip
    _begin(n, where, place, prior, joints)
    total = np.zeros((joints.shape[0], joints.shape[1], 4))
    for step in range(len(BANDWIDTHS_M)):
        last = step == len(BANDWIDTHS_M) - 1
        total[:] = 0.0
        for i in range(n):
            k, j = where[i, 0], where[i, 1]
            wide = BANDWIDTHS_M[step] * persons[k, 3]
            x, y, z = place[i, 0] - joints[k, j, 0], place[i, 1] - joints[k, j, 1], place[i, 2] - joints[k, j, 2]
            away = (x * x + y * y + z * z) / (wide * wide)
            if not away < 9.0:
                continue
            kernel = 1.0 / ((1.0 + away) * (1.0 + away))
            weight = place[i, 3] * kernel
            total[k, j, 0] += weight * x
            total[k, j, 1] += weight * y
            total[k, j, 2] += weight * z
            total[k, j, 3] += weight
            if last and place[i, 4] < SURE_M:
                support[k, j] += weight
        for k in range(joints.shape[0]):
            for j in range(joints.shape[1]):
                if total[k, j, 3] > 0.0:
                    for c in range(3):
                        joints[k, j, c] += total[k, j, c] / total[k, j, 3]


class Votes:
    """Room for the votes of one frame, and the model they come from.

    Args:
        model: the trained model.
        most: how many votes there is room for; more are not counted.
    """

    def __init__(self, model: Unpacked, most: int = 400_000) -> None:
        self._model = model
        self._where = np.empty((most, 2), np.int32)
        self._place = np.empty((most, 5), np.float32)

    def joints(
        self, scene: Foreground, strides: NDArray[np.int64], fx: float, persons: Array, prior: Array
    ) -> tuple[Array, Array]:
        """Find the joints of all persons.

        Args:
            scene: with owners.
            strides: (P,) one in so many points votes.
            fx: focal length over the width of a pixel.
            persons: (P, 6) as in `answers`.
            prior: (P, 25, 3) predicted joints as points, NaN where nothing is known [m].

        Returns:
            (P, 25, 3) joints as points, NaN where neither a vote nor the prediction says anything [m], and (P, 25)
            the weight of the votes that agree.
        """
        m = self._model
        n = _votes(
            m.joints.node, m.joints.roots, m.joint, m.offset, m.spread, scene.image, scene.pixel,
            scene.point, scene.owner, scene.count, strides, fx, persons, self._where, self._place,
        )  # fmt: skip
        joints, support = np.full(prior.shape, np.nan), np.zeros(prior.shape[:2])
        _shift(n, self._where, self._place, persons, prior, joints, support)
        return joints, support
