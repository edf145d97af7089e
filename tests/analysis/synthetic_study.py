"""Tables of studies that are computed from formulas: nested groups, iterations and events, without a simulation."""

from __future__ import annotations

import numpy as np

from sjasim.analysis.study_tables import COLUMNS, StudyTables
from sjasim.anticipation.synchrony import group_index, most_synchronous
from sjasim.assets.published_study import GSI

KINDS = ("start_forward", "stop_forward", "start_backward", "stop_backward") * 2 + ("clap",)
"""Kinds of the nine steps of an iteration."""

STEP_S = 2.0
"""Time between two steps [s]."""


def paper_table() -> StudyTables:
    """The paper's Table I as a study, without steps and events."""
    rows = {"sessions": [], "iterations": []}
    for group, cells in enumerate(zip(GSI["eca"], GSI["sia"], strict=True), start=1):
        for order, (method, values) in enumerate(zip(("eca", "sia"), cells, strict=True), start=1):
            number = len(rows["sessions"])
            rows["sessions"].append(session_row(number, 0, group, order, method, np.mean(values)))
            for iteration, value in enumerate(values, start=1):
                rows["iterations"].append(iteration_row(number, iteration, value))
    return as_tables(rows)


def session_row(number, study, group, order, method, gsi, full=np.nan, humans=np.nan, ta=np.nan, missed=0):
    """One row of the table of sessions."""
    return (number, study, group, order, method, method, "synthetic", group, gsi, full, humans, ta, missed)


def iteration_row(number, iteration, gsi, full=np.nan, humans=np.nan, msp=0, followed=0, ta=np.nan, missed=0):
    """One row of the table of iterations."""
    return (number, iteration, gsi, full, humans, msp, followed, ta, missed)


def as_tables(rows) -> StudyTables:
    """Columns from rows; tables without rows have empty columns."""
    tables = {}
    for table, columns in COLUMNS.items():
        found = rows.get(table, [])
        tables[table] = {
            name: np.array([row[index] for row in found], dtype=object if column.dtype == "str" else column.dtype)
            for index, (name, column) in enumerate(columns.items())
        }
    return StudyTables(**tables)


def nested_study(
    rng, groups=9, methods=("eca", "sia"), effect_s=0.0, shared_s=0.3, own_s=0.15, iterations=4, studies=1
) -> StudyTables:
    """A study in which all steps of an iteration share an error, so that events are not independent.

    Dancers share a shift per iteration, as people who start together early or late do; the robot misses it, so that its
    timing appropriateness is nearly the same at all steps of the iteration. ``effect_s`` is added to the robot's error
    under all methods but the first. Under ``eca`` the robot has edges to all, under ``sia`` to dancer 1, but in
    iteration 1 to nobody; ``none`` has no robot.
    """
    rows = {name: [] for name in COLUMNS}
    for study in range(studies):
        for group in range(1, groups + 1):
            scale = np.exp(0.2 * rng.standard_normal())
            for order, method in enumerate(methods, start=1):
                number = len(rows["sessions"])
                session = []
                for iteration in range(1, iterations + 1):
                    shift_s = shared_s * scale * rng.standard_normal()
                    late_s = effect_s if order > 1 else 0.0
                    session.append(iteration_of(rows, rng, number, iteration, method, shift_s, late_s, own_s * scale))
                gsi, full, humans, ta = np.array(session).T
                mean_ta = np.nanmean(ta) if method != "none" else np.nan
                means = (gsi.mean(), full.mean(), humans.mean(), mean_ta)
                rows["sessions"].append(session_row(number, study, group, order, method, *means))
    return as_tables(rows)


def iteration_of(rows, rng, number, iteration, method, shift_s, late_s, own_s):
    """Append the rows of one iteration, and return its indices and its mean timing appropriateness."""
    nominal_s = STEP_S * np.arange(len(KINDS))
    dancers_s = nominal_s + shift_s + own_s * rng.standard_normal((3, len(KINDS)))
    robot_s = nominal_s + late_s + 0.5 * own_s * rng.standard_normal(len(KINDS))
    series = {f"dancer_{index + 1}": (times.tolist(), list(KINDS)) for index, times in enumerate(dancers_s)}
    humans = group_index(series, "full").gsi
    msp = int(most_synchronous(series).person[-1])

    followed = 1 if method == "sia" and iteration > 1 else 0
    gsi = full = humans
    ta_s = np.full(len(KINDS), np.nan)
    agents = [(index + 1, times) for index, times in enumerate(dancers_s)]
    if method != "none":
        series["robot"] = (robot_s.tolist(), [*KINDS[:-1], "turn"])
        agents.append((0, robot_s))
        follows = None if method != "sia" else ["dancer_1"] if followed else []
        gsi = group_index(series, "paper", follows=follows).gsi
        full = group_index(series, "full").gsi
        ta_s = np.abs(robot_s - dancers_s.mean(axis=0))
        rows["steps"] += [(number, iteration, ordinal, value, np.nan) for ordinal, value in enumerate(ta_s)]

    mean_ta_s = float(np.mean(ta_s))
    rows["iterations"].append(iteration_row(number, iteration, gsi, full, humans, msp, followed, mean_ta_s))
    for agent, times in agents:
        names = [*KINDS[:-1], "turn"] if agent == 0 else KINDS
        rows["events"] += [(number, iteration, agent, kind, t_s) for kind, t_s in zip(names, times, strict=True)]
    return gsi, full, humans, mean_ta_s
