"""Parts of the skeleton model that are fitted after the forests: thresholds, posture regression, reference postures."""

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
from .samples import TrainingSensor, in_person_frame, joint_points
from .scenes import Scene

GOOD_M = 0.12
"""Largest error of an estimated joint that should be tracked."""

FALSE_COST = 0.1
"""Cost of tracking a bad estimate over the cost of not tracking a good one."""

RIDGE = 0.3
"""Ridge penalty of the posture regression."""

REFERENCE_STATURE_M = 1.75
"""Stature of a person of scale 1."""

JOINT_ERROR_M = 0.02
"""Standard deviation of tracked joints in the data of the posture regression."""

YAW_ERROR_RAD = 0.1
"""Standard deviation of tracked headings in the data of the posture regression."""

LIMBS = [
    [index for index, name in enumerate(JOINTS) if name.endswith(side) and name.startswith(parts)]
    for parts in (("Elbow", "Wrist", "Hand", "Thumb"), ("Knee", "Ankle", "Foot"))
    for side in ("Left", "Right")
]
"""Joints that are occluded together: left arm, right arm, left leg, right leg."""

_BASE = JOINT_INDEX["SpineBase"]
_OPPOSITE = {"Left": "Right", "Right": "Left"}
_MIRRORED = [JOINT_INDEX[re.sub("Left|Right", lambda side: _OPPOSITE[side[0]], name)] for name in JOINTS]
"""The same joint on the other side of the body; joints of the spine are their own."""


@dataclass(frozen=True, slots=True)
class Estimates:
    """Joints that the forests estimate for N persons, with the truth.

    Attributes:
        joints: (N, 25, 3) estimated joints as points [m].
        support: (N, 25) weight of the votes for each joint.
        true: (N, 25, 3) true joints [m].
        persons: (N, 6) rows of person features that the forests used.
        yaw_rad: (N,) true headings.
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


def estimate_joints(scenes: Iterable[tuple[Mount, Scene]], model: SkeletonModel, seed: int, name: str) -> Estimates:
    """Estimate the joints of all persons in scenes with a model's forests.

    Persons with too few pixels, or without votes for some joint, are left out.

    Args:
        scenes: scenes with the mount of the sensor.
        model: the model; its thresholds are not used.
        seed: seed of depth noise and tracking errors.
        name: name of the random stream.
    """
    sensor = TrainingSensor(seed, name)
    voter = JointVoter(runtime_model(model), MAX_TRACKED_PERSONS)
    fx = sensor.intrinsics.fx
    rows: list[tuple[Array, ...]] = []
    for mount, scene in scenes:
        observed = sensor.observe_scene(mount, scene)
        fractions = sampling_fractions(observed.counts, JOINT_VOTE_POINTS)
        joints, support, _ = voter.find_joints(observed.foreground, fractions, fx, observed.persons, observed.prior)

        # A person's surface is the number of pixels times the area of a pixel at the person's distance.
        large_enough = observed.counts * observed.joints[:, _BASE, 2] ** 2 > MIN_SURFACE_M2 * fx * fx
        for k in np.flatnonzero(large_enough & np.isfinite(joints).all(axis=(1, 2))):
            rows.append((joints[k], support[k], observed.joints[k], observed.persons[k], observed.yaw_rad[k]))
    return Estimates(*(np.array(column) for column in zip(*rows, strict=True)))


def mean_posture(scenes: Iterable[tuple[Mount, Scene]]) -> NDArray[np.float16]:
    """Return (25, 3) the mean of all dancers' joints in their own frames, over their scale [m]."""
    rows = []
    for mount, scene in scenes:
        joints = joint_points(mount, scene)
        joints[:, :, [0, 2]] -= joints[:, _BASE : _BASE + 1, [0, 2]]
        yaw = scene.yaw_rad
        scale = scene.stature_m / REFERENCE_STATURE_M

        # Rows of person features, of which only scale, cosine and sine matter here.
        persons = np.stack([yaw, yaw, yaw, scale, np.cos(yaw), np.sin(yaw)], axis=1)
        rows.append(in_person_frame(joints, np.repeat(persons[:, None], len(JOINTS), axis=1)))
    return np.asarray(np.concatenate(rows).mean(axis=0), dtype=np.float16)


def support_thresholds(estimates: Estimates) -> NDArray[np.float32]:
    """Return (25,) the weight of votes above which each joint is tracked.

    The threshold maximises the share of good estimates above it minus `FALSE_COST` times the share of bad ones. A joint
    and its mirror image have the same threshold, because bodies are symmetric and bad estimates are few.
    """
    out = np.zeros(len(JOINTS), np.float32)
    for j, mirrored in enumerate(_MIRRORED):
        good = estimates.error_m[:, [j, mirrored]].ravel() < GOOD_M
        support = estimates.support[:, [j, mirrored]].ravel()
        # Candidate thresholds are percentiles of the support itself.
        levels = np.percentile(support, np.arange(0.5, 70.0, 0.5))
        above = support[:, None] > levels
        good_share = (above & good[:, None]).sum(axis=0) / max(good.sum(), 1)
        bad_share = (above & ~good[:, None]).sum(axis=0) / max((~good).sum(), 1)
        out[j] = levels[int((good_share - FALSE_COST * bad_share).argmax())]
    return out


def fit_posture_regression(scenes: Iterable[tuple[Mount, Scene]], mean: Array, seed: int) -> NDArray[np.float16]:
    """Return (104, 75) coefficients of a ridge regression of all joints from those that are tracked.

    The data are true joints with errors of the size of the forests' errors. Random joints, limbs and sides of the body
    are treated as not tracked.

    Args:
        scenes: scenes with the mount of the sensor.
        mean: (25, 3) mean posture [m].
        seed: seed of errors and occlusions.
    """
    rng = stream(seed, "training", "posture")
    rows = []
    goals = []
    for mount, scene in scenes:
        for true, yaw, stature_m in zip(joint_points(mount, scene), scene.yaw_rad, scene.stature_m, strict=True):
            tracked_yaw = float(yaw + YAW_ERROR_RAD * rng.standard_normal())
            scale = float(stature_m / REFERENCE_STATURE_M)
            joints = true + JOINT_ERROR_M * rng.standard_normal(true.shape)
            tracked = _random_tracked_joints(rng)

            row = np.empty(posture_prior.FEATURE_COUNT)
            place = np.empty(2)
            if not posture_prior.regression_input(joints, tracked, mean, tracked_yaw, scale, 0.0, row, place):
                continue
            rows.append(row)
            body = posture_prior.body_from_sensor(true - [place[0], 0.0, place[1]], tracked_yaw) / scale - mean
            goals.append(body.ravel())

    # Normal equations; the penalty keeps coefficients of joints that always move together small.
    x = np.array(rows)
    y = np.array(goals)
    return np.asarray(np.linalg.solve(x.T @ x + RIDGE * np.eye(x.shape[1]), x.T @ y), dtype=np.float16)


def reference_postures(scenes: Iterable[tuple[Mount, Scene]], mean: Array) -> NDArray[np.float16]:
    """Return (N, 75) postures of the dance in the frame of the regression, minus the mean posture [m]."""
    all_tracked = np.ones(len(JOINTS), dtype=bool)
    rows = []
    for mount, scene in scenes:
        true = joint_points(mount, scene)
        for k in np.flatnonzero(scene.danced):
            scale = float(scene.stature_m[k] / REFERENCE_STATURE_M)
            row = np.empty(posture_prior.FEATURE_COUNT)
            place = np.empty(2)
            posture_prior.regression_input(true[k], all_tracked, mean, float(scene.yaw_rad[k]), scale, 0.0, row, place)
            rows.append(row[: 3 * len(JOINTS)])
    return np.array(rows, dtype=np.float16)


def _random_tracked_joints(rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return (25,) whether each joint is tracked; single joints, limbs, both legs, or one side may be occluded."""
    tracked = rng.random(len(JOINTS)) >= rng.choice([0.0, 0.1, 0.4])
    for limb in LIMBS:
        if rng.random() < 0.25:
            tracked[limb] = False

    left_arm, right_arm, left_leg, right_leg = LIMBS
    share = rng.random()
    if share < 0.10:
        tracked[left_leg] = False
        tracked[right_leg] = False
    elif share < 0.25:
        left = int(rng.integers(2)) == 0
        tracked[left_arm if left else right_arm] = False
        tracked[left_leg if left else right_leg] = False
    return np.asarray(tracked)
