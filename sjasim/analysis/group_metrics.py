"""Synchrony and timing of the group in each iteration: GSI, most synchronous person, followed dancer, timing.

To add a measure of an iteration: add a field to `GroupSynchronyRow` and compute it in `_measure_iteration`. A measure
of the session is added in `session_metrics`; the indices themselves are computed in `anticipation.synchrony`.

Source: iqbal2016, sections III and VI.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..anticipation.coincidences import Series
from ..anticipation.synchrony import GroupSynchrony, group_index, most_synchronous
from ..anticipation.timing_appropriateness import match_to_steps, timing_appropriateness
from ..choreography.timetable import Timetable
from ..config import SessionConfig
from ..core import ROBOT, Array, dancer_name
from ..core.session_log import AgentEvent, Followed


@dataclass(frozen=True, slots=True)
class GroupSynchronyRow:
    """Measures of one iteration from one set of events, logged or true.

    Attributes:
        iteration: number of the iteration.
        graph: the group topology graph under the paper's edges.
        gsi: group synchronisation index of that graph.
        gsi_full_edges: the index under all edges; it does not depend on the method, and so compares methods fairly.
        msp: the most synchronous person of this iteration.
        follows: the dancer whom the robot followed in this iteration; "" if it followed nobody, or several dancers.
        steps_s: (A, K) time of each step by each agent, dancers first, since the iteration's beat 0 [s]; NaN where an
            agent has no event for the step.
        ta_s: (K,) timing appropriateness of each step [s]; NaN where undefined. Empty without a robot.
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
    events: Sequence[AgentEvent],
    config: SessionConfig,
    timetable: Timetable,
    followed: Sequence[Followed],
    until: int | None = None,
) -> list[GroupSynchronyRow]:
    """Measure every danced iteration.

    Args:
        events: regular events of dancers and robot, with their iterations. Events of the rehearsal serve only to decide
            a tie for the first most synchronous person.
        config: method (``none`` leaves the robot out), parameters of synchrony, number of dancers.
        timetable: times of the beats.
        followed: whom the method followed in which iteration.
        until: last iteration to measure; by default the last of the timetable.
    """
    last = timetable.last if until is None else until
    dancers = [dancer_name(index) for index in range(config.dancers)]
    agents = dancers if config.method == "none" else [*dancers, ROBOT]

    previous_msp = None
    rows: list[GroupSynchronyRow] = []
    for iteration in range(timetable.first, last + 1):
        series = _series(events, agents, iteration, timetable.start_s(iteration))
        dancers_series = {name: series[name] for name in dancers}
        msp = most_synchronous(dancers_series, previous_msp, config.synchrony.tau_s).person

        # The rehearsal, iteration 0, is not measured.
        if iteration >= 1:
            follows = _followed_in(followed, iteration)
            rows.append(_measure_iteration(series, config, timetable, iteration, msp, follows))
        # An iteration without events has no most synchronous person, and leaves the earlier one.
        if any(len(kinds) for _, kinds in dancers_series.values()):
            previous_msp = msp

    return rows


def net_latencies(rows: Sequence[GroupSynchronyRow], timetable: Timetable) -> dict[str, Array]:
    """Times of the robot's events minus those of the followed dancer, by event kind [s].

    Only iterations in which the robot follows one dancer count; kinds without any pair of events are left out.
    """
    steps = timetable.choreography.steps()
    latencies: dict[str, list[float]] = {step.kind.value: [] for step in steps}

    for row in rows:
        if not row.follows:
            continue
        followed_s = row.steps_s[int(row.follows.rpartition("_")[2]) - 1]
        for step, latency in zip(steps, row.steps_s[-1] - followed_s, strict=True):
            if np.isfinite(latency):
                latencies[step.kind.value].append(float(latency))

    return {kind: np.array(values) for kind, values in latencies.items() if values}


def _measure_iteration(
    series: dict[str, Series],
    config: SessionConfig,
    timetable: Timetable,
    iteration: int,
    msp: str,
    follows: list[str] | None,
) -> GroupSynchronyRow:
    """Measure one iteration; ``follows`` is None for a method that uses the events of all dancers."""
    tau_s = config.synchrony.tau_s
    one_to_one = config.synchrony.one_to_one
    paper = group_index(series, "paper", follows=follows, tau=tau_s, one_to_one=one_to_one)
    full = group_index(series, "full", tau=tau_s, one_to_one=one_to_one)

    steps_s = _step_times(series, timetable, iteration)
    has_robot = config.method != "none"
    return GroupSynchronyRow(
        iteration=iteration,
        graph=paper,
        gsi=paper.gsi,
        gsi_full_edges=full.gsi,
        msp=msp,
        follows=follows[0] if follows is not None and len(follows) == 1 else "",
        steps_s=steps_s,
        ta_s=timing_appropriateness(steps_s[-1], steps_s[:-1]) if has_robot else np.zeros(0),
    )


def _followed_in(followed: Sequence[Followed], iteration: int) -> list[str] | None:
    """Dancers whom the robot followed in an iteration; empty for nobody, None if the method logs no such rows."""
    persons = [item.person for item in followed if item.iteration == iteration]
    return [person for person in persons if person] if persons else None


def _series(events: Sequence[AgentEvent], agents: Sequence[str], iteration: int, start_s: float) -> dict[str, Series]:
    """Agent -> times since the iteration's beat 0 [s] and kinds of its events in the iteration."""
    by_agent: dict[str, list[AgentEvent]] = {agent: [] for agent in agents}
    for event in events:
        if event.iteration == iteration and event.agent in by_agent:
            by_agent[event.agent].append(event)

    return {
        agent: ([event.t_s - start_s for event in own], [event.kind for event in own])
        for agent, own in by_agent.items()
    }


def _step_times(series: dict[str, Series], timetable: Timetable, iteration: int) -> Array:
    """(A, K) time of each step by each agent since the iteration's beat 0 [s]; NaN where missing."""
    steps = timetable.choreography.steps()
    start_s = timetable.start_s(iteration)
    expected_s = np.array([timetable.time_s(iteration, step.beat) - start_s for step in steps])
    return np.array([match_to_steps(times, kinds, steps, expected_s) for times, kinds in series.values()])
