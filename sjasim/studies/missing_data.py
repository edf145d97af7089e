"""Rules for steps that a robot missed and for sessions that failed, applied before a study is analysed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..analysis.study_tables import FACTOR_PREFIX, Columns, StudyTables

MISSED_SHARE = 0.5
"""Share of missed steps above which ``drop-group`` leaves out the group of a session (assumed)."""


@dataclass(frozen=True, slots=True)
class Exclusions:
    """What a rule left out.

    Attributes:
        failed_groups: number of groups with a session that failed.
        incomplete_groups: number of groups with a session that lacks too many steps.
        steps: number of steps that are left out because another session of the group lacks them.
    """

    failed_groups: int = 0
    incomplete_groups: int = 0
    steps: int = 0

    def __add__(self, other: Exclusions) -> Exclusions:
        return Exclusions(
            self.failed_groups + other.failed_groups,
            self.incomplete_groups + other.incomplete_groups,
            self.steps + other.steps,
        )

    def notices(self) -> list[str]:
        """What was left out, in words; empty if nothing was."""
        texts = (
            (self.failed_groups, "group(s) left out of the analysis because a session failed"),
            (self.incomplete_groups, "group(s) left out of the analysis: a robot missed more than half of its steps"),
            (self.steps, "step(s) left out of the analysis because the robot missed them in another session"),
        )
        return [f"{count} {text}" for count, text in texts if count]


def with_rule(tables: StudyTables, rule: str) -> tuple[StudyTables, Exclusions]:
    """Apply a rule for missing data to the tables of whole groups.

    The group of a session that failed is always left out, because its methods cannot be compared. Under ``drop-step``
    timing appropriateness and latency are compared on the same steps; the synchrony indices count a missed step as an
    event without a partner under every rule.

    Args:
        tables: tables of whole groups.
        rule: ``keep``, ``drop-step`` or ``drop-group``; see `StudyDesign`.

    Returns:
        the tables for the analysis, and what was left out.
    """
    groups = _group_numbers(tables.sessions)
    failed = np.unique(groups[np.isnan(_floats(tables.sessions["gsi"]))])
    incomplete = _incomplete_groups(tables, groups) if rule == "drop-group" else np.empty(0, dtype=np.int64)
    incomplete = np.setdiff1d(incomplete, failed)

    kept = _without_groups(tables, groups, np.union1d(failed, incomplete))
    steps = 0
    if rule == "drop-step":
        kept, steps = _without_missed_steps(kept)
    return kept, Exclusions(len(failed), len(incomplete), steps)


def _group_numbers(sessions: Columns) -> NDArray[np.int64]:
    """(N,) number of each session's group over all replications."""
    pairs = np.stack([sessions["study"], sessions["group"]], axis=1)
    _, numbers = np.unique(pairs, axis=0, return_inverse=True)
    return np.asarray(numbers, dtype=np.int64).reshape(-1)


def _incomplete_groups(tables: StudyTables, groups: NDArray[np.int64]) -> NDArray[np.int64]:
    """Groups with a session whose robot missed more than `MISSED_SHARE` of its steps."""
    index = np.searchsorted(tables.sessions["session"], tables.steps["session"])
    count = np.bincount(index, minlength=len(groups))
    missed = np.bincount(index[np.isnan(_floats(tables.steps["ta_s"]))], minlength=len(groups))
    return np.unique(groups[missed > MISSED_SHARE * count])


def _without_groups(tables: StudyTables, groups: NDArray[np.int64], dropped: NDArray[np.int64]) -> StudyTables:
    """The tables without the sessions of some groups."""
    if len(dropped) == 0:
        return tables
    kept = tables.sessions["session"][~np.isin(groups, dropped)]
    return StudyTables(*(_rows(columns, np.isin(columns["session"], kept)) for columns in _all(tables)))


def _without_missed_steps(tables: StudyTables) -> tuple[StudyTables, int]:
    """The tables without steps that another session of the group lacks, and the number of those."""
    steps = dict(tables.steps)
    sessions = tables.sessions
    row = np.searchsorted(sessions["session"], steps["session"])

    # The same step of a group: iteration and ordinal, in one dance.
    dance = sessions.get(FACTOR_PREFIX + "dance.name", np.zeros(len(sessions["session"])))
    _, dance_number = np.unique(dance, return_inverse=True)
    keys = (_group_numbers(sessions)[row], dance_number[row], steps["iteration"], steps["ordinal"])
    _, step = np.unique(np.stack(keys, axis=1), axis=0, return_inverse=True)
    step = np.asarray(step).reshape(-1)

    missed = np.isnan(_floats(steps["ta_s"]))
    lacking = np.isin(step, step[missed])
    for name in ("ta_s", "latency_s"):
        steps[name] = np.where(lacking, np.nan, _floats(steps[name]))

    changed = StudyTables(
        {**sessions, "ta_mean_s": _means_by(("session",), sessions, steps)},
        {**tables.iterations, "ta_mean_s": _means_by(("session", "iteration"), tables.iterations, steps)},
        steps,
        tables.events,
    )
    return changed, int((lacking & ~missed).sum())


def _means_by(keys: Sequence[str], rows: Columns, steps: Columns) -> NDArray[np.float64]:
    """(N,) mean timing appropriateness of the steps that share the keys of each row [s]; NaN without steps."""
    both = np.concatenate([np.stack([table[key] for key in keys], axis=1) for table in (rows, steps)])
    _, numbers = np.unique(both, axis=0, return_inverse=True)
    row, step = np.split(np.asarray(numbers).reshape(-1), [len(rows["session"])])

    ta_s = _floats(steps["ta_s"])
    finite = np.isfinite(ta_s)
    size = int(numbers.max(initial=-1)) + 1
    total = np.bincount(step[finite], weights=ta_s[finite], minlength=size)
    count = np.bincount(step[finite], minlength=size)
    with np.errstate(invalid="ignore"):
        return np.asarray((total / count)[row])


def _rows(columns: Columns, chosen: NDArray[np.bool_]) -> dict[str, NDArray[np.generic]]:
    return {name: values[chosen] for name, values in columns.items()}


def _all(tables: StudyTables) -> tuple[Columns, ...]:
    return tables.sessions, tables.iterations, tables.steps, tables.events


def _floats(values: NDArray[np.generic]) -> NDArray[np.float64]:
    return np.asarray(values, dtype=np.float64)
