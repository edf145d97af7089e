"""Lanes of a recording, which show events and states over time as coloured bars, and its text logs.

To add a lane: name it in `lane_names`, and return its marks from `_log_marks` (known while the session runs) or
`_report_marks` (known once it is over). A state with a colour of its own is an entry of `STATE_COLOURS`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import rerun as rr

from ...assets.colours import dancer_colour
from ...choreography.timetable import timetable
from ...config import SessionConfig
from ...core import Kind, Move, dancer_name
from ...core.session_log import SessionLog
from .entity_stream import AMBER, GREEN, GREY, RED, EntityStream, Span
from .explanation import DelayReport, classify_step

BLUE = (0, 114, 178)
ORANGE = (213, 94, 0)
PURPLE = (204, 121, 167)
SKY_BLUE = (86, 180, 233)
DARK_RED = (60, 0, 0)

NO_STATE = "-"
"""State of a lane that shows nothing."""

BRIEF = " (brief)"
"""End of the name of a state whose bar is too short for its label; the viewer would cut the label."""

PIXELS_PER_S = 58.0
"""Width of a second of session time in the lanes, in a viewer of 1920 pixels [1/s]; see `blueprint`."""

LETTER_PIXELS = 7.0
LABEL_MARGIN_PIXELS = 8.0
"""Mean width of a letter of a label, and what the viewer leaves free beside the label; measured."""

STATE_COLOURS = {
    "forward": BLUE, "backward": ORANGE, "clap": PURPLE, "turn": PURPLE, "stop": GREY,
    NO_STATE: GREY, "on time": GREEN, "late": RED, "early": AMBER, "missed": DARK_RED,
    **{f"early {word}": SKY_BLUE for word in ("forward", "stop", "backward", "clap")},
}  # fmt: skip
"""State that a lane shows -> its colour."""

EVENT_STATES = {
    Kind.START_FORWARD: "forward", Kind.STOP_FORWARD: "stop", Kind.START_BACKWARD: "backward",
    Kind.STOP_BACKWARD: "stop", Kind.CLAP: "clap", Kind.TURN: "turn",
}  # fmt: skip
"""Kind of an event -> state that it begins."""

MOMENT_S = 0.65
"""Length of a bar that stands for a moment, which leaves space for a word of four letters [s]."""

SHORTEST_BAR_S = 0.15
"""Length of the bar for a robot that is exactly on time, so that it can be seen [s]."""

Mark = tuple[float, float, str]
"""Begin and end in session time [s], and state; an infinite end lasts until the next mark of the lane."""


def lane_names(config: SessionConfig) -> list[str]:
    """Names of all lanes, from top to bottom."""
    # The viewer sorts lanes by name, and "dance" stands before "dancer_1".
    lanes = ["dance/active_sensor", "dance/iteration"]
    for index in range(config.dancers):
        lanes += [f"{dancer_name(index)}/planned", f"{dancer_name(index)}/seen"]
    if config.method != "none":
        lanes += ["robot/follows", "robot/command", "robot/moved", "robot/timing"]
    return lanes


def log_static_lanes(stream: EntityStream, config: SessionConfig) -> None:
    """Log the colours of every lane's states."""
    dancers = {dancer_name(index): dancer_colour(index) for index in range(config.dancers)}
    colours = {**STATE_COLOURS, **dancers, "nobody": GREY, "everyone": GREY, "several": GREY}

    for name in lane_names(config):
        # Iterations and sensors get the viewer's own colours, since their states have no fixed names.
        states = [NO_STATE] if name.startswith("dance/") else list(colours)
        style = rr.StateConfiguration(
            values=[*states, *(f"{state}{BRIEF}" for state in states)],
            labels=[*states, *(" " for _ in states)],
            colors=2 * [colours[state] for state in states],
            visible=2 * [state != NO_STATE for state in states],
        )
        stream.log_static(f"lanes/{name}", style)


def send_lanes(stream: EntityStream, log: SessionLog, config: SessionConfig, span: Span) -> None:
    """Send the lanes that are known while the session runs, as far as their marks begin in an interval."""
    for name, marks in _log_marks(log, config).items():
        _send_lane(stream, name, marks, span)


def send_report_lanes(stream: EntityStream, report: DelayReport, config: SessionConfig) -> None:
    """Send the lanes that are known once the session is over."""
    for name, marks in _report_marks(report, config).items():
        _send_lane(stream, name, marks, Span())


def send_texts(stream: EntityStream, log: SessionLog, span: Span) -> None:
    """Send the method's decisions and the notices of an interval as text logs."""
    decisions = [
        (
            decision.t_s,
            f"{decision.action} {decision.kind.value} ({decision.iteration}.{decision.ordinal + 1}): {decision.why}",
            "INFO" if decision.action == "sent" else "DEBUG",
        )
        for decision in log.decisions
    ]
    notices = [(notice.t_s, f"{notice.source}: {notice.what}", "WARN") for notice in log.notices]

    for entity, lines in (("log/decisions", decisions), ("log/notices", notices)):
        inside = [line for line in lines if span.contains(line[0])]
        if inside:
            columns = rr.TextLog.columns(text=[text for _, text, _ in inside], level=[level for _, _, level in inside])
            stream.send_columns(entity, [t_s for t_s, _, _ in inside], columns)


def _log_marks(log: SessionLog, config: SessionConfig) -> Mapping[str, Sequence[Mark]]:
    """Lane -> marks of iterations, active sensor, planned moves, logged events and commands."""
    table = timetable(config)
    iterations = range(table.first, table.last + 1)
    marks: dict[str, list[Mark]] = {
        "dance/iteration": [
            (table.start_s(k), table.start_s(k + 1), f"iteration {k}" if k else "rehearsal") for k in iterations
        ],
        "dance/active_sensor": [(handover.t_s, np.inf, handover.sensor) for handover in log.handovers],
    }

    for cue in log.cues:
        end_s = cue.t_s + (cue.duration_s or MOMENT_S)
        marks.setdefault(f"{cue.dancer}/planned", []).append((cue.t_s, end_s, cue.move.value))

    for event in sorted(log.events, key=lambda item: item.t_s):
        mark = _event_mark(event.t_s, event.kind)
        if event.early:
            mark = (event.t_s, event.t_s + MOMENT_S, f"early {EVENT_STATES[event.kind]}")
        marks.setdefault(f"{event.person}/seen", []).append(mark)

    for robot_event in log.robot_events:
        marks.setdefault("robot/moved", []).append(_event_mark(robot_event.t_s, robot_event.kind))

    for command in log.commands:
        is_moment = command.move in (Move.STOP, Move.TURN)
        end_s = command.t_start_s + MOMENT_S if is_moment else np.inf
        marks.setdefault("robot/command", []).append((command.t_start_s, end_s, command.move.value))

    return marks


def _report_marks(report: DelayReport, config: SessionConfig) -> Mapping[str, Sequence[Mark]]:
    """Lane -> marks of the followed dancer, and of every step's timing, from the dancers' time to the robot's."""
    table = timetable(config)
    follows = [
        (table.start_s(graph.iteration), table.close_s(graph.iteration), graph.followed)
        for graph in report.graphs
        if graph.followed
    ]

    timing: list[Mark] = []
    for step in report.steps:
        end_s = step.robot_s if np.isfinite(step.robot_s) else step.t_s + 1.0
        first, last = sorted((step.t_s, end_s))
        timing.append((first, max(last, first + SHORTEST_BAR_S), classify_step(step)))

    return {"robot/follows": follows, "robot/timing": timing}


def _event_mark(t_s: float, kind: Kind) -> Mark:
    """Mark of a regular event: a start lasts until the next mark, anything else is a moment."""
    is_start = kind in (Kind.START_FORWARD, Kind.START_BACKWARD)
    return (t_s, np.inf if is_start else t_s + MOMENT_S, EVENT_STATES[kind])


def _send_lane(stream: EntityStream, name: str, marks: Iterable[Mark], span: Span) -> None:
    """Send the marks of one lane that begin in an interval; a mark ends at its end or where the next one begins.

    A mark that is too short for its label gets the state's brief variant, which has no label.
    """
    inside = [mark for mark in sorted(marks) if span.contains(mark[0])]
    times: list[float] = []
    states: list[str] = []

    for index, (begin_s, end_s, state) in enumerate(inside):
        next_begin_s = inside[index + 1][0] if index + 1 < len(inside) else np.inf
        times.append(begin_s)
        states.append(state if _has_space(state, min(end_s, next_begin_s) - begin_s) else f"{state}{BRIEF}")
        # A mark that ends where the next one begins needs no end: states replace one another.
        if end_s < next_begin_s - 1e-6:
            times.append(end_s)
            states.append(NO_STATE)

    if times:
        stream.send_columns(f"lanes/{name}", times, rr.StateChange.columns(state=states))


def _has_space(label: str, length_s: float) -> bool:
    """Whether a bar of a length is long enough for its label."""
    return LETTER_PIXELS * len(label) + LABEL_MARGIN_PIXELS <= PIXELS_PER_S * length_s
