"""How well the group moved together, iteration by iteration: synchrony, whom the robot followed, timing.

Source: iqbal2016, sections III and VI.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..anticipation.synchrony import GroupSynchrony, Series, group_index, most_synchronous
from ..anticipation.timing_appropriateness import match_to_steps, timing_appropriateness
from ..choreography.timetable import Timetable
from ..config import SessionConfig
from ..core import ROBOT, Array, dancer_name
from ..core.session_log import AgentEvent, Followed

Events = Sequence[AgentEvent]


@dataclass(frozen=True, slots=True)
class GroupSynchronyRow:
    """One iteration of one set of events (logged or true).

    Attributes:
        iteration: which.
        graph: the group topology graph under the paper's edges.
        gsi: its group synchronisation index.
        gsi_full_edges: under all edges, which alone compares methods fairly.
        msp: the most synchronous person of this iteration.
        follows: the one whom the robot followed in this iteration; "" where it followed nobody, or several.
        steps_s: (A, K) time of each step by each agent, dancers first, after beat 0 [s]; NaN where missing.
        ta_s: (K,) timing appropriateness of each step [s]; NaN where undefined.
    """

    iteration: int
    graph: GroupSynchrony
    gsi: float
    gsi_full_edges: float
    msp: str
    follows: str
    steps_s: Array
    ta_s: Array


def group_metrics(
    events: Events,
    config: SessionConfig,
    timetable: Timetable,
    followed: Sequence[Followed],
    until: int | None = None,
) -> list[GroupSynchronyRow]:
    """Measure every danced iteration.

    Args:
        events: regular events of dancers and robot, assigned to iterations; the rehearsal's only settle ties of
            the first most synchronous person.
        config: method (``none`` leaves the robot out), tau, number of dancers.
        timetable: beats.
        followed: whom the method followed.
        until: the last iteration that is measured; that of the timetable if None.
    """
    cast = [dancer_name(index) for index in range(config.dancers)]
    agents = cast if config.method == "none" else [*cast, ROBOT]
    tau, one_to_one = config.synchrony.tau_s, config.synchrony.one_to_one
    before = None
    rows: list[GroupSynchronyRow] = []
    for iteration in range(timetable.first, (timetable.last if until is None else until) + 1):
        series = _series(events, agents, iteration, timetable.start_s(iteration))
        dancers = {name: series[name] for name in cast}
        msp = most_synchronous(dancers, before, tau).person
        if iteration >= 1:
            rows_of = [item.person for item in followed if item.iteration == iteration]
            follows = [name for name in rows_of if name] if rows_of else None
            leader = follows[0] if follows is not None and len(follows) == 1 else ""
            paper = group_index(series, "paper", follows=follows, tau=tau, one_to_one=one_to_one)
            full = group_index(series, "full", tau=tau, one_to_one=one_to_one).gsi
            steps = _steps(series, timetable, iteration)
            ta_s = np.zeros(0) if config.method == "none" else timing_appropriateness(steps[-1], steps[:-1])
            rows.append(GroupSynchronyRow(iteration, paper, paper.gsi, full, msp, leader, steps, ta_s))
        before = msp if any(len(kinds) for _, kinds in dancers.values()) else before
    return rows


def net_latencies(rows: Sequence[GroupSynchronyRow], timetable: Timetable) -> dict[str, Array]:
    """Robot's event minus the followed dancer's, by event kind [s]; empty where nobody is followed."""
    steps = timetable.choreography.steps()
    gaps: dict[str, list[float]] = {step.kind.value: [] for step in steps}
    for row in rows:
        if not row.follows:
            continue
        followed = row.steps_s[int(row.follows.rpartition("_")[2]) - 1]
        for step, gap in zip(steps, row.steps_s[-1] - followed, strict=True):
            if np.isfinite(gap):
                gaps[step.kind.value].append(float(gap))
    return {kind: np.array(values) for kind, values in gaps.items() if values}


def _series(events: Events, agents: Sequence[str], iteration: int, start_s: float) -> dict[str, Series]:
    """Times after beat 0 and kinds of every agent in one iteration."""
    mine: dict[str, list[AgentEvent]] = {agent: [] for agent in agents}
    for event in events:
        if event.iteration == iteration and event.agent in mine:
            mine[event.agent].append(event)
    return {
        agent: ([event.t_s - start_s for event in found], [event.kind for event in found])
        for agent, found in mine.items()
    }


def _steps(series: dict[str, Series], timetable: Timetable, iteration: int) -> Array:
    """(A, K) time of each step by each agent after beat 0 [s]."""
    steps = timetable.choreography.steps()
    start_s = timetable.start_s(iteration)
    expected = np.array([timetable.time_s(iteration, step.beat) - start_s for step in steps])
    return np.array([match_to_steps(times, kinds, steps, expected) for times, kinds in series.values()])
