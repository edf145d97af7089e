"""Synchrony of each group in each iteration under each method, as in the paper's Table I, and which method wins.

Source: iqbal2016, section VI-A and Table I.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from ..core import Array
from .study_values import PairedValues

DECIMALS = 2
"""Decimals of the paper's Table I. Iterations are compared as printed, so that equal entries are a tie."""

EQUAL_MEANS = 1e-9
"""Group means that differ by at most this are a tie; the paper compares the means before rounding."""


def table_rows(iterations: PairedValues, groups: PairedValues) -> list[dict[str, object]]:
    """Return one entry per group: its index in each iteration, its mean, and the best conditions of both.

    Args:
        iterations: index of one study by group and iteration.
        groups: index of the same study by group.

    Returns:
        per group ``group``, ``iterations`` (``iteration``, ``gsi`` of each condition, ``best``), ``mean`` of each
        condition and ``best``. ``best`` lists the conditions with the highest value: several in a tie, none without
        values.
    """
    rows: list[dict[str, object]] = []
    for unit, means in zip(groups.units, groups.values, strict=True):
        # A group is identified by its study and its number.
        own = (iterations.units[:, :2] == unit).all(axis=1)
        entries = [
            {
                "iteration": int(number),
                "gsi": _by_name(iterations.conditions, values),
                "best": _best(iterations.conditions, np.round(values, DECIMALS)),
            }
            for number, values in zip(iterations.units[own, 2], iterations.values[own], strict=True)
        ]
        mean = _by_name(groups.conditions, means)
        best = _best(groups.conditions, means)
        rows.append({"group": int(unit[1]), "iterations": entries, "mean": mean, "best": best})
    return rows


def win_counts(iterations: PairedValues, groups: PairedValues) -> dict[str, object] | None:
    """Count how often one condition has the higher index, for every pair of conditions.

    Iterations are compared after rounding to two decimals, as the paper prints them; equal values are ties, and count
    for neither. Group means are compared before rounding. Units without a value under both conditions are left out.

    Args:
        iterations: index by group and iteration.
        groups: index by group.

    Returns:
        None with fewer than two conditions. Otherwise ``pairs`` with an entry per pair (``first``, ``second``, and for
        ``iterations`` and ``groups`` the numbers ``first``, ``second``, ``ties``, ``n``), and, for the first pair,
        ``pair``, and ``iterations`` and ``groups`` as [wins of its second condition, number].
    """
    pairs = [
        {
            "first": first,
            "second": second,
            "iterations": _count(np.round(iterations.pairs(first, second), DECIMALS)),
            "groups": _count(groups.pairs(first, second)),
        }
        for first, second in combinations(iterations.conditions, 2)
    ]
    if not pairs:
        return None

    # The form in which the paper reports: 22 of 36 iterations, 7 of 9 groups.
    leading: dict[str, object] = {"pair": [pairs[0]["first"], pairs[0]["second"]]}
    for level in ("iterations", "groups"):
        counts = pairs[0][level]
        assert isinstance(counts, dict)
        leading[level] = [counts["second"], counts["n"]]
    return {**leading, "pairs": pairs}


def _count(pairs: Array) -> dict[str, int]:
    """Numbers of (P, 2) pairs in which the first or the second value is higher, and of ties."""
    difference = pairs[:, 1] - pairs[:, 0]
    second = int((difference > EQUAL_MEANS).sum())
    first = int((difference < -EQUAL_MEANS).sum())
    return {"first": first, "second": second, "ties": len(pairs) - first - second, "n": len(pairs)}


def _by_name(conditions: tuple[str, ...], values: Array) -> dict[str, float]:
    return dict(zip(conditions, values.tolist(), strict=True))


def _best(conditions: tuple[str, ...], values: Array) -> list[str]:
    """Conditions whose value is the highest of the (C,) values."""
    if not np.isfinite(values).any():
        return []
    highest = np.nanmax(values)
    return [name for name, value in zip(conditions, values, strict=True) if value >= highest - EQUAL_MEANS]
