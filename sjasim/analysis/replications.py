"""Variation of a study's figures between replications of the whole study."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core import Array, BoolArray
from .paired_tests import signed_rank
from .study_tables import StudyTables
from .study_values import PairedValues, group_values, iteration_values, step_values
from .synchrony_table import DECIMALS, EQUAL_MEANS

TAIL = 0.025
"""Share of the replications below the lower and above the upper bound."""


def replication_figures(tables: StudyTables, conditions: Sequence[str]) -> dict[str, object]:
    """Summarise each study's figures over all studies: mean, and the bounds of the middle 95 %.

    Args:
        tables: several studies of one design.
        conditions: names of the conditions with a robot.

    Returns:
        ``gsi`` and ``ta_mean_s`` of each condition: mean over iterations and over steps. With two conditions or more,
        for the first two: ``wins_iterations`` and ``wins_groups`` of the second one, and ``z`` of the signed ranks of
        steps. Each with ``mean``, ``low``, ``high`` and the number of ``studies``.
    """
    iterations = iteration_values(tables, "gsi", conditions)
    groups = group_values(tables, "gsi", conditions)
    steps = step_values(tables, conditions)
    figures: dict[str, object] = {
        "gsi": {name: _spread(_by_study(iterations, name)) for name in conditions},
        "ta_mean_s": {name: _spread(_by_study(steps, name)) for name in conditions},
    }
    if len(conditions) < 2:
        return figures

    # Iterations count as in the paper's table: rounded before they are compared.
    rounded = PairedValues(iterations.conditions, iterations.units, np.round(iterations.values, DECIMALS))
    figures["wins_iterations"] = _spread(_wins(rounded))
    figures["wins_groups"] = _spread(_wins(groups))
    figures["z"] = _spread(_z(steps))
    return figures


def _spread(values: Array) -> dict[str, float]:
    """Mean of (S,) values, NaN left out, and the bounds of their middle 95 %."""
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return {"mean": float("nan"), "low": float("nan"), "high": float("nan"), "studies": 0}
    low, high = np.quantile(finite, (TAIL, 1.0 - TAIL))
    return {"mean": float(finite.mean()), "low": float(low), "high": float(high), "studies": len(finite)}


def _by_study(values: PairedValues, condition: str) -> Array:
    """Mean of the finite values of each study; NaN without any."""
    column = values.column(condition)
    finite = np.isfinite(column)
    _, study = np.unique(values.units[:, 0], return_inverse=True)
    size = int(study.max()) + 1 if len(study) else 0
    counts = np.bincount(study[finite], minlength=size)
    sums = np.bincount(study[finite], column[finite], minlength=size)
    return np.asarray(np.divide(sums, counts, out=np.full(size, np.nan), where=counts > 0))


def _wins(values: PairedValues) -> Array:
    """Number of units of each study in which the second condition has the higher value."""
    difference = values.values[:, 1] - values.values[:, 0]
    _, study = np.unique(values.units[:, 0], return_inverse=True)
    return np.asarray(np.bincount(study, np.where(difference > EQUAL_MEANS, 1.0, 0.0)), dtype=np.float64)


def _z(steps: PairedValues) -> Array:
    """Statistic z of the signed ranks of each study's steps, second condition minus first."""
    both = np.isfinite(steps.values[:, :2]).all(axis=1)
    study = steps.units[:, 0]

    def of(wanted: BoolArray) -> float:
        pairs = steps.values[wanted & both]
        return signed_rank(pairs[:, 0], pairs[:, 1]).z if len(pairs) else float("nan")

    return np.array([of(np.asarray(study == number)) for number in np.unique(study)])
