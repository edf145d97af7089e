"""What a recording shows beside the log: graphs, timing and delays, each with its time."""

from __future__ import annotations

import numpy as np

from ..anticipation.timing_appropriateness import ideal_times
from ..choreography.timetable import Timetable, timetable
from ..config.toml_file import from_plain
from ..core import Array, Event, Kind, MoveCommand, dancer_name
from ..core.session_log import AgentEvent, Decision, SessionLog
from ..record.rerun.explanation import STAGES, DelayReport, Graph, StepDelay
from .component_quality import clock_errors, mean_delay_s, sent_times
from .ground_truth_events import dancer_events, robot_events
from .group_metrics import GroupSynchronyRow, group_metrics

NAN = float("nan")
RECENT_S = 4.0
"""A command may answer an event no older than this."""


def delay_report(log: SessionLog) -> DelayReport:
    """Find everything that a recording shows beside the log.

    A session that was cut short has an report too; figures of what is missing are NaN.
    """
    config = from_plain(log.config)
    table = timetable(config)
    logged = [AgentEvent(e.iteration, e.person, e.kind, e.t_s) for e in log.events if not e.early]
    true = [*dancer_events(log.truth, log.cues, table), *robot_events(log.odometry, table)]
    rows = group_metrics([*logged, *log.robot_events], config, table, log.followed)
    true_rows = group_metrics(true, config, table, log.followed)
    sent_s = sent_times(log.events, log.device_events, mean_delay_s(config.network))
    latency_s = config.sensors.latency_frames / config.sensors.rate_hz
    return DelayReport(
        graphs=tuple(_graph(row, real, table) for row, real in zip(rows, true_rows, strict=True)),
        steps=_steps(log, true_rows, table, (latency_s, sent_s)) if config.method != "none" else (),
        ta=_ta(rows, table),
        clocks=clock_errors(log.events, sent_s),
    )


def _graph(row: GroupSynchronyRow, real: GroupSynchronyRow, table: Timetable) -> Graph:
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
        gsi_truth=real.gsi_full_edges,
    )


def _ta(rows: list[GroupSynchronyRow], table: Timetable) -> tuple[tuple[float, float], ...]:
    found = []
    for row in rows:
        for robot_s, value in zip(row.steps_s[-1], row.ta_s, strict=False):
            if np.isfinite(value):
                found.append((table.start_s(row.iteration) + float(robot_s), float(value)))
    return tuple(found)


def _steps(
    log: SessionLog, rows: list[GroupSynchronyRow], table: Timetable, way: tuple[float, Array]
) -> tuple[StepDelay, ...]:
    commands = {(order.iteration, order.ordinal): order for order in reversed(log.commands)}
    sent = {(item.iteration, item.ordinal): item for item in log.decisions if item.action == "sent"}
    last = {(item.iteration, item.ordinal): item for item in log.decisions}
    stories = []
    for row in rows:
        start_s = table.start_s(row.iteration)
        mean_s = start_s + ideal_times(row.steps_s[:-1])
        for step in table.choreography.steps():
            key = (row.iteration, step.ordinal)
            times_s = start_s + row.steps_s[:, step.ordinal]
            decision = sent.get(key)
            parts = _parts(log, key, commands.get(key), decision, times_s, float(mean_s[step.ordinal]), way)
            why = (decision or last.get(key) or _NOTHING).why
            follows = decision.person if decision is not None else ""
            stories.append(
                StepDelay(*key, step.kind, float(mean_s[step.ordinal]), float(times_s[-1]), follows, parts, why)
            )
    return tuple(story for story in stories if np.isfinite(story.t_s))


_NOTHING = Decision(NAN, 0, 0, Kind.CLAP, "", NAN, "", "no command was given")


def _parts(
    log: SessionLog,
    key: tuple[int, int],
    command: MoveCommand | None,
    decision: Decision | None,
    times_s: Array,
    mean_s: float,
    way: tuple[float, Array],
) -> tuple[float, ...]:
    """Where the time between the group's mean and the robot's motion went; see `record.rerun.explanation.STAGES`.

    ``way`` is the sensors' latency [s], and when each of the log's events was sent [s].
    """
    latency_s, all_sent_s = way
    if command is None or decision is None:
        return (NAN,) * len(STAGES)
    wheels = float(times_s[-1]) - command.t_start_s
    index = next((k for k in range(len(times_s) - 1) if dancer_name(k) == decision.person), None)
    answered = _answered(log.events, decision, command)
    event = None if answered is None else log.events[answered]
    sent_s = NAN if answered is None else float(all_sent_s[answered])
    if index is None or event is None or not np.isfinite(sent_s + times_s[index]):
        return (NAN, NAN, NAN, NAN, command.t_start_s - mean_s, wheels)
    onset_s = float(times_s[index])
    return (
        onset_s - mean_s,
        latency_s,
        sent_s - latency_s - onset_s,
        event.t_arrival_s - sent_s,
        command.t_start_s - event.t_arrival_s,
        wheels,
    )


def _answered(events: tuple[Event, ...], decision: Decision, command: MoveCommand) -> int | None:
    """Row of the newest event of the followed dancer that the method knew when it sent the command."""
    known = [
        row
        for row, event in enumerate(events)
        if (event.person, event.kind) == (decision.person, decision.kind)
        and command.t_start_s - RECENT_S <= event.t_arrival_s <= command.t_start_s + 1e-9
    ]
    return max(known, key=lambda row: events[row].t_arrival_s, default=None)
