"""Events that are absent from a session's log, or that stand in it without having happened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..anticipation.timing_appropriateness import ideal_times
from ..choreography.timetable import Timetable, timetable
from ..config import SessionConfig
from ..config.toml_file import from_plain
from ..core import ROBOT, Kind
from ..core.session_log import AgentEvent, SessionLog
from .component_quality import MATCH_WITHIN_S
from .event_matching import match_times
from .group_metrics import GroupSynchronyRow, group_metrics
from .session_metrics import logged_events, true_events


@dataclass(frozen=True, slots=True)
class MissingEvents:
    """Differences between the steps of the dance, the true events and the logged ones, in danced iterations.

    Attributes:
        not_performed: steps that an agent left out, at the mean time of the dancers who performed them, else at the
            beat.
        not_logged: true events without a logged event within `component_quality.MATCH_WITHIN_S`, at their true times.
        false: logged events without a true event within that time, at their logged times.
    """

    not_performed: tuple[AgentEvent, ...]
    not_logged: tuple[AgentEvent, ...]
    false: tuple[AgentEvent, ...]


def missing_events(log: SessionLog) -> MissingEvents:
    """Find the events of dancers and robot that are missing or false.

    Args:
        log: the session.
    """
    config = from_plain(log.config)
    table = timetable(config)
    logged = [event for event in logged_events(log) if event.iteration >= 1]
    dancers, robot = true_events(log, table)
    true = [event for event in (*dancers, *robot) if event.iteration >= 1]

    not_logged, false = _unmatched(true, logged)
    return MissingEvents(_not_performed(true, config, table), tuple(not_logged), tuple(false))


def _unmatched(true: Sequence[AgentEvent], logged: Sequence[AgentEvent]) -> tuple[list[AgentEvent], list[AgentEvent]]:
    """True events without a logged one, and logged events without a true one."""
    not_logged: list[AgentEvent] = []
    false: list[AgentEvent] = []

    # An event matches only one of the same agent and kind.
    for key in sorted({(event.agent, event.kind) for event in (*true, *logged)}):
        own_true = [event for event in true if (event.agent, event.kind) == key]
        own_logged = [event for event in logged if (event.agent, event.kind) == key]
        times = [np.array([event.t_s for event in events]) for events in (own_logged, own_true)]
        rows, columns = match_times(times[0], times[1], MATCH_WITHIN_S)
        false += [event for row, event in enumerate(own_logged) if row not in rows]
        not_logged += [event for column, event in enumerate(own_true) if column not in columns]
    return not_logged, false


def _not_performed(true: Sequence[AgentEvent], config: SessionConfig, table: Timetable) -> tuple[AgentEvent, ...]:
    """Steps without a true event of an agent."""
    rows = group_metrics(true, config, table, followed=())
    return tuple(event for row in rows for event in _left_out(row, table))


def _left_out(row: GroupSynchronyRow, table: Timetable) -> list[AgentEvent]:
    """Steps of one iteration that an agent left out."""
    start_s = table.start_s(row.iteration)
    dancers_s = row.steps_s[[agent != ROBOT for agent in row.graph.agents]]
    mean_s = start_s + ideal_times(dancers_s)

    found: list[AgentEvent] = []
    for agent, times_s in zip(row.graph.agents, row.steps_s, strict=True):
        for step in table.choreography.steps():
            if np.isfinite(times_s[step.ordinal]):
                continue
            mean = float(mean_s[step.ordinal])
            t_s = mean if np.isfinite(mean) else table.time_s(row.iteration, step.beat)
            # The robot turns where the dancers clap.
            kind = Kind.TURN if agent == ROBOT and step.kind is Kind.CLAP else step.kind
            found.append(AgentEvent(row.iteration, agent, kind, t_s))
    return found
