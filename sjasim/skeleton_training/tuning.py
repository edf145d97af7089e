"""What is learnt after the forests have grown: when a joint counts as tracked, and how postures hang together."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..choreography.layout import Mount
from ..config import MAX_TRACKED_PERSONS
from ..core import Array
from ..core.clock import stream
from ..sensors.skeleton import posture_prior
from ..sensors.skeleton.estimator import JOINT_VOTE_POINTS, MIN_SURFACE_M2, sampling_fractions
from ..sensors.skeleton.joint_voting import JointVoter
from ..sensors.skeleton.trained_model import SkeletonModel, runtime_model
from .samples import TrainingSensor, in_body
from .scenes import Scene

GOOD_M = 0.12
"""A joint nearer than this to the truth had better be tracked."""
FALSE_COST = 0.1
"""Cost of tracking a joint that is not there, over that of not tracking one that is."""
RIDGE = 0.3
POSTURE_M, POSTURE_YAW_RAD = 0.02, 0.1
"""Standard deviations of tracked joints and yaws that the posture's regression must live with."""
LIMBS = [
    [index for index, name in enumerate(JOINTS) if name.endswith(side) and name.startswith(parts)]
    for parts in (("Elbow", "Wrist", "Hand", "Thumb"), ("Knee", "Ankle", "Foot"))
    for side in ("Left", "Right")
]
"""Joints that are hidden together: arms, then legs."""
_BASE = JOINT_INDEX["SpineBase"]
_OTHER = {"Left": "Right", "Right": "Left"}
_TWINS = [JOINT_INDEX[re.sub("Left|Right", lambda side: _OTHER[side[0]], name)] for name in JOINTS]
"""The same joint on the other side, or the joint itself."""


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


def estimate(scenes: Iterable[tuple[Mount, Scene]], model: SkeletonModel, seed: int, name: str) -> Estimates:
    """Let a model see scenes that it was not trained on."""
    watcher, votes = TrainingSensor(seed, name), JointVoter(runtime_model(model), MAX_TRACKED_PERSONS)
    rows: list[tuple[Array, ...]] = []
    fx = watcher.intrinsics.fx
    for mount, scene in scenes:
        seen = watcher.see(mount, scene)
        joints, support, _ = votes.find_joints(
            seen.scene, sampling_fractions(seen.counts, JOINT_VOTE_POINTS), fx, seen.persons, seen.prior
        )
        enough = seen.counts * seen.joints[:, _BASE, 2] ** 2 > MIN_SURFACE_M2 * fx * fx
        for k in np.flatnonzero(enough & np.isfinite(joints).all(axis=(1, 2))):
            rows.append((joints[k], support[k], seen.joints[k], seen.persons[k], seen.yaw_rad[k]))
    return Estimates(*(np.array(column) for column in zip(*rows, strict=True)))


def mean_posture(scenes: Iterable[tuple[Mount, Scene]]) -> NDArray[np.float16]:
    """(25, 3) mean of all dancers in their own frames, over their scale [m]."""
    rows = []
    for mount, scene in scenes:
        joints = points(mount, scene)
        joints[:, :, [0, 2]] -= joints[:, _BASE : _BASE + 1, [0, 2]]
        yaw = scene.yaw_rad
        persons = np.stack([yaw, yaw, yaw, scene.stature_m / 1.75, np.cos(yaw), np.sin(yaw)], axis=1)
        rows.append(in_body(joints, np.repeat(persons[:, None], len(JOINTS), axis=1)))
    return np.asarray(np.concatenate(rows).mean(axis=0), dtype=np.float16)


def thresholds(found: Estimates) -> NDArray[np.float32]:
    """(25,) weight of votes above which a joint is tracked: where good and bad estimates part best.

    A joint and its twin on the other side share theirs: bodies are symmetric, and bad estimates are few.
    """
    out = np.zeros(len(JOINTS), np.float32)
    for j, twin in enumerate(_TWINS):
        good, support = found.error_m[:, [j, twin]].ravel() < GOOD_M, found.support[:, [j, twin]].ravel()
        levels = np.percentile(support, np.arange(0.5, 70.0, 0.5))
        above = support[:, None] > levels
        kept = (above & good[:, None]).sum(axis=0) / max(good.sum(), 1)
        wrong = (above & ~good[:, None]).sum(axis=0) / max((~good).sum(), 1)
        out[j] = levels[int((kept - FALSE_COST * wrong).argmax())]
    return out


def regress(scenes: Iterable[tuple[Mount, Scene]], mean: Array, seed: int) -> NDArray[np.float16]:
    """(104, 75) ridge regression of the whole posture from the joints that are tracked.

    Learnt from true joints with errors of the forest's size, of which some are hidden: single ones, limbs, sides.
    """
    rng = stream(seed, "training", "posture")
    rows, goals = [], []
    for mount, scene in scenes:
        for true, yaw, stature in zip(points(mount, scene), scene.yaw_rad, scene.stature_m, strict=True):
            tracked_yaw = float(yaw + POSTURE_YAW_RAD * rng.standard_normal())
            scale = float(stature / 1.75)
            joints = true + POSTURE_M * rng.standard_normal(true.shape)
            row, place = np.empty(posture_prior.FEATURE_COUNT), np.empty(2)
            if not posture_prior.regression_input(joints, _hidden(rng), mean, tracked_yaw, scale, 0.0, row, place):
                continue
            rows.append(row)
            body = posture_prior.body_from_sensor(true - [place[0], 0.0, place[1]], tracked_yaw) / scale - mean
            goals.append(body.ravel())
    x, y = np.array(rows), np.array(goals)
    return np.asarray(np.linalg.solve(x.T @ x + RIDGE * np.eye(x.shape[1]), x.T @ y), dtype=np.float16)


def remember(scenes: Iterable[tuple[Mount, Scene]], mean: Array) -> NDArray[np.float16]:
    """(N, 75) postures of the dance in the frame that the regression's are in, each less the mean one."""
    rows, all_seen = [], np.ones(len(JOINTS), dtype=bool)
    for mount, scene in scenes:
        true = points(mount, scene)
        for k in np.flatnonzero(scene.danced):
            row, place = np.empty(posture_prior.FEATURE_COUNT), np.empty(2)
            scale = float(scene.stature_m[k] / 1.75)
            posture_prior.regression_input(true[k], all_seen, mean, float(scene.yaw_rad[k]), scale, 0.0, row, place)
            rows.append(row[: 3 * len(JOINTS)])
    return np.array(rows, dtype=np.float16)


def points(mount: Mount, scene: Scene) -> Array:
    """(D, 25, 3) true joints as a sensor's points: x, height, z [m]."""
    joints = (scene.joints_m - mount.position) @ mount.world_from_sensor
    joints[:, :, 1] += mount.position[2]
    return np.asarray(joints)


def _hidden(rng: np.random.Generator) -> NDArray[np.bool_]:
    """Which joints are seen: all but a few, a limb or two, the lower half, or one side."""
    seen = rng.random(len(JOINTS)) >= rng.choice([0.0, 0.1, 0.4])
    for limb in LIMBS:
        if rng.random() < 0.25:
            seen[limb] = False
    luck = rng.random()
    if luck < 0.10:
        seen[LIMBS[2]] = seen[LIMBS[3]] = False
    elif luck < 0.25:
        side = int(rng.integers(2))
        seen[LIMBS[side]] = seen[LIMBS[2 + side]] = False
    return np.asarray(seen)
