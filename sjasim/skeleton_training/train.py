"""Training of the skeleton model from a seed; the same seed and recipe give the same model on the same machine."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..assets.names import JOINTS
from ..sensors.skeleton.posture_prior import FEATURE_COUNT
from ..sensors.skeleton.trained_model import FORMAT_VERSION, SkeletonModel
from .forests import Growth, draw_probes, grow_joint_forest, grow_yaw_forest, leaf_votes
from .samples import draw_samples
from .scenes import random_scenes
from .tuning import estimate_joints, fit_posture_regression, mean_posture, reference_postures, support_thresholds


@dataclass(frozen=True, slots=True)
class Recipe:
    """Amount of training data, and size of the forests.

    Attributes:
        scenes: number of scenes for the forests.
        tuning: number of scenes for the thresholds.
        postures: number of scenes for the regression of postures; no depth images are made of them.
        remembered: number of scenes for the reference postures; no depth images are made of them.
        pixels: number of pixels per person and scene.
        probes: number of depth-difference features.
        seed: seed of everything random.
        growth: size of the forests.
    """

    scenes: int = 1400
    tuning: int = 250
    postures: int = 1500
    remembered: int = 120
    pixels: int = 110
    probes: int = 200
    seed: int = 0
    growth: Growth = field(default_factory=Growth)


SMALL = Recipe(scenes=260, tuning=80, postures=1000, growth=Growth(leaves=2000, yaw_leaves=600))
"""A recipe that takes less than a minute on two cores."""

MEAN_POSTURE_SCENES = 40
"""Number of scenes from which the mean posture is taken."""


def train(recipe: Recipe, on_progress: Callable[[str], None] = lambda _: None) -> SkeletonModel:
    """Train a model.

    Args:
        recipe: amount of data and size of the forests.
        on_progress: called with a line after each part of the training.
    """
    seed = recipe.seed
    started_s = time.perf_counter()

    def report(text: str) -> None:
        on_progress(f"{time.perf_counter() - started_s:6.1f} s  {text}")

    probes = draw_probes(recipe.probes, seed)
    samples = draw_samples(random_scenes(recipe.scenes, seed, "train"), probes, recipe.pixels, seed, "train")
    report(f"{len(samples.joint)} pixels of {recipe.scenes} scenes")

    yaw_forest, yaw_vote = grow_yaw_forest(samples, recipe.growth, seed)
    report(f"{yaw_forest.leaves} leaves of the yaw forest")
    forest = grow_joint_forest(samples, recipe.growth, seed)
    report(f"{forest.leaves} leaves of the joint forest")

    votes = leaf_votes(samples, forest)
    report("votes of the leaves")

    # Thresholds, regression and postures are filled in by `tuned`, which needs the forests.
    mean = mean_posture(random_scenes(MEAN_POSTURE_SCENES, seed, "train"))
    info = json.dumps({"version": FORMAT_VERSION, "seed": seed, "recipe": dataclasses.asdict(recipe)})
    model = SkeletonModel(
        probes, forest.feature, forest.threshold, forest.left, forest.right, forest.roots, votes.joint, votes.offset,
        votes.view, votes.spread, yaw_forest.feature, yaw_forest.threshold, yaw_forest.left, yaw_forest.right,
        yaw_forest.roots, yaw_vote, np.zeros(len(JOINTS), np.float32),
        np.zeros((FEATURE_COUNT, 3 * len(JOINTS)), np.float16), np.zeros((0, 3 * len(JOINTS)), np.float16), mean, info,
    )  # fmt: skip
    model = tuned(model, recipe)
    report("thresholds and postures")
    return model


def tuned(model: SkeletonModel, recipe: Recipe) -> SkeletonModel:
    """Return a model with thresholds, regression and reference postures from scenes other than the training's."""
    seed = recipe.seed
    estimates = estimate_joints(random_scenes(recipe.tuning, seed, "tune"), model, seed, "tune")
    support = support_thresholds(estimates)
    mean = model.mean.astype(float)
    posture = fit_posture_regression(random_scenes(recipe.postures, seed, "posture"), mean, seed)
    memory = reference_postures(random_scenes(recipe.remembered, seed, "memory"), mean)
    return dataclasses.replace(model, support=support, posture=posture, memory=memory)
