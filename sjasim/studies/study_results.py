"""Results of a complete study: the content of study.json."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..analysis.study_tables import Columns
from ..core.errors import RecordError
from .dataset import StudyReader, concatenated, table_file
from .design_file import design_to_plain
from .missing_data import Exclusions, with_rule
from .study_design import StudyPlan
from .study_folder import STUDY_FILE
from .study_parts import Failure
from .table_format import TABLES

SCHEMA = 1
"""Version of the keys of study.json."""

MEASURES = ("gsi", "gsi_full_edges", "gsi_humans", "ta_mean_s", "robot_missed")
"""Columns of the table of sessions that are summarised for each condition."""

CONFIDENCE = 0.95

MOST_FAILURES = 100
"""Failed sessions that study.json names; it counts all."""

MOST_GROUPS = 300
"""Groups of a replication for which `study_summary` is computed: resampling more of them needs too much memory."""

MOST_SESSIONS = 20_000
"""Sessions for which the figures of `study_summary` are computed, in whole replications."""

MOST_CONDITIONS = 12
"""Conditions up to which `study_summary` is computed: it compares every pair."""


def study_results(folder: Path, plan: StudyPlan, failures: Sequence[Failure]) -> dict[str, Any]:
    """Analyse a complete data set.

    Means by condition are computed over all sessions, block by block. Tests, intervals and chance levels are those of
    `analysis.study_summary`, over as many groups as fit in memory; a notice says so if there are more.

    Args:
        folder: folder of the study.
        plan: all its sessions.
        failures: sessions that failed.

    Returns:
        The content of study.json without ``versions`` and ``cost``.
    """
    reader = StudyReader(folder, complete=False)
    statistics = ConditionStatistics(plan)
    left_out = Exclusions()
    for block in reader.blocks(events=False):
        tables, exclusions = with_rule(block, plan.design.missing)
        statistics.add(tables.sessions)
        left_out += exclusions

    summary = _summary(reader, plan)
    return {
        "schema": SCHEMA,
        "design": design_to_plain(plan.design),
        "tables": {table: table_file(table) for table in TABLES},
        "session_count": len(plan),
        "by_condition": statistics.rows(),
        **summary,
        "failures": {"count": len(failures), "first": [failure.what for failure in failures[:MOST_FAILURES]]},
        "notices": [*left_out.notices(), *summary["notices"]],
    }


def _summary(reader: StudyReader, plan: StudyPlan) -> dict[str, Any]:
    """Figures of `analysis.study_summary`, and notices about what they do not cover."""
    from ..analysis.study_summary import study_summary

    names = list(plan.named_conditions())
    if len(names) > MOST_CONDITIONS:
        text = f"{len(names)} conditions are too many to compare every pair: by_condition has their means and intervals"
        return {"conditions": names, "notices": [text]}

    sample, notices = _summarised_sessions(plan)
    parts = [reader.sessions(first, last, events=plan.design.events) for first, last in sample]
    tables, _ = with_rule(concatenated(parts), plan.design.missing)
    if len(tables.sessions["session"]) == 0:
        return {"conditions": names, "notices": [*notices, "no group is complete, so there is nothing to compare"]}

    tau_s = plan.design.session.synchrony.tau_s
    summary: dict[str, Any] = study_summary(tables, names, seed=plan.design.seed, tau_s=tau_s)
    return {**summary, "notices": [*notices, *summary["notices"]]}


def _summarised_sessions(plan: StudyPlan) -> tuple[list[tuple[int, int]], list[str]]:
    """Ranges of the sessions that are summarised, and notices if these are not all sessions."""
    design = plan.design
    size = plan.sessions_per_group
    if plan.groups > MOST_GROUPS:
        chosen = max(2, MOST_GROUPS // len(plan.cells))
        if chosen < design.groups:
            starts = [cell * design.groups * size for cell in range(len(plan.cells))]
            ranges = [(start, start + chosen * size) for start in starts]
            return ranges, [f"tests, intervals and chance levels are those of {chosen} of {design.groups} groups"]

    replications = max(1, MOST_SESSIONS // (plan.groups * size))
    notices = []
    if replications < design.replications:
        notices.append(f"replications: the figures are those of {replications} of {design.replications}")
    return [(0, min(replications * plan.groups * size, len(plan)))], notices


class ConditionStatistics:
    """Mean, standard deviation and interval of the measures of each condition, over any number of sessions.

    The sessions of one condition belong to different groups, so that the interval of Student's t holds.

    Args:
        plan: all sessions of the study.
    """

    def __init__(self, plan: StudyPlan) -> None:
        self._conditions = plan.named_conditions()
        # Count, sum and sum of squares of each measure.
        self._sums = {name: np.zeros((len(MEASURES), 3)) for name in self._conditions}

    def add(self, sessions: Columns) -> None:
        """Add rows of the table of sessions."""
        condition = sessions["condition"]
        for name, sums in self._sums.items():
            chosen = condition == name
            for row, measure in enumerate(MEASURES):
                values = np.asarray(sessions[measure], dtype=np.float64)[chosen]
                finite = values[np.isfinite(values)]
                sums[row] += (len(finite), finite.sum(), (finite**2).sum())

    def rows(self) -> list[dict[str, Any]]:
        """One row for each condition: ``sessions``, and each measure as mean, s.d., interval and count."""
        rows = []
        for name, condition in self._conditions.items():
            sums = self._sums[name]
            about = {"condition": name, "method": condition.method, "factors": dict(condition.levels)}
            row: dict[str, Any] = {**about, "sessions": int(sums[0, 0])}
            row |= {measure: _mean_and_interval(*sums[index]) for index, measure in enumerate(MEASURES)}
            rows.append(row)
        return rows


def _mean_and_interval(count: float, total: float, squares: float) -> dict[str, float | int | None]:
    """Mean, s.d. and 95 % interval of the mean from count, sum and sum of squares; null where they do not exist."""
    from scipy.special import stdtrit

    if count == 0:
        return {"mean": None, "sd": None, "low": None, "high": None, "n": 0}
    mean = total / count
    if count == 1:
        return {"mean": mean, "sd": None, "low": None, "high": None, "n": 1}

    sd = math.sqrt(max(squares - count * mean**2, 0.0) / (count - 1))
    half = float(stdtrit(count - 1, 0.5 + CONFIDENCE / 2)) * sd / math.sqrt(count)
    return {"mean": mean, "sd": sd, "low": mean - half, "high": mean + half, "n": int(count)}


def results_as_json(results: Mapping[str, Any]) -> str:
    """The results as JSON text."""
    return json.dumps(results, indent=1, allow_nan=False) + "\n"


def read_results(folder: str | Path) -> dict[str, Any]:
    """Read study.json of a complete study.

    Raises:
        RecordError: the file is missing or damaged.
    """
    path = Path(folder).expanduser() / STUDY_FILE
    try:
        results: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise RecordError(f"{path} is missing: this is no complete study") from None
    except (OSError, ValueError) as error:
        raise RecordError(f"{path} cannot be read: {error}") from None
    return results
