"""Events of a session arranged by iteration, as the raster of a page shows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...analysis.group_metrics import GroupSynchronyRow
from ...analysis.missing_events import MissingEvents
from ...analysis.session_metrics import logged_events
from ...choreography.timetable import Timetable
from ...config import HUMANS_ONLY, SessionConfig
from ...core import ROBOT, dancer_name
from ...core.session_log import AgentEvent, SessionLog


@dataclass(frozen=True, slots=True)
class IterationEvents:
    """Events of one iteration; all times are counted from its beat 0 [s].

    Attributes:
        iteration: its number; 0 is the rehearsal.
        agents: dancers in order, then the robot if it dances.
        followed: the dancer whom the robot followed, or "".
        logged: logged events that happened.
        false: logged events that did not happen.
        not_logged: events that happened, and were not logged.
        not_performed: steps that an agent left out.
        links: (followed dancer's time, robot's time) of the steps for which both have an event.
        beats_s: nominal time of each step.
        length_s: time until the iteration's window closes.
    """

    iteration: int
    agents: tuple[str, ...]
    followed: str
    logged: tuple[AgentEvent, ...]
    false: tuple[AgentEvent, ...]
    not_logged: tuple[AgentEvent, ...]
    not_performed: tuple[AgentEvent, ...]
    links: tuple[tuple[float, float], ...]
    beats_s: tuple[float, ...]
    length_s: float


def iteration_events(
    log: SessionLog,
    config: SessionConfig,
    table: Timetable,
    rows: Sequence[GroupSynchronyRow],
    missing: MissingEvents,
) -> list[IterationEvents]:
    """Events of every iteration, the rehearsal included.

    Args:
        log: the session.
        config: its configuration.
        table: its timetable.
        rows: measures of the danced iterations, from logged events.
        missing: missing and false events of the danced iterations.
    """
    dancers = tuple(dancer_name(index) for index in range(config.dancers))
    measured = {row.iteration: row for row in rows}
    logged = logged_events(log)

    found = []
    for iteration in range(table.first, table.last + 1):
        start_s = table.start_s(iteration)
        row = measured.get(iteration)
        # In the rehearsal the robot stands still.
        has_robot = config.method != HUMANS_ONLY and iteration > 0
        false = _own(missing.false, iteration, start_s)
        found.append(
            IterationEvents(
                iteration=iteration,
                agents=(*dancers, ROBOT) if has_robot else dancers,
                followed=row.follows if row else "",
                logged=tuple(event for event in _own(logged, iteration, start_s) if event not in false),
                false=false,
                not_logged=_own(missing.not_logged, iteration, start_s),
                not_performed=_own(missing.not_performed, iteration, start_s),
                links=_links(row) if row else (),
                beats_s=tuple(table.time_s(iteration, step.beat) - start_s for step in table.choreography.steps()),
                length_s=table.close_s(iteration) - start_s,
            )
        )
    return found


def _own(events: Sequence[AgentEvent], iteration: int, start_s: float) -> tuple[AgentEvent, ...]:
    """Events of one iteration with times since its beat 0."""
    return tuple(replace(event, t_s=event.t_s - start_s) for event in events if event.iteration == iteration)


def _links(row: GroupSynchronyRow) -> tuple[tuple[float, float], ...]:
    """Times of the followed dancer and of the robot; none if it followed nobody, or several dancers."""
    if not row.follows:
        return ()
    leader_s = row.steps_s[row.graph.agents.index(row.follows)]
    pairs = np.stack([leader_s, row.steps_s[-1]], axis=1)
    return tuple((float(leader), float(robot)) for leader, robot in pairs[np.isfinite(pairs).all(axis=1)])
