"""Rows of a study's tables for one session."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analysis.group_metrics import GroupSynchronyRow, group_metrics, step_latencies
from ..config import HUMANS_ONLY
from ..core import ROBOT, Array
from ..core.session_log import AgentEvent, Decision
from ..session.session import Session


class SessionRows(NamedTuple):
    """Rows of one session, as columns; see `analysis.study_tables`.

    Attributes:
        session: measured columns of the row of the table ``sessions``; those that the design gives are not among them.
        iterations: columns of the table ``iterations``.
        steps: columns of the table ``steps``.
        events: columns of the table ``events``.
    """

    session: Mapping[str, float | int]
    iterations: Mapping[str, NDArray[np.generic]]
    steps: Mapping[str, NDArray[np.generic]]
    events: Mapping[str, NDArray[np.generic]]


def session_rows(session: Session, number: int) -> SessionRows:
    """Measure a session that has ended.

    Args:
        session: the session.
        number: its number in the study, the key of all tables.
    """
    logged = [
        AgentEvent(event.iteration, event.person, event.kind, event.t_s) for event in session.events if not event.early
    ]
    logged += session.world.robot_events
    measured = group_metrics(logged, session.config, session.timetable, session.followed)

    has_robot = session.config.method != HUMANS_ONLY
    iterations = _iteration_columns(measured, number, session.config.dancers, has_robot)
    return SessionRows(
        session={
            **{
                name: _finite_mean(np.asarray(iterations[name], dtype=np.float64))
                for name in ("gsi", "gsi_full_edges", "gsi_humans")
            },
            "ta_mean_s": _finite_mean(np.concatenate([row.ta_s for row in measured])),
            "robot_missed": int(iterations["robot_missed"].sum()),
        },
        iterations=iterations,
        steps=_step_columns(measured if has_robot else [], session.dispatcher.decisions, number),
        events=_event_columns(logged, session, number),
    )


def _iteration_columns(
    rows: list[GroupSynchronyRow], number: int, dancers: int, has_robot: bool
) -> dict[str, NDArray[np.generic]]:
    """Columns of the table ``iterations``."""
    return {
        "session": np.full(len(rows), number),
        "iteration": np.array([row.iteration for row in rows]),
        "gsi": np.array([row.gsi for row in rows]),
        "gsi_full_edges": np.array([row.gsi_full_edges for row in rows]),
        "gsi_humans": np.array([_humans_gsi(row.graph.pairs[:dancers, :dancers]) for row in rows]),
        "msp": np.array([_dancer_number(row.msp) for row in rows]),
        "followed": np.array([_dancer_number(row.follows) for row in rows]),
        "ta_mean_s": np.array([_finite_mean(row.ta_s) for row in rows]),
        "robot_missed": np.array([int(np.isnan(row.steps_s[-1]).sum()) if has_robot else 0 for row in rows]),
    }


def _step_columns(
    rows: Sequence[GroupSynchronyRow], decisions: Sequence[Decision], number: int
) -> dict[str, NDArray[np.generic]]:
    """Columns of the table ``steps``."""
    count = len(rows[0].ta_s) if rows else 0
    return {
        "session": np.full(len(rows) * count, number),
        "iteration": np.repeat(np.array([row.iteration for row in rows], dtype=np.int64), count),
        "ordinal": np.tile(np.arange(count), len(rows)),
        "ta_s": np.concatenate([np.zeros(0), *(row.ta_s for row in rows)]),
        "latency_s": np.concatenate([np.zeros(0), *(step_latencies(row, decisions) for row in rows)]),
    }


def _event_columns(logged: list[AgentEvent], session: Session, number: int) -> dict[str, NDArray[np.generic]]:
    """Columns of the table ``events``: dancers and robot in order of agent, iteration and time."""
    table = session.timetable
    start_s = {iteration: table.start_s(iteration) for iteration in range(1, table.last + 1)}
    danced = [event for event in logged if event.iteration >= 1]

    iteration = np.array([event.iteration for event in danced], dtype=np.int64)
    agent = np.array([_dancer_number(event.agent) for event in danced], dtype=np.int64)
    t_s = np.array([event.t_s - start_s[event.iteration] for event in danced], dtype=np.float64)
    kind = np.array([event.kind.value for event in danced], dtype=object)
    order = np.lexsort((t_s, iteration, agent))

    return {
        "session": np.full(len(danced), number),
        "iteration": iteration[order],
        "agent": agent[order],
        "kind": kind[order],
        "t_s": t_s[order],
    }


def _humans_gsi(pairs: Array) -> float:
    """Group synchronisation index of the dancers alone under all edges: the mean of their pairwise indices."""
    count = len(pairs)
    return float(pairs.sum() / (count * (count - 1))) if count > 1 else 0.0


def _dancer_number(name: str) -> int:
    """Number of a dancer, from 1; 0 for the robot and for nobody."""
    return 0 if name in ("", ROBOT) else int(name.rpartition("_")[2])


def _finite_mean(values: Array) -> float:
    """Mean of the finite values; NaN without any."""
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if len(finite) else float("nan")
