"""Comparison of conditions at group level: difference, interval, sign-flip test and effect sizes of every pair.

The unit is the group: its mean over iterations and steps under each condition. The iterations and events of a group are
not independent of one another.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

import numpy as np

from .paired_intervals import mean_interval, rank_biserial, sign_flip_interval, standardised_difference
from .paired_tests import adjust_p, sign_flip_p, smallest_p
from .study_tables import FACTOR_PREFIX, StudyTables
from .study_values import MEASURES, PairedValues, conditions_with_robot, group_values

TEST = "sign-flip permutation of group differences"

Pair = tuple[str, str]


def compare_conditions(
    tables: StudyTables, conditions: Sequence[str], rng: np.random.Generator, adjustment: str = "holm"
) -> list[dict[str, object]]:
    """Compare every pair of conditions in every measure.

    Sessions without a robot are compared in the dancers' synchrony alone. Where a design has factors, two conditions
    are compared if they differ in the method alone or in one factor alone, and if at least one group danced both.

    Args:
        tables: one study.
        conditions: names of the conditions, in order.
        rng: draws bootstrap samples and sign patterns.
        adjustment: of the probabilities over the pairs of one measure; see `adjust_p`.

    Returns:
        one entry per measure and pair, see `compare_groups`, with ``measure``, ``adjustment`` and ``p_adjusted``.
    """
    rows: list[dict[str, object]] = []
    robotic = conditions_with_robot(tables, conditions)
    for measure in MEASURES:
        names = tuple(conditions) if measure == "gsi_humans" else robotic
        values = group_values(tables, measure, names)
        pairs = [pair for pair in comparable_pairs(tables, names) if len(values.pairs(*pair))]
        compared = [(pair, compare_groups(values, pair, rng)) for pair in pairs]

        # A family of comparisons is all pairs in one measure.
        p = np.array([entry["p"] for _, entry in compared], dtype=np.float64)
        for (pair, entry), adjusted in zip(compared, adjust_p(p, adjustment).tolist(), strict=True):
            named = {"measure": measure, "first": pair[0], "second": pair[1]}
            rows.append({**named, **entry, "p_adjusted": adjusted, "adjustment": adjustment})
    return rows


def compare_groups(values: PairedValues, pair: Pair, rng: np.random.Generator) -> dict[str, object]:
    """Compare two conditions by the differences of the groups, second minus first.

    Args:
        values: a measure by group.
        pair: names of both conditions.
        rng: draws bootstrap samples and sign patterns.

    Returns:
        ``groups`` and ``left_out`` (groups without one of the conditions); the mean ``difference``, its interval
        ``low`` and ``high`` in agreement with the test, and its ``bootstrap`` interval; ``p`` of ``test`` and the
        smallest one that is possible, ``smallest_p``; the effect sizes ``d_z`` and ``rank_biserial`` with intervals.
    """
    pairs = values.pairs(*pair)
    differences = pairs[:, 1] - pairs[:, 0]
    mean = sign_flip_interval(differences, rng)
    # The two intervals differ if the differences are skewed: only the first one agrees with the test.
    bootstrap = mean_interval(differences, rng)
    return {
        "groups": len(differences),
        "left_out": len(values.units) - len(differences),
        "difference": mean.value,
        "low": mean.low,
        "high": mean.high,
        "bootstrap": {"low": bootstrap.low, "high": bootstrap.high},
        "p": float(sign_flip_p(differences, rng)[0]),
        "test": TEST,
        "smallest_p": smallest_p(len(differences)),
        "d_z": standardised_difference(differences).as_dict(),
        "rank_biserial": rank_biserial(differences).as_dict(),
    }


def comparable_pairs(tables: StudyTables, conditions: Iterable[str]) -> list[Pair]:
    """Return the pairs of conditions that differ in one thing: the method, or one factor.

    Args:
        tables: one study.
        conditions: names of the conditions, in order.
    """
    # Two conditions that differ in more than one thing would not tell which of them makes the difference.
    names = list(conditions)
    levels = _levels(tables)
    return [
        (first, second)
        for first, second in combinations(names, 2)
        if sum(a != b for a, b in zip(levels[first], levels[second], strict=True)) == 1
    ]


def _levels(tables: StudyTables) -> Mapping[str, tuple[object, ...]]:
    """Condition -> its method and the levels of its factors."""
    sessions = tables.sessions
    columns = [sessions["method"]]
    columns += [sessions[name] for name in sorted(sessions) if name.startswith(FACTOR_PREFIX)]
    return dict(zip(map(str, sessions["condition"]), zip(*columns, strict=True), strict=True))
