"""Figures of a study: the content of study.json beyond the design.

To add a figure: compute it in a function of its own on `StudyTables`, and add it to `study_summary`. Figures that are
not defined are NaN in the functions and None here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core import Array
from ..core.errors import ConfigError
from .comparisons import comparable_pairs, compare_conditions
from .event_rows import event_rows
from .json_data import without_nan
from .paired_intervals import RESAMPLES, mean_interval
from .paired_tests import signed_rank
from .ratings import rating_figures
from .replications import replication_figures
from .study_tables import StudyTables
from .study_values import (
    condition_names,
    conditions_with_robot,
    group_values,
    iteration_values,
    select_sessions,
    step_values,
)
from .surrogates import chance_level, observed_indices
from .synchrony_table import table_rows, win_counts
from .timing_distribution import shares_within, timing_histogram

INDICES = ("gsi", "gsi_full_edges", "gsi_humans")
"""Synchronisation indices that are summarised for every condition."""

CONFIDENCE = 0.95
"""Probability that an interval should contain the value."""

SAME_INDEX = 1e-6
"""Largest difference at which two computations of an index count as equal."""

EVENT_WARNING = (
    "The events of a session are not independent, so this test, which is the paper's, rejects too often. "
    "The tests under comparisons take groups as the unit."
)


def study_summary(
    tables: StudyTables,
    conditions: Sequence[str] = (),
    seed: int = 0,
    adjustment: str = "holm",
    tau_s: float = 0.25,
) -> dict[str, object]:
    """Compute the figures of a study.

    A study that was replicated is described by its first replication; ``replications`` tells how much the figures
    vary between them.

    Args:
        tables: the study.
        conditions: names of conditions in the order in which they are reported and compared: a difference is the later
            one minus the earlier one. By default, the order of the first sessions.
        seed: of the random numbers of bootstrap and permutation.
        adjustment: of the probabilities over several comparisons: holm, benjamini-hochberg or none.
        tau_s: window of synchrony with which the sessions were measured [s]; chance levels are computed with it.

    Returns:
        plain data for JSON. By condition: ``gsi``, ``gsi_full_edges``, ``gsi_humans``, ``ta``, ``chance``. For the
        paper's figures: ``table`` (Table I), ``wins``, ``wilcoxon``, ``ratings``. At group level: ``comparisons``,
        ``intervals``. ``notices`` says in sentences what is missing. See docs/statistics.md.

    Raises:
        ConfigError: the study has no session, or none of a named condition.
    """
    if len(tables.sessions["session"]) == 0:
        raise ConfigError("sessions", 0, "at least one session")
    studies = np.unique(tables.sessions["study"])
    one = select_sessions(tables, np.asarray(tables.sessions["study"] == studies[0]))
    names = condition_names(one, conditions)
    robotic = conditions_with_robot(one, names)
    rng = np.random.default_rng(seed)

    # The paper's table has the methods alone; sessions without a robot are not part of it.
    iterations = iteration_values(one, "gsi", robotic)
    groups = group_values(one, "gsi", robotic)
    chance, notices = chance_levels(one, names, rng, tau_s)
    content = {
        "conditions": list(names),
        "groups": len(np.unique(one.sessions["group"])),
        "sessions": len(one.sessions["session"]),
        "studies": len(studies),
        "table": table_rows(iterations, groups),
        **{index: {name: synchrony_figures(one, index, name, rng) for name in names} for index in INDICES},
        "ta": {name: timing_figures(one, name, rng) for name in robotic},
        "wins": win_counts(iterations, groups),
        "wilcoxon": event_test(one, robotic),
        "chance": chance,
        "ratings": rating_figures(one, robotic, seed),
        "comparisons": compare_conditions(one, names, rng, adjustment),
        "intervals": {
            "confidence": CONFIDENCE,
            "method": "studentised bootstrap over groups",
            "resamples": RESAMPLES,
            "seed": seed,
        },
        "replications": replication_figures(tables, robotic) if len(studies) > 1 else None,
        "notices": [*notices, *_pairing_notices(one, names)],
    }
    plain = without_nan(content)
    assert isinstance(plain, dict)
    return plain


def synchrony_figures(tables: StudyTables, index: str, condition: str, rng: np.random.Generator) -> dict[str, object]:
    """Summarise a synchronisation index of one condition over groups and iterations.

    Args:
        tables: one study.
        index: one of `INDICES`.
        condition: name of the condition.
        rng: draws bootstrap samples.

    Returns:
        ``mean`` over groups with its interval ``low`` and ``high``; ``sd`` over all iterations as in the paper,
        ``sd_groups`` of the group means; ``min`` and ``max`` of an iteration; the numbers of ``groups`` and
        ``iterations``; ``by_iteration`` with the mean over groups and its interval.
    """
    groups = group_values(tables, index, (condition,)).values[:, 0]
    iterations = iteration_values(tables, index, (condition,))
    values = _finite(iterations.values[:, 0])
    # The standard deviation is that of iterations, as in the paper; the interval is that of groups.
    mean = mean_interval(groups, rng, CONFIDENCE)

    by_iteration = []
    for number in np.unique(iterations.units[:, 2]):
        own = mean_interval(iterations.values[iterations.units[:, 2] == number, 0], rng, CONFIDENCE)
        by_iteration.append({"iteration": int(number), "mean": own.value, "low": own.low, "high": own.high})

    return {
        "mean": mean.value,
        "low": mean.low,
        "high": mean.high,
        "sd": _sd(values),
        "sd_groups": _sd(_finite(groups)),
        "min": float(values.min()) if len(values) else float("nan"),
        "max": float(values.max()) if len(values) else float("nan"),
        "groups": len(_finite(groups)),
        "iterations": len(values),
        "by_iteration": by_iteration,
    }


def timing_figures(tables: StudyTables, condition: str, rng: np.random.Generator) -> dict[str, object]:
    """Summarise the timing appropriateness of one condition over groups and steps.

    Args:
        tables: one study.
        condition: name of a condition with a robot.
        rng: draws bootstrap samples.

    Returns:
        ``mean_s`` and ``sd_s`` over all ``n`` steps as in the paper, the number of steps that the robot ``missed``, the
        mean over groups ``group_mean_s`` with its interval ``low_s`` and ``high_s``, ``cdf`` (shares within .8, 1.2 and
        1.6 s) and ``histogram``.
    """
    ta_s = _steps_of(tables, condition)
    finite = _finite(ta_s)
    mean = mean_interval(group_values(tables, "ta_mean_s", (condition,)).values[:, 0], rng, CONFIDENCE)
    return {
        "mean_s": float(finite.mean()) if len(finite) else float("nan"),
        "sd_s": _sd(finite),
        "n": len(finite),
        "missed": len(ta_s) - len(finite),
        "group_mean_s": mean.value,
        "low_s": mean.low,
        "high_s": mean.high,
        "cdf": shares_within(ta_s),
        "histogram": timing_histogram(ta_s),
    }


def event_test(tables: StudyTables, conditions: Sequence[str]) -> dict[str, object] | None:
    """Compute the paper's test of timing appropriateness: signed ranks of the steps of the first two conditions.

    Args:
        tables: one study.
        conditions: names of the conditions with a robot.

    Returns:
        ``pair``, ``z``, ``p``, ``r``, ``n`` (observations, two per pair of steps), ``zeros`` and ``warning``; None with
        fewer than two conditions or without a pair of steps.
    """
    if len(conditions) < 2:
        return None
    pairs = step_values(tables, conditions).pairs(conditions[0], conditions[1])
    if len(pairs) == 0:
        return None

    result = signed_rank(pairs[:, 0], pairs[:, 1])
    return {
        "pair": list(conditions[:2]),
        "z": result.z,
        "p": result.p,
        "r": result.r,
        "n": result.observations,
        "zeros": result.zeros,
        "warning": EVENT_WARNING,
    }


def chance_levels(
    tables: StudyTables, conditions: Sequence[str], rng: np.random.Generator, tau_s: float
) -> tuple[dict[str, object], list[str]]:
    """Compute the chance level of the synchronisation indices of every condition.

    Args:
        tables: one study.
        conditions: names of the conditions.
        rng: draws the surrogates.
        tau_s: window of synchrony [s].

    Returns:
        condition -> chance level, see `surrogates.chance_level`, None without events; and sentences about conditions
        without one.
    """
    levels: dict[str, object] = {}
    notices: list[str] = []
    for name in conditions:
        rows = event_rows(tables, name, tau_s)
        levels[name] = None
        if rows is None:
            notices.append(f"{name}: no chance level, because the study has kept no events")
            continue

        levels[name] = chance_level(rows, rng)
        # The indices of the real groups must come out as they were measured, or the chance level is another one's.
        difference = float(np.abs(observed_indices(rows).gsi - rows.gsi).max())
        if difference > SAME_INDEX:
            notices.append(
                f"{name}: the chance level is computed with other parameters of synchrony than the table, whose "
                f"indices differ by up to {difference:.3f}"
            )
        agents = rows.slices.shape[1]
        if len(rows.row_of) < agents:
            notices.append(f"{name}: {len(rows.row_of)} groups are too few for pseudo-groups of {agents} agents")
    return levels, notices


def _pairing_notices(tables: StudyTables, conditions: Sequence[str]) -> list[str]:
    """A sentence if conditions that differ in one thing alone have different groups, so that nothing is paired."""
    groups = group_values(tables, "gsi_humans", conditions)
    apart = [pair for pair in comparable_pairs(tables, conditions) if not len(groups.pairs(*pair))]
    if not apart:
        return []
    return [
        f"no group danced both: {len(apart)} pairs of conditions are not compared, such as {' and '.join(apart[0])}"
    ]


def _steps_of(tables: StudyTables, condition: str) -> Array:
    """(N,) timing appropriateness of every step of a condition [s]."""
    numbers = tables.sessions["session"][np.asarray(tables.sessions["condition"] == condition)]
    return np.asarray(tables.steps["ta_s"][np.isin(tables.steps["session"], numbers)], dtype=np.float64)


def _finite(values: Array) -> Array:
    return np.asarray(values[np.isfinite(values)])


def _sd(values: Array) -> float:
    """Sample standard deviation; NaN for fewer than two values."""
    return float(np.std(values, ddof=1)) if len(values) > 1 else float("nan")
