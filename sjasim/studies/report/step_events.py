"""Events of a session arranged by step: what was logged for each step of each agent, and what is missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...analysis.session_metrics import logged_events
from ...anticipation.timing_appropriateness import ideal_times, match_to_steps
from ...choreography.timetable import Timetable
from ...config import HUMANS_ONLY, SessionConfig
from ...core import ROBOT, Array, Kind, Move, dancer_name
from ...core.session_log import AgentEvent, SessionLog

LOGGED = "logged"
"""Status of a step for which an event was logged."""

NOT_LOGGED = "not logged"
"""Status of a step that a dancer performed without an event that was logged."""

NOT_PERFORMED = "not performed"
"""Status of a step that an agent did not perform."""


@dataclass(frozen=True, slots=True)
class StepEvent:
    """What is known of one step of one agent.

    Attributes:
        agent: dancer or robot.
        ordinal: index of the step in the iteration.
        kind: kind of the step; a robot turns where it is CLAP.
        t_s: time since the iteration's beat 0 [s]; of a missing event the time at which it was due.
        status: `LOGGED`, `NOT_LOGGED` or `NOT_PERFORMED`.
    """

    agent: str
    ordinal: int
    kind: Kind
    t_s: float
    status: str


@dataclass(frozen=True, slots=True)
class IterationEvents:
    """Events of one iteration.

    Attributes:
        iteration: its number; 0 is the rehearsal.
        agents: dancers in order, then the robot if there is one.
        steps: one entry per agent and step.
        extra: logged events that belong to no step, with times since the iteration's beat 0 [s].
        beats_s: nominal time of each step [s].
        length_s: time from beat 0 until the iteration's window closes [s].
    """

    iteration: int
    agents: tuple[str, ...]
    steps: tuple[StepEvent, ...]
    extra: tuple[AgentEvent, ...]
    beats_s: tuple[float, ...]
    length_s: float


def iteration_events(log: SessionLog, config: SessionConfig, table: Timetable) -> list[IterationEvents]:
    """Events of every iteration, the rehearsal included.

    Args:
        log: the session.
        config: its configuration.
        table: its timetable.
    """
    dancers = tuple(dancer_name(index) for index in range(config.dancers))
    logged = logged_events(log)
    performed = _performed_times(log)

    found = []
    for iteration in range(table.first, table.last + 1):
        # In the rehearsal the robot stands still, so that it misses nothing.
        has_robot = config.method != HUMANS_ONLY and iteration > 0
        agents = (*dancers, ROBOT) if has_robot else dancers
        own = [event for event in logged if event.iteration == iteration]
        found.append(_one_iteration(iteration, agents, own, performed, table))
    return found


def count_missing(iterations: Sequence[IterationEvents], agent_is_robot: bool) -> dict[str, int]:
    """Number of steps by status, of the robot or of all dancers."""
    steps = [step for item in iterations for step in item.steps if (step.agent == ROBOT) == agent_is_robot]
    return {status: sum(step.status == status for step in steps) for status in (LOGGED, NOT_LOGGED, NOT_PERFORMED)}


def _one_iteration(
    iteration: int,
    agents: tuple[str, ...],
    logged: Sequence[AgentEvent],
    performed: Mapping[tuple[str, int, int], float],
    table: Timetable,
) -> IterationEvents:
    """Match the logged events of one iteration to its steps."""
    steps = table.choreography.steps()
    start_s = table.start_s(iteration)
    beats_s = np.array([table.time_s(iteration, step.beat) - start_s for step in steps])

    matched_s: dict[str, Array] = {}
    extra: list[AgentEvent] = []
    for agent in agents:
        own = [event for event in logged if event.agent == agent]
        times_s = [event.t_s - start_s for event in own]
        matched_s[agent] = match_to_steps(times_s, [event.kind for event in own], steps, beats_s)
        spare = [event for event, t_s in zip(own, times_s, strict=True) if t_s not in matched_s[agent]]
        extra += [AgentEvent(iteration, agent, event.kind, event.t_s - start_s) for event in spare]

    # A step that the robot missed was due when the dancers performed it.
    ideal_s = ideal_times(np.array([matched_s[agent] for agent in agents if agent != ROBOT]))
    due_s = np.where(np.isfinite(ideal_s), ideal_s, beats_s)
    entries = []
    for agent in agents:
        for step in steps:
            known_s = performed.get((agent, iteration, step.ordinal))
            planned_s = due_s[step.ordinal] if known_s is None else known_s - start_s
            t_s = matched_s[agent][step.ordinal]
            if np.isfinite(t_s):
                entries.append(StepEvent(agent, step.ordinal, step.kind, float(t_s), LOGGED))
                continue
            status = NOT_PERFORMED if known_s is None else NOT_LOGGED
            entries.append(StepEvent(agent, step.ordinal, step.kind, float(planned_s), status))
    return IterationEvents(
        iteration, agents, tuple(entries), tuple(extra), tuple(beats_s.tolist()), table.close_s(iteration) - start_s
    )


def _performed_times(log: SessionLog) -> dict[tuple[str, int, int], float]:
    """(dancer, iteration, ordinal) -> session time at which the dancer performed the step [s]."""
    times: dict[tuple[str, int, int], float] = {}
    for cue in log.cues:
        # A turn shares the ordinal of its clap, and has no event of its own.
        if cue.move is Move.TURN:
            continue
        times[cue.dancer, cue.iteration, cue.ordinal] = cue.t_s
        if cue.duration_s > 0.0:
            times[cue.dancer, cue.iteration, cue.ordinal + 1] = cue.t_s + cue.duration_s
    return times
