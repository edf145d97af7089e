"""Prints the plan and the results of a study on a terminal of 80 columns."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

from ..commands.tables import print_table
from .session_order import counterbalanced_orders
from .study_design import StudyPlan, level_text
from .study_price import Price

COLUMNS = ("GSI", "full edges", "dancers", "TA [s]", "missed", "n")
"""Columns of the table of conditions, behind the method and the levels of the factors."""

MOST_ROWS = 40
"""Conditions that are printed; study.json has all."""


def print_plan(plan: StudyPlan, needed: Price, jobs: int) -> None:
    """Print what the first group dances, how the groups differ, and what the study costs."""
    design = plan.design
    rows = [
        (str(spec.order), spec.condition, spec.config.humans, spec.config.dance.name)
        for spec in plan.sessions(0, plan.sessions_per_group)
    ]
    print_table(("order", "condition", "people", "dance"), rows, title="Sessions of group 1", left=(1, 2, 3))

    lines = [f"{plan.groups} groups, {design.replications} replication(s), order {design.order}"]
    orders = len(counterbalanced_orders(len(plan.conditions)))
    if design.order == "counterbalanced" and design.groups % orders:
        lines.append(f"the {orders} orders are not equally frequent: {design.groups} is no multiple of {orders}")
    if plan.cells[1:]:
        lines.append(f"{len(plan.cells)} combinations of {', '.join(design.between_groups)}, each with its own groups")
    lines.append(needed.text(jobs))
    sys.stdout.write("\n".join(lines) + "\n")


def print_results(results: Mapping[str, Any]) -> None:
    """Print the verdict, the table of conditions, and what was left out.

    Args:
        results: content of study.json.
    """
    design = results["design"]
    title = (
        f"{design['groups']} groups, {results['session_count']:,} sessions, "
        f"{design['session']['fidelity']} fidelity, {', '.join(design['humans'])}"
    )
    shown = results["conditions"][:MOST_ROWS]
    factors = tuple(dict.fromkeys(name for row in shown for name in row["factors"]))
    columns = ("method", *(name.rpartition(".")[2] for name in factors), *COLUMNS)
    print_table(columns, [_row(row, factors) for row in shown], title=title)
    for line in _remarks(results):
        sys.stdout.write(f"{line}\n")


def _row(row: Mapping[str, Any], factors: Sequence[str]) -> tuple[str, ...]:
    """Cells of a condition."""
    missed = "-" if row["ta_mean_s"]["n"] == 0 else _number(row["robot_missed"]["mean"], 1)
    return (
        row["method"],
        *(level_text(row["factors"][name]) if name in row["factors"] else "-" for name in factors),
        _with_interval(row["gsi"], 3),
        _number(row["gsi_full_edges"]["mean"], 3),
        _number(row["gsi_humans"]["mean"], 3),
        _with_interval(row["ta_mean_s"], 2),
        missed,
        str(row["sessions"]),
    )


def _remarks(results: Mapping[str, Any]) -> list[str]:
    """What the table does not hold, one line each."""
    lines = ["GSI and TA: mean over groups ± half the width of its 95 % interval", *results["notices"]]
    hidden = len(results["conditions"]) - MOST_ROWS
    if hidden > 0:
        lines.append(f"{hidden} more conditions are in study.json")
    failures = results["failures"]
    if failures["count"]:
        lines.append(f"{failures['count']} session(s) failed; the first: {failures['first'][0]}")
    return lines


def _with_interval(summary: Mapping[str, Any], digits: int) -> str:
    """A mean and half the width of its interval."""
    mean = _number(summary["mean"], digits)
    return mean if summary["low"] is None else f"{mean} ± {_number(summary['high'] - summary['mean'], digits)}"


def _number(value: float | None, digits: int) -> str:
    """A number with so many decimals and without a leading zero; ``-`` for what was not measured."""
    if value is None:
        return "-"
    return f"{value:.{digits}f}".replace("0.", ".", 1) if abs(value) < 1.0 else f"{value:.{digits}f}"
