"""Prints the plan and the results of a study on a terminal of 80 columns."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from ..commands.tables import print_table
from .session_order import counterbalanced_orders
from .study_design import StudyPlan, level_text
from .study_price import Price

COLUMNS = ("GSI", "TA [s]", "missed", "n", "chance (95 %)", "full edges")
"""Columns of the table of conditions, behind the method and the levels of the factors."""

NARROW_COLUMNS = 4
"""Number of these columns that fit beside two or more factors."""

SIGNIFICANT = 0.05
"""Probability, adjusted for several comparisons, below which a difference is called shown."""

WIDTH = 80
"""Longest line."""

MOST_PAIRS = 3
"""Pairs of conditions whose comparison is printed; study.json has all."""

MEASURES = {
    "gsi_full_edges": ("GSI, full edges,", "", 3),
    "gsi": ("GSI by the paper's edges", "", 3),
    "ta_mean_s": ("TA", " s", 2),
}
"""Compared measure -> its name, unit and decimals."""

VERDICT = {"gsi_full_edges": "GSI", "ta_mean_s": "TA"}
"""Measure that the verdict judges, as the report does -> its name.

The paper's edges count fewer pairs for a robot that follows one dancer, so that its index favours other methods.
"""

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
    for line in verdict(results):
        sys.stdout.write(f"{line}\n")

    design = results["design"]
    title = (
        f"{design['groups']} groups, {results['session_count']:,} sessions, "
        f"{design['session']['fidelity']} fidelity, {', '.join(design['humans'])}"
    )
    shown = results["by_condition"][:MOST_ROWS]
    factors = tuple(dict.fromkeys(name for row in shown for name in row["factors"]))
    names = ("method", *(name.rpartition(".")[2] for name in factors))
    columns = (*names, *COLUMNS)[: len(names) + (NARROW_COLUMNS if len(factors) > 1 else len(COLUMNS))]
    chance = results.get("chance", {})
    rows = [_row(row, factors, chance.get(row["condition"])) for row in shown]
    print_table(columns, [row[: len(columns)] for row in rows], title=title)
    for line in _remarks(results):
        sys.stdout.write(f"{line}\n")


def verdict(results: Mapping[str, Any]) -> list[str]:
    """What the study shows about pairs of methods under the same levels of the factors, in words and figures.

    Args:
        results: content of study.json.
    """
    by_pair: dict[tuple[str, str], dict[str, Mapping[str, Any]]] = {}
    for row in results.get("comparisons", ()):
        by_pair.setdefault((row["first"], row["second"]), {})[row["measure"]] = row

    # Sessions without a robot are compared by the dancers' index alone.
    pairs = {pair: rows for pair, rows in by_pair.items() if "gsi" in rows}
    conditions = {row["condition"]: row for row in results["by_condition"]}
    alike = [pair for pair in pairs if _have_equal_levels(conditions[pair[0]], conditions[pair[1]])]

    lines = []
    for first, second in alike[:MOST_PAIRS]:
        rows = pairs[first, second]
        found = ", ".join(_finding(rows[measure]) for measure in VERDICT if measure in rows)
        lines += textwrap.wrap(f"{second} against {first}: {found}", WIDTH)
        lines += [f"  {_difference(rows[measure])}" for measure in MEASURES if measure in rows]
        lines += [f"  {line}" for line in _wins(results, first, second)]
    hidden = len(pairs) - len(alike[:MOST_PAIRS])
    return [*lines, f"{hidden} more pairs of conditions are compared in study.json"] if hidden else lines


def _have_equal_levels(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether two conditions have other methods and equal levels of the factors that matter to both."""
    shared = one["factors"].keys() & other["factors"].keys()
    return one["method"] != other["method"] and all(one["factors"][name] == other["factors"][name] for name in shared)


def _finding(row: Mapping[str, Any]) -> str:
    """Whether a difference of the second condition is shown, in words."""
    name = VERDICT[row["measure"]]
    p = row["p_adjusted"]
    if p is None or p >= SIGNIFICANT:
        return f"no difference of {name} is shown"
    return f"{'higher' if row['difference'] > 0 else 'lower'} {name}"


def _difference(row: Mapping[str, Any]) -> str:
    """A difference with its interval and probability."""
    name, unit, digits = MEASURES[row["measure"]]
    text = f"{name} {_signed(row['difference'], digits)}{unit}"
    if row["low"] is not None:
        text += f", 95 % interval {_signed(row['low'], digits)} to {_signed(row['high'], digits)}"
    p = "" if row["p_adjusted"] is None else f", p = {_number(row['p_adjusted'], 4)}"
    return f"{text}{p}, {row['groups']} groups"


def _wins(results: Mapping[str, Any], first: str, second: str) -> list[str]:
    """How often the second condition has the higher index, and the published test of the timing."""
    lines = []
    for row in (results["wins"] or {}).get("pairs", ()):
        if (row["first"], row["second"]) == (first, second):
            iterations = row["iterations"]
            groups = row["groups"]
            lines.append(
                f"by the paper's edges higher in {iterations['second']} of {iterations['n']} iterations, "
                f"{groups['second']} of {groups['n']} groups"
            )
    test = results["wilcoxon"]
    if test is not None and test["pair"] == [first, second]:
        lines.append(
            f"Wilcoxon by step: z = {test['z']:.2f}, r = {_number(test['r'], 2)}, n = {test['n']} "
            "(steps are not independent)"
        )
    return lines


def _row(row: Mapping[str, Any], factors: Sequence[str], chance: Mapping[str, Any] | None) -> tuple[str, ...]:
    """Cells of a condition."""
    missed = "-" if row["ta_mean_s"]["n"] == 0 else _number(row["robot_missed"]["mean"], 1)
    by_chance = "-" if chance is None else f"{_number(chance['mean'], 2)} ({_number(chance['p95'], 2)})"
    return (
        row["method"],
        *(level_text(row["factors"][name]) if name in row["factors"] else "-" for name in factors),
        _with_interval(row["gsi"], 3),
        _with_interval(row["ta_mean_s"], 2),
        missed,
        str(row["sessions"]),
        by_chance,
        _number(row["gsi_full_edges"]["mean"], 3),
    )


def _remarks(results: Mapping[str, Any]) -> list[str]:
    """What the table does not hold, one line each."""
    lines = ["±: half of the 95 % interval; chance: mean and 95 % point of surrogates"]
    lines += results["notices"]
    hidden = len(results["by_condition"]) - MOST_ROWS
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


def _signed(value: float, digits: int) -> str:
    """A number with its sign."""
    return f"{'-' if value < 0 else '+'}{_number(abs(value), digits)}"
