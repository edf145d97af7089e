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
from ..anticipation.synchrony import GroupSynchrony, PairIndices, group_graph, most_synchronous_of, pair_indices
from ..anticipation.timing_appropriateness import lateness, match_to_steps
from ..choreography.timetable import Timetable
from ..config import SessionConfig
from ..core import ROBOT, Array, dancer_name
from ..core.session_log import AgentEvent, Decision, Followed


@dataclass(frozen=True, slots=True)
class GroupSynchronyRow:
    """Measures of one iteration from one set of events, logged or true.

    Attributes:
        iteration: number of the iteration.
        graph: the group topology graph under the paper's edges.
        gsi: group synchronisation index of that graph.
        gsi_full_edges: the index under all edges; it does not depend on the method, and so compares methods fairly.
        msp: the most synchronous person of this iteration.
        followed: the dancers whom the robot followed in this iteration; all of them for a method that uses everyone's
            events, and none without a robot.
        steps_s: (A, K) time of each step by each agent, dancers first, since the iteration's beat 0 [s]; NaN where an
            agent has no event for the step.
        late_s: (K,) time of each of the robot's steps minus the dancers' mean [s]; NaN where undefined. Empty without a
            robot.
    """

    iteration: int
    graph: GroupSynchrony
    gsi: float
    gsi_full_edges: float
    msp: str
    followed: tuple[str, ...]
    steps_s: Array
    late_s: Array

    @property
    def ta_s(self) -> Array:
        """(K,) timing appropriateness of each step: the absolute value of ``late_s`` [s].

        Source: iqbal2016, section VI-B.
        """
        return np.abs(self.late_s)

    @property
    def follows(self) -> str:
        """The dancer whom the robot followed; "" if it followed nobody, or several dancers."""
        return self.followed[0] if len(self.followed) == 1 else ""


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
        pairs = pair_indices(series, config.synchrony.tau_s, config.synchrony.one_to_one)
        msp = most_synchronous_of(pairs.first(len(dancers)), previous_msp).person

        # The rehearsal, iteration 0, is not measured.
        if iteration >= 1:
            follows = _followed_in(followed, iteration)
            rows.append(_measure_iteration(series, pairs, timetable, iteration, msp, follows))
        # An iteration without events has no most synchronous person, and leaves the earlier one.
        if any(len(series[name][1]) for name in dancers):
            previous_msp = msp

    return rows


def net_latencies(
    rows: Sequence[GroupSynchronyRow], timetable: Timetable, decisions: Sequence[Decision]
) -> dict[str, Array]:
    """Net latencies of all steps by event kind [s]; kinds without any are left out.

    Args:
        rows: from `group_metrics`.
        timetable: gives the steps of an iteration.
        decisions: the decision log.
    """
    steps = timetable.choreography.steps()
    latencies: dict[str, list[float]] = {step.kind.value: [] for step in steps}

    for row in rows:
        for step, latency_s in zip(steps, step_latencies(row, decisions), strict=True):
            if np.isfinite(latency_s):
                latencies[step.kind.value].append(float(latency_s))

    return {kind: np.array(values) for kind, values in latencies.items() if values}


def step_latencies(row: GroupSynchronyRow, decisions: Sequence[Decision]) -> Array:
    """Net latency of each step: time of the robot's event minus that of the dancer whose event triggered it.

    A step that a schedule triggered followed nobody, even while the robot follows a dancer, and has no net latency.

    Args:
        row: of one iteration, from `group_metrics`.
        decisions: the decision log, which names the dancer whose event led to the command of each step.

    Returns:
        (K,) net latencies [s]; NaN where the step followed nobody, or one of both events is missing.
    """
    latencies_s = np.full(row.steps_s.shape[1], np.nan)
    for item in decisions:
        if item.action == "sent" and item.iteration == row.iteration and item.person in row.graph.agents:
            followed_s = row.steps_s[row.graph.agents.index(item.person)]
            latencies_s[item.ordinal] = row.steps_s[-1, item.ordinal] - followed_s[item.ordinal]
    return latencies_s


def _measure_iteration(
    series: dict[str, Series],
    pairs: PairIndices,
    timetable: Timetable,
    iteration: int,
    msp: str,
    follows: list[str] | None,
) -> GroupSynchronyRow:
    """Measure one iteration; ``follows`` is None for a method that uses the events of all dancers."""
    paper = group_graph(pairs, "paper", follows=follows)
    full = group_graph(pairs, "full")

    steps_s = _step_times(series, timetable, iteration)
    has_robot = ROBOT in series
    dancers = [agent for agent in series if agent != ROBOT]
    return GroupSynchronyRow(
        iteration=iteration,
        graph=paper,
        gsi=paper.gsi,
        gsi_full_edges=full.gsi,
        msp=msp,
        followed=tuple(dancers if follows is None else follows) if has_robot else (),
        steps_s=steps_s,
        late_s=lateness(steps_s[-1], steps_s[:-1]) if has_robot else np.zeros(0),
    )


def _followed_in(followed: Sequence[Followed], iteration: int) -> list[str] | None:
    """Dancers whom the robot followed in an iteration; empty for nobody, None if the method logs no such rows."""
    persons = [item.person for item in followed if item.iteration == iteration]
    return [person for person in persons if person] if persons else None


def _series(events: Sequence[AgentEvent], agents: Sequence[str], iteration: int, start_s: float) -> dict[str, Series]:
    """Agent -> times since the iteration's beat 0 [s] and kinds of its events in the iteration."""
    series: dict[str, tuple[list[float], list[str]]] = {agent: ([], []) for agent in agents}
    for event in events:
        if event.iteration == iteration and event.agent in series:
            times_s, kinds = series[event.agent]
            times_s.append(event.t_s - start_s)
            kinds.append(event.kind)

    return dict(series)


def _step_times(series: dict[str, Series], timetable: Timetable, iteration: int) -> Array:
    """(A, K) time of each step by each agent since the iteration's beat 0 [s]; NaN where missing."""
    steps = timetable.choreography.steps()
    start_s = timetable.start_s(iteration)
    expected_s = np.array([timetable.time_s(iteration, step.beat) - start_s for step in steps])
    return np.array([match_to_steps(times, kinds, steps, expected_s) for times, kinds in series.values()])
