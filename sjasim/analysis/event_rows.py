"""Events of one condition of a study as flat arrays, arranged for the computation of many synchronisation indices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..anticipation.coincidences import microseconds
from ..core import Array, BoolArray, IntArray, Kind
from .study_tables import StudyTables
from .study_values import conditions_with_robot, select_sessions


@dataclass(frozen=True, slots=True)
class EventRows:
    """Events of R iterations of D dancers, and of a robot as the last of the H agents.

    Attributes:
        times_us: (E,) time of each event since beat 0 of its iteration [us], in order of iteration, agent and time.
        kinds: (E,) code of its kind, from 0; a turn has the code of a clap.
        series: (E,) number of the series, one agent in one iteration, that the event belongs to, in ascending order.
        slices: (R, H, 2) first event and the one after the last event of each agent.
        row_of: (G, I) row of each group and iteration; -1 where it is missing.
        robot_edges: (R, D) to which dancers the robot has an edge under the paper's edges; all without a robot.
        gsi: (R,) index in the table ``iterations``, under the paper's edges.
        has_robot: whether the condition has a robot.
        kind_count: number of kinds.
        tau_us: two events coincide if they are less than this apart [us].
    """

    times_us: IntArray
    kinds: IntArray
    series: IntArray
    slices: IntArray
    row_of: IntArray
    robot_edges: BoolArray
    gsi: Array
    has_robot: bool
    kind_count: int
    tau_us: int


def event_rows(tables: StudyTables, condition: str, tau_s: float = 0.25) -> EventRows | None:
    """Arrange the events of a condition; None if the study has kept none of them.

    Several sessions of one group under the condition count as different groups.

    Args:
        tables: one study.
        condition: name of the condition.
        tau_s: two events coincide if they are less than this apart [s] (iqbal2016: .25 s).

    Raises:
        ConfigError: a time is not finite.
    """
    own = select_sessions(tables, np.asarray(tables.sessions["condition"] == condition))
    if len(own.events["session"]) == 0:
        return None
    has_robot = condition in conditions_with_robot(tables, (condition,))

    # Rows are the iterations of the table, so that one without any event counts as well.
    session, session_of_row = np.unique(own.iterations["session"], return_inverse=True)
    iteration, iteration_of_row = np.unique(own.iterations["iteration"], return_inverse=True)
    row_of = np.full((len(session), len(iteration)), -1, dtype=np.int64)
    row_of[session_of_row, iteration_of_row] = np.arange(len(session_of_row))

    agent = np.asarray(own.events["agent"], dtype=np.int64)
    dancers = int(agent.max())
    agents = dancers + has_robot
    column = np.where(agent == 0, dancers, agent - 1)
    row = row_of[np.searchsorted(session, own.events["session"]), np.searchsorted(iteration, own.events["iteration"])]
    # Series are numbered by iteration, then agent, so that a sort makes their events contiguous.
    series = row * agents + column
    times_us = microseconds(np.asarray(own.events["t_s"], dtype=np.float64))
    order = np.lexsort((times_us, series))

    codes, kinds = np.unique([_kind(kind) for kind in own.events["kind"]], return_inverse=True)
    bounds = np.searchsorted(series[order], np.arange(len(session_of_row) * agents + 1))
    return EventRows(
        times_us=times_us[order],
        kinds=np.asarray(kinds, dtype=np.int64)[order],
        series=series[order],
        slices=np.stack([bounds[:-1], bounds[1:]], axis=1).reshape(len(session_of_row), agents, 2),
        row_of=row_of,
        robot_edges=_robot_edges(own, iteration_of_row, dancers),
        gsi=np.asarray(own.iterations["gsi"], dtype=np.float64),
        has_robot=has_robot,
        kind_count=len(codes),
        tau_us=round(tau_s * 1e6),
    )


def _kind(kind: object) -> str:
    """Kind for which synchrony is measured: a turn counts as a clap."""
    return Kind.CLAP.value if kind == Kind.TURN else str(kind)


def _robot_edges(tables: StudyTables, iteration_of_row: IntArray, dancers: int) -> BoolArray:
    """(R, D) edges of the robot under the paper's edges.

    The table names the dancer whom the robot followed; without a name it has edges to all of them or to none. It has
    all if, in this iteration of the dance, both indices of every such session are equal.
    """
    followed = np.asarray(tables.iterations["followed"], dtype=np.int64)
    edges = followed[:, None] == np.arange(1, dancers + 1)
    gsi = np.asarray(tables.iterations["gsi"], dtype=np.float64)
    difference = np.abs(gsi - np.asarray(tables.iterations["gsi_full_edges"], dtype=np.float64))

    for iteration in np.unique(iteration_of_row):
        unnamed = (iteration_of_row == iteration) & (followed == 0)
        if unnamed.any() and difference[unnamed].max() < 1e-9:
            edges[unnamed] = True
    return np.asarray(edges)
