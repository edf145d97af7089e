"""What is learnt after the forests have grown: when a joint counts as tracked, and how postures hang together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..choreography.layout import Mount
from ..clock import stream
from ..sensors import posture
from ..sensors.model import Model, unpacked
from ..sensors.skeleton import LEAST_M2, VOTING, strides
from ..sensors.votes import Votes
from ..types import Array
from .samples import Watcher, in_body
from .scenes import Scene

GOOD_M = 0.12
"""A joint nearer than this to the truth had better be tracked."""
FALSE_COST = 0.6
"""Cost of tracking a joint that is not there, over that of not tracking one that is."""
RIDGE = 1.0
_BASE = JOINT_INDEX["SpineBase"]


@dataclass(frozen=True, slots=True)
class Estimates:
    """What a forest said of persons, with the truth.

    Attributes:
        joints: (N, 25, 3) votes' joints as points [m].
        support: (N, 25) weight of the votes.
        true: (N, 25, 3) true joints [m].
        persons: (N, 6) what the forest was told of each person.
        yaw_rad: (N,) true yaws.
    """

    joints: Array
    support: Array
    true: Array
    persons: Array
    yaw_rad: Array

    @property
    def error_m(self) -> Array:
        """(N, 25) distances between estimate and truth."""
        return np.asarray(np.linalg.norm(self.joints - self.true, axis=2))


def estimate(scenes: Iterable[tuple[Mount, Scene]], model: Model, seed: int, name: str) -> Estimates:
    """Let a model see scenes that it was not trained on."""
    watcher, votes = Watcher(seed, name), Votes(unpacked(model))
    rows: list[tuple[Array, ...]] = []
    fx = watcher.intrinsics.fx
    for mount, scene in scenes:
        seen = watcher.see(mount, scene)
        joints, support = votes.joints(seen.scene, strides(seen.counts, VOTING), fx, seen.persons, seen.prior)
        enough = seen.counts * seen.joints[:, _BASE, 2] ** 2 > LEAST_M2 * fx * fx
        for k in np.flatnonzero(enough & np.isfinite(joints).all(axis=(1, 2))):
            rows.append((joints[k], support[k], seen.joints[k], seen.persons[k], seen.yaw_rad[k]))
    return Estimates(*(np.array(column) for column in zip(*rows, strict=True)))


def mean_posture(scenes: Iterable[tuple[Mount, Scene]]) -> NDArray[np.float16]:
    """(25, 3) mean of all dancers in their own frames, over their scale [m]."""
    rows = []
    for mount, scene in scenes:
        joints = (scene.joints_m - mount.position) @ mount.world_from_sensor
        joints[:, :, 1] += mount.position[2]
        joints[:, :, [0, 2]] -= joints[:, _BASE : _BASE + 1, [0, 2]]
        yaw = scene.yaw_rad
        persons = np.stack([yaw, yaw, yaw, scene.stature_m / 1.75, np.cos(yaw), np.sin(yaw)], axis=1)
        rows.append(in_body(joints, np.repeat(persons[:, None], len(JOINTS), axis=1)))
    return np.concatenate(rows).mean(axis=0).astype(np.float16)


def thresholds(found: Estimates) -> NDArray[np.float32]:
    """(25,) weight of votes above which a joint is tracked: where good and bad estimates part best."""
    error, out = found.error_m, np.zeros(len(JOINTS), np.float32)
    for j in range(len(JOINTS)):
        good = error[:, j] < GOOD_M
        levels = np.percentile(found.support[:, j], np.arange(0.5, 70.0, 0.5))
        above = found.support[:, j][:, None] > levels
        kept = (above & good[:, None]).sum(axis=0) / max(good.sum(), 1)
        wrong = (above & ~good[:, None]).sum(axis=0) / max((~good).sum(), 1)
        out[j] = levels[int((kept - FALSE_COST * wrong).argmax())]
    return out


def regress(found: Estimates, support: Array, mean: Array, seed: int) -> NDArray[np.float16]:
    """(104, 75) ridge regression of the whole posture from the joints that are tracked.

    Every person is shown three times: as seen, and twice with further joints hidden at random.
    """
    rng = stream(seed, "training", "posture")
    rows, goals = [], []
    for n in range(len(found.joints)):
        joints, person = found.joints[n], found.persons[n]
        yaw = float(np.arctan2(person[5], person[4]))
        scale, width = float(person[3]), float(person[2])
        for hidden in (0.0, 0.3 * rng.random(), 0.6 * rng.random()):
            seen = (found.support[n] > support) & (rng.random(len(JOINTS)) >= hidden)
            made = posture.features(joints, seen, mean, yaw, scale, width)
            if made is None:
                continue
            row, place = made
            rows.append(row)
            body = posture.towards_body(found.true[n] - [place[0], 0.0, place[1]], yaw) / scale - mean
            goals.append(body.ravel())
    x, y = np.array(rows), np.array(goals)
    return np.linalg.solve(x.T @ x + RIDGE * np.eye(x.shape[1]), x.T @ y).astype(np.float16)
