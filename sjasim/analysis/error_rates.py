"""Share of simulated studies in which a test rejects: its type I error without a difference, else its power.

The tests compared are those that a study could report. They differ in the unit that they take as independent: the
group, the iteration of a group, or the event.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ..core import Array
from .paired_tests import sign_flip_p, signed_rank
from .power_curve import wilson_interval

RECOMMENDED = "groups: sign flips"
"""Test that study_summary reports under ``comparisons``."""


def rejection_shares(values: Array, rng: np.random.Generator, alpha: float = 0.05) -> dict[str, dict[str, float]]:
    """Compute the share of studies in which each test rejects.

    Args:
        values: (S, G, 2, I, K) value of S studies, G groups, two methods, I iterations and K steps; NaN for a missing
            step. A measure of iterations has K = 1.
        rng: draws sign patterns.
        alpha: level of the tests.

    Returns:
        test -> ``share``, and its 95 % interval ``low`` and ``high``.
    """
    shares: dict[str, dict[str, float]] = {}
    for name, test in TESTS.items():
        share = float(np.mean(test(values, rng) <= alpha))
        low, high = wilson_interval(share, len(values))
        shares[name] = {"share": share, "low": low, "high": high}
    return shares


def _group_differences(values: Array) -> Array:
    """(S, G) differences of the group means over finite values, second method minus first."""
    # One value per group and method: what happens within a session does not count as evidence of its own.
    means = np.nanmean(values, axis=(3, 4))
    return np.asarray(means[:, :, 1] - means[:, :, 0])


def _sign_flips(values: Array, rng: np.random.Generator) -> Array:
    return sign_flip_p(_group_differences(values), rng)


def _t_test(values: Array, _: np.random.Generator) -> Array:
    from scipy.stats import ttest_1samp

    return np.asarray(ttest_1samp(_group_differences(values), 0.0, axis=1).pvalue)


def _group_ranks(values: Array, _: np.random.Generator) -> Array:
    from scipy.stats import wilcoxon

    return np.asarray(wilcoxon(_group_differences(values), axis=1, method="exact").pvalue)


def _iteration_ranks(values: Array, _: np.random.Generator) -> Array:
    return _pooled_ranks(np.nanmean(values, axis=4, keepdims=True))


def _event_ranks(values: Array, _: np.random.Generator) -> Array:
    return _pooled_ranks(values)


def _pooled_ranks(values: Array) -> Array:
    """(S,) probability of the signed-rank test that takes all values of a study as independent."""
    found = []
    for study in values:
        # (groups, iterations, steps, 2): pairs of the same group, iteration and step.
        pairs = np.moveaxis(study, 1, -1).reshape(-1, 2)
        pairs = pairs[np.isfinite(pairs).all(axis=1)]
        found.append(signed_rank(pairs[:, 0], pairs[:, 1]).p)
    return np.array(found)


TESTS: Mapping[str, Callable[[Array, np.random.Generator], Array]] = {
    RECOMMENDED: _sign_flips,
    "groups: t test": _t_test,
    "groups: signed ranks": _group_ranks,
    "iterations: signed ranks": _iteration_ranks,
    "events: signed ranks": _event_ranks,
}
"""Test -> probability of each study."""
