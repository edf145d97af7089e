"""Tests of paired differences: signed ranks of events as in the paper, and sign flips of group differences.

The sign-flip test of group differences is the recommended one. Events of one session share people, robot and music, so
that a test which takes them as independent rejects far too often; the groups are the independent units of a study.
See docs/statistics.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core import Array
from ..core.errors import ConfigError

EXACT_UP_TO = 14
"""Largest number of groups for which all 2^n sign patterns are enumerated."""

RANDOM_FLIPS = 9999
"""Number of random sign patterns for larger numbers of groups."""

ROUNDING = 1e-9
"""Relative tolerance when sums of flipped differences are compared, because floating-point sums of equal value may
differ."""


@dataclass(frozen=True, slots=True)
class SignedRank:
    """Result of a Wilcoxon signed-rank test.

    Attributes:
        z: standardised sum of the ranks of positive differences: negative if the second values are smaller. Without
            continuity correction; NaN if all differences are 0.
        p: two-sided probability under the normal approximation.
        r: effect size z divided by the square root of the number of observations.
        observations: number of observations, two for each pair.
        zeros: pairs without a difference, which have no rank.
        rank_biserial: matched rank-biserial correlation: the ranks of positive minus those of negative differences,
            divided by all of them.
    """

    z: float
    p: float
    r: float
    observations: int
    zeros: int
    rank_biserial: float


def signed_rank(first: Array, second: Array) -> SignedRank:
    """Compute the Wilcoxon signed-rank test of paired values.

    Pairs without a difference are left out of the ranking, the variance is corrected for tied ranks, and there is no
    continuity correction. SciPy returns the negative magnitude of z in a two-sided test; here z has the sign of the
    difference.

    Args:
        first: (N,) finite values under the first condition.
        second: (N,) finite values of the same units under the second condition.

    Source: iqbal2016, section VI-B, for r: z = -4.399 and r = -.18 give 565 to 632 observations, hence two for each
    of the 324 pairs less the missing ones.
    """
    from scipy.stats import norm, rankdata, wilcoxon

    differences = np.asarray(second, dtype=np.float64) - np.asarray(first, dtype=np.float64)
    observations = 2 * len(differences)
    nonzero = differences[differences != 0.0]
    zeros = len(differences) - len(nonzero)
    if len(nonzero) == 0:
        return SignedRank(float("nan"), 1.0, float("nan"), observations, zeros, 0.0)

    # The one-sided call is the one in which SciPy keeps the sign of z.
    result = wilcoxon(differences, zero_method="wilcox", correction=False, alternative="less", method="asymptotic")
    z = float(result.zstatistic)
    ranks = rankdata(np.abs(nonzero))
    biserial = float((np.sign(nonzero) * ranks).sum() / ranks.sum())
    p = float(2.0 * norm.sf(abs(z)))
    return SignedRank(z, p, z / float(np.sqrt(observations)), observations, zeros, biserial)


def sign_patterns(groups: int, rng: np.random.Generator, flips: int = RANDOM_FLIPS) -> tuple[Array, bool]:
    """Return the sign patterns of a sign-flip test, and whether they are all there are.

    Args:
        groups: number of differences, n.
        rng: draws the patterns if there are too many to enumerate.
        flips: number of random patterns.

    Returns:
        (F, n) signs, and True if the patterns are exhaustive up to a change of all signs, which changes no two-sided
        result.
    """
    if groups <= EXACT_UP_TO:
        bits = np.arange(2 ** max(groups - 1, 0))[:, None] >> np.arange(groups) & 1
        return np.asarray(1.0 - 2.0 * bits, dtype=np.float64), True
    return rng.choice(np.array([-1.0, 1.0]), size=(flips, groups)), False


def sign_flip_p(differences: Array, rng: np.random.Generator, flips: int = RANDOM_FLIPS) -> Array:
    """Compute the two-sided probability of the mean difference if the sign of each difference were random.

    If the two methods have the same distribution within every group, each sign is equally likely, whatever the
    distribution of the differences. The test is exact: it rejects at level alpha in at most alpha of the studies. With
    few groups it cannot reject at all, see `smallest_p`.

    Args:
        differences: (S, n) differences of the n groups in each of S studies.
        rng: draws the sign patterns if there are more than 2^14. All S studies use the same ones.
        flips: number of random patterns.

    Returns:
        (S,) probabilities; NaN without groups.

    Raises:
        ConfigError: a difference is not finite.
    """
    values = np.atleast_2d(np.asarray(differences, dtype=np.float64))
    if not np.isfinite(values).all():
        raise ConfigError("differences", "NaN or infinity", "finite values; leave out groups without both conditions")
    if values.shape[1] == 0:
        return np.full(len(values), np.nan)

    signs, exact = sign_patterns(values.shape[1], rng, flips)
    tolerance = ROUNDING * np.abs(values).sum(axis=1)
    observed = np.abs(values.sum(axis=1)) - tolerance
    as_extreme = (np.abs(values @ signs.T) >= observed[:, None]).sum(axis=1)

    # Random patterns do not contain the observed one, which counts as well.
    return np.asarray(as_extreme / len(signs) if exact else (as_extreme + 1) / (len(signs) + 1))


def smallest_p(groups: int) -> float:
    """Return the smallest probability that a sign-flip test of n groups can give: 2 / 2^n, at most 1.

    Five groups cannot be significant at .05, whatever they show; six can.
    """
    return 1.0 if groups < 1 else min(1.0, 2.0 ** (1 - groups))


def adjust_p(p: Array, method: str = "holm") -> Array:
    """Adjust the probabilities of several comparisons.

    Args:
        p: (M,) probabilities; NaN stays NaN and does not count as a comparison.
        method: ``holm`` controls the chance of any false rejection (Holm-Bonferroni), ``benjamini-hochberg`` the
            expected share of false ones among the rejections, ``none`` changes nothing.

    Returns:
        (M,) adjusted probabilities, to be compared with the level itself.

    Raises:
        ConfigError: ``method`` has another value.
    """
    if method not in ("holm", "benjamini-hochberg", "none"):
        raise ConfigError("adjustment", method, "holm, benjamini-hochberg or none")
    adjusted = np.array(p, dtype=np.float64)
    finite = np.isfinite(adjusted)
    if method == "none" or not finite.any():
        return adjusted

    if method == "benjamini-hochberg":
        from scipy.stats import false_discovery_control

        adjusted[finite] = false_discovery_control(adjusted[finite])
        return adjusted

    order = np.argsort(adjusted[finite], kind="stable")
    steps = np.arange(len(order), 0, -1) * adjusted[finite][order]
    holm = np.empty(len(order))
    # A larger probability never gets a smaller adjusted one.
    holm[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    adjusted[finite] = holm
    return adjusted
