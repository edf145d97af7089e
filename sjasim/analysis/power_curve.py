"""Power of the sign-flip test of group differences, from a pool of simulated groups.

Every study takes its groups from the pool without replacement: no group occurs twice in a study, as no group of people
does. Studies share groups with one another. The share of significant ones is then still unbiased, but it is known no
better than the groups of the pool show it, however many studies are drawn from them. The interval therefore counts as
many independent studies as would give the same variance: at least the number of studies without common groups.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..core import Array, IntArray
from ..core.errors import ConfigError
from .paired_tests import sign_flip_p, smallest_p

STUDIES = 2000
"""Number of studies for each number of groups."""

FLIPS = 999
"""Random sign patterns per study where not all can be enumerated; every batch of studies has patterns of its own."""

BATCH = 250
"""Number of studies that are tested with the same random patterns."""

SLOPE_STEP = 0.1
"""Change of the effect from which the slope of the power is computed, in standard deviations of the differences."""

CONFIDENCE = 0.95
"""Probability that an interval should contain the power."""


@dataclass(frozen=True, slots=True)
class PowerPoint:
    """Power at one number of groups.

    Attributes:
        groups: number of groups in the study.
        power: share of studies in which the test rejects.
        low: lower bound of the 95 % interval.
        high: upper bound.
    """

    groups: int
    power: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class GroupsNeeded:
    """Smallest number of groups that reaches a power, with its interval; None where no evaluated number does.

    Attributes:
        value: number at which the estimated power reaches the target and stays there.
        low: the same for the upper bounds of power.
        high: the same for the lower bounds of power.
    """

    value: int | None
    low: int | None
    high: int | None


def power_curve(
    differences: Array,
    sizes: Sequence[int],
    rng: np.random.Generator,
    *,
    effect: float | None = None,
    alpha: float = 0.05,
    studies: int = STUDIES,
) -> list[PowerPoint]:
    """Compute the power of the sign-flip test for several numbers of groups.

    Args:
        differences: (N,) finite differences of the groups in the pool, second method minus first.
        sizes: numbers of groups, each at most N.
        rng: draws the studies and the sign patterns.
        effect: mean difference to detect; the pool is shifted to it and keeps its spread. None for the pool's own.
        alpha: level of the test.
        studies: number of studies for each number of groups, rounded up to whole partitions of the pool.

    Raises:
        ConfigError: the pool is smaller than a study, or its differences are all equal.
    """
    pool = np.asarray(differences, dtype=np.float64)
    if len(pool) < max(sizes):
        raise ConfigError("pool", len(pool), f"at least as many groups as a study, {max(sizes)}")
    if np.ptp(pool) == 0.0:
        raise ConfigError("differences", float(pool[0]), "differences that vary between groups")
    shifted = pool if effect is None else pool - pool.mean() + effect

    curve = []
    for size in sizes:
        if smallest_p(size) > alpha:
            curve.append(PowerPoint(size, 0.0, 0.0, 0.0))
            continue
        drawn = partitions(len(pool), size, rng, studies)
        rejected = _rejections(shifted[drawn], rng, alpha)
        influence = _influence(drawn, rejected, len(pool))
        if effect is not None:
            # The pool's own mean is replaced, so that its error does not count.
            step = SLOPE_STEP * pool.std()
            above = _rejections(shifted[drawn] + step, rng, alpha).mean()
            below = _rejections(shifted[drawn] - step, rng, alpha).mean()
            influence = influence - (above - below) / (2.0 * step) * (pool - pool.mean())
        low, high = wilson_interval(float(rejected.mean()), _equivalent_studies(drawn, rejected, influence))
        curve.append(PowerPoint(size, float(rejected.mean()), low, high))
    return curve


def partitions(pool: int, size: int, rng: np.random.Generator, studies: int) -> IntArray:
    """Draw studies from a pool of groups, by random partitions of the pool.

    Args:
        pool: number of groups in the pool, N.
        size: number of groups in a study, n, at most N.
        rng: draws the partitions.
        studies: smallest number of studies.

    Returns:
        (S, n) groups of each study. Every N // n successive studies, one partition, have no group in common.
    """
    # A partition uses nearly every group once, which spreads the studies evenly over the pool.
    at_once = pool // size
    count = -(-studies // at_once)
    return np.concatenate([rng.permutation(pool)[: at_once * size] for _ in range(count)]).reshape(-1, size)


def wilson_interval(share: float, number: float, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Compute Wilson's interval of a share.

    Args:
        share: the observed share.
        number: number of independent observations, which need not be whole.
        confidence: probability that the interval should contain the share.
    """
    from scipy.stats import norm

    z2 = float(norm.ppf(0.5 + 0.5 * confidence)) ** 2
    center = (share + z2 / (2.0 * number)) / (1.0 + z2 / number)
    half = np.sqrt(z2 * (share * (1.0 - share) / number + z2 / (4.0 * number**2))) / (1.0 + z2 / number)
    return max(float(center - half), 0.0), min(float(center + half), 1.0)


def groups_needed(curve: Sequence[PowerPoint], target: float) -> GroupsNeeded:
    """Return the number of groups from which on the power is at least the target.

    Args:
        curve: power at ascending numbers of groups.
        target: power to reach, such as .8.
    """
    return GroupsNeeded(
        _first_reaching(curve, [point.power for point in curve], target),
        _first_reaching(curve, [point.high for point in curve], target),
        _first_reaching(curve, [point.low for point in curve], target),
    )


def smallest_size(alpha: float) -> int:
    """Return the smallest number of groups with which the sign-flip test can reject at a level."""
    size = 2
    while smallest_p(size) > alpha:
        size += 1
    return size


def _rejections(differences: Array, rng: np.random.Generator, alpha: float) -> Array:
    """(S,) 1 for each of S studies in which the test rejects, else 0."""
    batches = range(0, len(differences), BATCH)
    p = np.concatenate([sign_flip_p(differences[start : start + BATCH], rng, FLIPS) for start in batches])
    return np.asarray(p <= alpha, dtype=np.float64)


def _influence(drawn: IntArray, rejected: Array, pool: int) -> Array:
    """(N,) influence of each group on the power: how much more often the studies that contain it reject, times n."""
    size = drawn.shape[1]
    counts = np.bincount(drawn.ravel(), minlength=pool)
    sums = np.bincount(drawn.ravel(), np.repeat(rejected, size), minlength=pool)
    share = np.divide(sums, counts, out=np.full(pool, rejected.mean()), where=counts > 0)

    # In a finite pool the other groups of a study are a little less often those of high influence.
    return np.asarray(size * (share - rejected.mean()) * pool / max(pool - size, 1))


def _equivalent_studies(drawn: IntArray, rejected: Array, influence: Array) -> float:
    """Number of independent studies whose share of rejections would have the variance of this one.

    The variance follows from the variation of the influence between groups (the infinitesimal jackknife), less what
    the finite number of drawn studies adds to it.
    """
    studies = len(drawn)
    size = int(drawn.shape[1])
    pool = len(influence)
    apart = pool / size
    share = float(rejected.mean())
    binomial = share * (1.0 - share)
    if binomial == 0.0:
        return apart

    inclusions = studies / apart
    noise = size**2 * binomial / inclusions * (pool / max(pool - size, 1)) ** 2
    between = max(float(np.mean(influence**2)) - noise, 0.0) / pool
    return min(max(binomial / (between + binomial / studies), apart), float(studies))


def _first_reaching(curve: Sequence[PowerPoint], values: Sequence[float], target: float) -> int | None:
    """Smallest number of groups from which on all values reach the target."""
    # From the largest number downwards: with few groups the power does not rise at every step.
    needed = None
    for point, value in zip(reversed(curve), reversed(values), strict=True):
        if value < target:
            break
        needed = point.groups
    return needed
