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
from .dataset import StudyReader, table_file
from .design_file import design_to_plain
from .missing_data import Exclusions, with_rule
from .study_design import StudyPlan
from .study_folder import STUDY_FILE
from .study_parts import Failure

SCHEMA = 1
"""Version of the keys of study.json."""

MEASURES = ("gsi", "gsi_full_edges", "gsi_humans", "ta_mean_s", "robot_missed")
"""Columns of the table of sessions that are summarised for each condition."""

CONFIDENCE = 0.95

MOST_FAILURES = 100
"""Failed sessions that study.json names; it counts all."""


def study_results(folder: Path, plan: StudyPlan, failures: Sequence[Failure]) -> dict[str, Any]:
    """Analyse a complete data set, block by block.

    Args:
        folder: folder of the study.
        plan: all its sessions.
        failures: sessions that failed.

    Returns:
        The content of study.json without ``versions`` and ``cost``.
    """
    statistics = ConditionStatistics(plan)
    left_out = Exclusions()
    for block in StudyReader(folder, complete=False).blocks(events=False):
        tables, exclusions = with_rule(block, plan.design.missing)
        statistics.add(tables.sessions)
        left_out += exclusions

    return {
        "schema": SCHEMA,
        "design": design_to_plain(plan.design),
        "sessions": table_file("sessions"),
        "session_count": len(plan),
        "conditions": statistics.rows(),
        "failures": {"count": len(failures), "first": [failure.what for failure in failures[:MOST_FAILURES]]},
        "notices": left_out.notices(),
    }


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
            row |= {measure: _summary(*sums[index]) for index, measure in enumerate(MEASURES)}
            rows.append(row)
        return rows


def _summary(count: float, total: float, squares: float) -> dict[str, float | int | None]:
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
