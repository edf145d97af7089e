"""The whole training, from a seed to a model; the same seed and settings give the same arrays on the same machine."""

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
from .forests import Growth, draw_probes, grow, grow_yaw, leaf_votes
from .samples import gather
from .scenes import scenes
from .tuning import estimate, mean_posture, regress, remember, thresholds


@dataclass(frozen=True, slots=True)
class Recipe:
    """What to train on.

    Attributes:
        scenes: number of scenes for the forests.
        tuning: number of scenes for thresholds.
        postures: number of scenes, of which no picture is taken, for the posture's regression.
        remembered: number of scenes, of which no picture is taken either, whose postures are remembered.
        pixels: pixels per person and scene.
        probes: number of depth-difference features.
        seed: of everything random.
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
"""A recipe for under a minute on two cores."""


def train(recipe: Recipe, say: Callable[[str], None] = lambda _: None) -> SkeletonModel:
    """Train a model.

    Args:
        recipe: what on.
        say: is told what happens, line by line.
    """
    seed, began = recipe.seed, time.perf_counter()

    def tell(what: str) -> None:
        say(f"{time.perf_counter() - began:6.1f} s  {what}")

    probes = draw_probes(recipe.probes, seed)
    drawn = gather(scenes(recipe.scenes, seed, "train"), probes, recipe.pixels, seed, "train")
    tell(f"{len(drawn.joint)} pixels of {recipe.scenes} scenes")
    yaws, yaw_vote = grow_yaw(drawn, recipe.growth, seed)
    tell(f"{yaws.leaves} leaves for yaws")
    grown = grow(drawn, recipe.growth, seed)
    tell(f"{grown.leaves} leaves for joints")
    said = leaf_votes(drawn, grown)
    info = json.dumps({"version": FORMAT_VERSION, "seed": seed, "recipe": dataclasses.asdict(recipe)})
    model = SkeletonModel(
        probes, grown.feature, grown.threshold, grown.left, grown.right, grown.roots, said.joint,
        said.offset, said.view, said.spread, yaws.feature, yaws.threshold, yaws.left, yaws.right, yaws.roots, yaw_vote,
        np.zeros(len(JOINTS), np.float32), np.zeros((FEATURE_COUNT, 3 * len(JOINTS)), np.float16),
        np.zeros((0, 3 * len(JOINTS)), np.float16), mean_posture(scenes(40, seed, "train")), info,
    )  # fmt: skip
    tell("leaves have their votes")
    model = tuned(model, recipe)
    tell("thresholds and postures")
    return model


def tuned(model: SkeletonModel, recipe: Recipe) -> SkeletonModel:
    """The same forests with thresholds, posture regression and postures from other scenes."""
    seed = recipe.seed
    support = thresholds(estimate(scenes(recipe.tuning, seed, "tune"), model, seed, "tune"))
    mean = model.mean.astype(float)
    posture = regress(scenes(recipe.postures, seed, "posture"), mean, seed)
    memory = remember(scenes(recipe.remembered, seed, "memory"), mean)
    return dataclasses.replace(model, support=support, posture=posture, memory=memory)
