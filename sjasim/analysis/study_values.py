"""Values of a measure arranged for comparison: one row for each unit, one column for each condition.

A unit is a group, an iteration of a group, or a step of an iteration of a group. Every unit is observed under several
conditions, and the columns of a row are therefore paired.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..config import HUMANS_ONLY
from ..core import Array, BoolArray, IntArray
from ..core.errors import ConfigError
from .study_tables import Columns, StudyTables

Column = NDArray[np.generic]
"""Values of a column of a table, of any type."""

MEASURES: Mapping[str, str] = {
    "gsi": "group synchronisation index under the paper's edges",
    "gsi_full_edges": "group synchronisation index under all edges",
    "gsi_humans": "group synchronisation index of the dancers alone",
    "ta_mean_s": "mean timing appropriateness of the robot [s]",
}
"""Measures of sessions and iterations that are compared, and their meaning."""


@dataclass(frozen=True, slots=True)
class PairedValues:
    """Values of a measure, paired between conditions.

    Attributes:
        conditions: names of the C conditions.
        units: (R, K) identifiers of the units, in ascending order: study and group, then iteration, then step.
        values: (R, C) values; NaN where a unit has none under a condition. Several observations of a unit under one
            condition are averaged.
    """

    conditions: tuple[str, ...]
    units: IntArray
    values: Array

    def column(self, condition: str) -> Array:
        """Return the (R,) values under one condition."""
        return np.asarray(self.values[:, self.conditions.index(condition)])

    def pairs(self, first: str, second: str) -> Array:
        """Return the (P, 2) values of the units that have one under both conditions."""
        both = np.column_stack([self.column(first), self.column(second)])
        return np.asarray(both[np.isfinite(both).all(axis=1)])


def condition_names(tables: StudyTables, order: Sequence[str] = ()) -> tuple[str, ...]:
    """Return the names of the conditions of a study.

    Args:
        tables: the study.
        order: names that come first, in this order. The others follow in the order of their first session.

    Raises:
        ConfigError: the study has no session of a named condition.
    """
    present = list(dict.fromkeys(str(name) for name in tables.sessions["condition"]))
    unknown = [name for name in order if name not in present]
    if unknown:
        raise ConfigError("conditions", unknown, f"conditions of the study: {', '.join(present)}")
    return (*order, *(name for name in present if name not in order))


def conditions_with_robot(tables: StudyTables, names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of those conditions whose sessions have a robot, in the same order."""
    method_of = dict(zip(map(str, tables.sessions["condition"]), map(str, tables.sessions["method"]), strict=True))
    return tuple(name for name in names if method_of[name] != HUMANS_ONLY)


def select_sessions(tables: StudyTables, wanted: BoolArray) -> StudyTables:
    """Return the tables of some of the sessions.

    Args:
        tables: the study.
        wanted: (S,) which rows of the table ``sessions`` are kept.
    """
    numbers = tables.sessions["session"][wanted]
    return StudyTables(
        sessions=_rows(tables.sessions, wanted),
        iterations=_rows(tables.iterations, np.isin(tables.iterations["session"], numbers)),
        steps=_rows(tables.steps, np.isin(tables.steps["session"], numbers)),
        events=_rows(tables.events, np.isin(tables.events["session"], numbers)),
    )


def group_values(tables: StudyTables, measure: str, conditions: Sequence[str]) -> PairedValues:
    """Return a measure of every group: the mean over its iterations, as in the table ``sessions``.

    Args:
        tables: the study; groups of several replications are different groups.
        measure: one of `MEASURES`.
        conditions: names of the columns.
    """
    sessions = tables.sessions
    units = np.column_stack([sessions["study"], sessions["group"]])
    return _paired(units, sessions["condition"], sessions[measure], conditions)


def iteration_values(tables: StudyTables, measure: str, conditions: Sequence[str]) -> PairedValues:
    """Return a measure of every iteration of every group; arguments as in `group_values`."""
    rows = _session_rows(tables, tables.iterations)
    units = np.column_stack(
        [tables.sessions["study"][rows], tables.sessions["group"][rows], tables.iterations["iteration"]]
    )
    return _paired(units, tables.sessions["condition"][rows], tables.iterations[measure], conditions)


def step_values(tables: StudyTables, conditions: Sequence[str]) -> PairedValues:
    """Return the timing appropriateness [s] of every step of every iteration of every group.

    Args:
        tables: the study.
        conditions: names of the columns; sessions without a robot have no values.
    """
    rows = _session_rows(tables, tables.steps)
    units = np.column_stack(
        [
            tables.sessions["study"][rows],
            tables.sessions["group"][rows],
            tables.steps["iteration"],
            tables.steps["ordinal"],
        ]
    )
    return _paired(units, tables.sessions["condition"][rows], tables.steps["ta_s"], conditions)


def _session_rows(tables: StudyTables, table: Columns) -> IntArray:
    """(N,) row of the table ``sessions`` that each row of another table belongs to."""
    numbers = np.asarray(tables.sessions["session"], dtype=np.int64)
    order = np.argsort(numbers, kind="stable")
    return np.asarray(order[np.searchsorted(numbers[order], table["session"])], dtype=np.int64)


def _rows(table: Columns, wanted: BoolArray) -> Columns:
    """The same columns with some of the rows."""
    return {name: values[wanted] for name, values in table.items()}


def _paired(units: Column, names: Column, values: Column, conditions: Sequence[str]) -> PairedValues:
    """Arrange (N,) values by unit and condition; rows of other conditions are left out."""
    code_of = {name: code for code, name in enumerate(conditions)}
    codes = np.array([code_of.get(str(name), -1) for name in names], dtype=np.int64)
    known = codes >= 0
    keys, row = np.unique(units[known].astype(np.int64), axis=0, return_inverse=True)

    # Observations that are NaN count as missing, so that a mean is one of those that exist.
    observed = np.asarray(values, dtype=np.float64)[known]
    finite = np.isfinite(observed)
    cell = (row.reshape(-1) * len(conditions) + codes[known])[finite]
    size = len(keys) * len(conditions)
    counts = np.bincount(cell, minlength=size)
    sums = np.bincount(cell, observed[finite], minlength=size)

    means = np.divide(sums, counts, out=np.full(size, np.nan), where=counts > 0)
    return PairedValues(tuple(conditions), keys, means.reshape(len(keys), len(conditions)))
