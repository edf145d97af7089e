"""Splits the robot's delay behind the group into its parts, step by step, and collects what a recording shows.

The result types, and the sentences about them, are in `record.rerun.explanation`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..anticipation.timing_appropriateness import ideal_times
from ..choreography.timetable import Timetable, timetable
from ..config import SessionConfig
from ..config.toml_file import from_plain
from ..core import Array, Event, MoveCommand, dancer_name
from ..core.session_log import Decision, SessionLog
from ..record.rerun.explanation import STAGES, DelayReport, Graph, StepDelay
from .component_quality import clock_errors, mean_delay_s, sent_times
from .group_metrics import GroupSynchronyRow, group_metrics
from .session_metrics import logged_events, true_events

NAN = float("nan")

RECENT_S = 4.0
"""Largest age of an event that can be the cause of a command [s]."""

NO_COMMAND = "no command was given"
"""Reason for a step without any decision in the log."""

StepKey = tuple[int, int]
"""Iteration and ordinal of a step."""


@dataclass(frozen=True, slots=True)
class _Evidence:
    """Entries of the log from which the causes of the robot's steps are determined.

    Attributes:
        events: the log's events.
        sent_s: (N,) true time at which each event was sent [s].
        latency_s: time from a frame's capture to the end of its processing [s].
        commands: the first command for each step.
        sent: the last decision to send a command for each step.
        last: the last decision of any sort for each step.
    """

    events: Sequence[Event]
    sent_s: Array
    latency_s: float
    commands: Mapping[StepKey, MoveCommand]
    sent: Mapping[StepKey, Decision]
    last: Mapping[StepKey, Decision]


def delay_report(log: SessionLog) -> DelayReport:
    """Compute everything that a recording shows beside the log.

    Args:
        log: the session; a log of a session that was cut short is allowed, and what it lacks is NaN.
    """
    config = from_plain(log.config)
    table = timetable(config)
    true_dancers, true_robot = true_events(log, table)
    rows = group_metrics(logged_events(log), config, table, log.followed)
    true_rows = group_metrics([*true_dancers, *true_robot], config, table, log.followed)

    sent_s = sent_times(log.events, log.device_events, mean_delay_s(config.network))
    has_robot = config.method != "none"
    return DelayReport(
        graphs=tuple(_graph(row, true_row, table) for row, true_row in zip(rows, true_rows, strict=True)),
        steps=_step_delays(_evidence(log, config, sent_s), true_rows, table) if has_robot else (),
        ta=_timing(rows, table),
        clocks=clock_errors(log.events, sent_s),
    )


def _graph(row: GroupSynchronyRow, true_row: GroupSynchronyRow, table: Timetable) -> Graph:
    """The topology graph of one iteration from logged events, with the index from true ones beside it."""
    graph = row.graph
    return Graph(
        t_s=table.close_s(row.iteration),
        iteration=row.iteration,
        agents=graph.agents,
        pairs=graph.pairs,
        edges=graph.edges.astype(np.float64),
        individual=graph.individual,
        follows=row.follows,
        gsi=row.gsi,
        gsi_full_edges=row.gsi_full_edges,
        gsi_truth=true_row.gsi_full_edges,
    )


def _timing(rows: Sequence[GroupSynchronyRow], table: Timetable) -> tuple[tuple[float, float], ...]:
    """Session time and timing appropriateness of every step of the robot that has one [s]."""
    found = []
    for row in rows:
        start_s = table.start_s(row.iteration)
        # Without a robot, ta_s is empty.
        for robot_s, value in zip(row.steps_s[-1], row.ta_s, strict=False):
            if np.isfinite(value):
                found.append((start_s + float(robot_s), float(value)))
    return tuple(found)


def _evidence(log: SessionLog, config: SessionConfig, sent_s: Array) -> _Evidence:
    """Index the log by step."""
    # Commands are indexed in reverse, so that the first one for a step replaces its repetitions; of decisions, the last
    # one for a step is kept.
    return _Evidence(
        events=log.events,
        sent_s=sent_s,
        latency_s=config.sensors.latency_frames / config.sensors.rate_hz,
        commands={(item.iteration, item.ordinal): item for item in reversed(log.commands)},
        sent={(item.iteration, item.ordinal): item for item in log.decisions if item.action == "sent"},
        last={(item.iteration, item.ordinal): item for item in log.decisions},
    )


def _step_delays(evidence: _Evidence, rows: Sequence[GroupSynchronyRow], table: Timetable) -> tuple[StepDelay, ...]:
    """Delay of every step that the dancers performed.

    Args:
        evidence: commands, decisions and events of the log.
        rows: measures of the true events.
        table: timetable of the session.
    """
    delays = []
    for row in rows:
        start_s = table.start_s(row.iteration)
        mean_s = start_s + ideal_times(row.steps_s[:-1])

        for step in table.choreography.steps():
            if not np.isfinite(mean_s[step.ordinal]):
                continue

            key = (row.iteration, step.ordinal)
            sent = evidence.sent.get(key)
            reason = sent or evidence.last.get(key)
            onsets_s = start_s + row.steps_s[:, step.ordinal]
            delay = StepDelay(
                iteration=row.iteration,
                ordinal=step.ordinal,
                kind=step.kind,
                t_s=float(mean_s[step.ordinal]),
                robot_s=float(onsets_s[-1]),
                follows=sent.person if sent is not None else "",
                parts_s=_parts(evidence, key, onsets_s, float(mean_s[step.ordinal])),
                why=reason.why if reason is not None else NO_COMMAND,
            )
            delays.append(delay)
    return tuple(delays)


def _parts(evidence: _Evidence, key: StepKey, onsets_s: Array, mean_s: float) -> tuple[float, ...]:
    """Duration of each of `record.rerun.explanation.STAGES` [s]; NaN where it does not apply.

    Args:
        evidence: commands, decisions and events of the log.
        key: the step.
        onsets_s: (A,) true onsets of the dancers and, last, the robot, session time [s].
        mean_s: mean of the dancers' onsets, session time [s].
    """
    command = evidence.commands.get(key)
    decision = evidence.sent.get(key)
    if command is None or decision is None:
        return (NAN,) * len(STAGES)

    wheels_s = float(onsets_s[-1]) - command.t_start_s
    dancer = next((k for k in range(len(onsets_s) - 1) if dancer_name(k) == decision.person), None)
    answered = _answered_event(evidence.events, decision, command)

    # Without a followed dancer or its event, everything before the command counts as the decision's part.
    unknown = (NAN, NAN, NAN, NAN, command.t_start_s - mean_s, wheels_s)
    if dancer is None or answered is None:
        return unknown
    onset_s = float(onsets_s[dancer])
    sent_s = float(evidence.sent_s[answered])
    if not np.isfinite(sent_s + onset_s):
        return unknown

    arrival_s = evidence.events[answered].t_arrival_s
    return (
        onset_s - mean_s,
        evidence.latency_s,
        sent_s - evidence.latency_s - onset_s,
        arrival_s - sent_s,
        command.t_start_s - arrival_s,
        wheels_s,
    )


def _answered_event(events: Sequence[Event], decision: Decision, command: MoveCommand) -> int | None:
    """Index of the newest event of the followed dancer that had arrived when the command was sent."""
    # A method may send a command at the very time at which the event arrives.
    known = [
        row
        for row, event in enumerate(events)
        if (event.person, event.kind) == (decision.person, decision.kind)
        and command.t_start_s - RECENT_S <= event.t_arrival_s <= command.t_start_s + 1e-9
    ]
    return max(known, key=lambda row: events[row].t_arrival_s, default=None)
