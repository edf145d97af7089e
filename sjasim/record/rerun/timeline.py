"""What happened when, in a recording: lanes of states, curves, the group's graph and texts, on the session's clock."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr

from ...assets.colours import dancer_colour
from ...choreography.timetable import timetable
from ...config import SessionConfig
from ...core import ROBOT, Kind, Move, dancer_name
from ...core.session_log import SessionLog
from .explanation import STAGES, DelayReport, Graph, as_markdown, classify_step
from .scene import AMBER, GREEN, GREY, RED, Pen, Span

BLUE, ORANGE, PURPLE, SKY = (0, 114, 178), (213, 94, 0), (204, 121, 167), (86, 180, 233)
NOTHING = "-"
"""The state of a lane in which nothing is shown."""

STATES = {
    "forward": BLUE, "backward": ORANGE, "clap": PURPLE, "turn": PURPLE, "stop": GREY,
    NOTHING: GREY, "on time": GREEN, "late": RED, "early": AMBER, "missed": (60, 0, 0),
    **{f"early {word}": SKY for word in ("forward", "stop", "backward", "clap")},
}  # fmt: skip
"""What lanes show, with its colour."""

MOVING = {
    Kind.START_FORWARD: "forward", Kind.STOP_FORWARD: "stop", Kind.START_BACKWARD: "backward",
    Kind.STOP_BACKWARD: "stop", Kind.CLAP: "clap", Kind.TURN: "turn",
}  # fmt: skip
BLINK_S = 0.5
"""How long a lane shows what has no end of its own."""

Mark = tuple[float, float, str]
"""From when to when, and what."""


def lane_names(config: SessionConfig) -> list[str]:
    """Every lane, from top to bottom."""
    lanes = ["iteration", "active_sensor"]
    for index in range(config.dancers):
        lanes += [f"{dancer_name(index)}/{part}" for part in ("planned", "seen")]
    return (
        lanes if config.method == "none" else [*lanes, "robot/follows", "robot/command", "robot/moved", "robot/timing"]
    )


def send_lanes(pen: Pen, log: SessionLog, config: SessionConfig, span: Span) -> None:
    """Iterations, active sensor, and of every agent what it planned, was seen to do, was told to do and did."""
    table = timetable(config)
    marks: dict[str, list[Mark]] = {
        "iteration": [
            (table.start_s(k), table.start_s(k + 1), f"iteration {k}" if k else "rehearsal")
            for k in range(table.first, table.last + 1)
        ],
        "active_sensor": [(item.t_s, np.inf, item.sensor) for item in log.handovers],
    }
    for cue in log.cues:
        end = cue.t_s + (cue.duration_s or BLINK_S)
        marks.setdefault(f"{cue.dancer}/planned", []).append((cue.t_s, end, cue.move.value))
    for event in sorted(log.events, key=lambda item: item.t_s):
        if event.early:
            mark = (event.t_s, event.t_s + BLINK_S, f"early {MOVING[event.kind]}")
            marks.setdefault(f"{event.person}/seen", []).append(mark)
        else:
            marks.setdefault(f"{event.person}/seen", []).append(_mark(event.t_s, event.kind))
    for deed in log.robot_events:
        marks.setdefault("robot/moved", []).append(_mark(deed.t_s, deed.kind))
    for order in log.commands:
        end = order.t_start_s + BLINK_S if order.move in (Move.STOP, Move.TURN) else np.inf
        marks.setdefault("robot/command", []).append((order.t_start_s, end, order.move.value))
    for name, found in marks.items():
        send_lane(pen, name, found, span)


def _mark(t_s: float, kind: Kind) -> Mark:
    return (t_s, np.inf if kind in (Kind.START_FORWARD, Kind.START_BACKWARD) else t_s + BLINK_S, MOVING[kind])


def send_lane(pen: Pen, name: str, marks: Sequence[Mark], span: Span) -> None:
    """One lane; a mark ends at its end or where the next begins."""
    inside = [mark for mark in sorted(marks) if span.since_s < mark[0] <= span.until_s]
    times: list[float] = []
    states: list[str] = []
    for place, (begin, end, state) in enumerate(inside):
        times.append(begin)
        states.append(state)
        following = inside[place + 1][0] if place + 1 < len(inside) else np.inf
        if end < following - 1e-6:
            times.append(end)
            states.append(NOTHING)
    if times:
        pen.columns(f"lanes/{name}", times, rr.StateChange.columns(state=states))


def fix_lanes(pen: Pen, config: SessionConfig) -> None:
    """Colours of the lanes' states."""
    dancers = {dancer_name(index): dancer_colour(index) for index in range(config.dancers)}
    known = {**STATES, **dancers, "nobody": GREY}
    for name in lane_names(config):
        values = list(known)
        if name in ("iteration", "active_sensor"):
            values = [NOTHING]
        shown = [value != NOTHING for value in values]
        style = rr.StateConfiguration(values=values, colors=[known[value] for value in values], visible=shown)
        pen.fixed(f"lanes/{name}", style)


def send_report(pen: Pen, report: DelayReport, config: SessionConfig) -> None:
    """Whom the robot followed, how late it was, curves, graphs and the story in words."""
    table = timetable(config)
    follows = [
        (table.start_s(graph.iteration), table.close_s(graph.iteration), graph.follows or "nobody")
        for graph in report.graphs
        if ROBOT in graph.agents
    ]
    send_lane(pen, "robot/follows", follows, Span())
    timing: list[Mark] = []
    for step in report.steps:
        ends = sorted((step.t_s, step.robot_s)) if np.isfinite(step.robot_s) else [step.t_s, step.t_s + 1.0]
        timing.append((ends[0], max(ends[1], ends[0] + 0.15), classify_step(step)))
    send_lane(pen, "robot/timing", timing, Span())
    send_curves(pen, report)
    fix_graph(pen)
    for graph in report.graphs:
        send_graph(pen, graph)
    pen.fixed("story", rr.TextDocument(as_markdown(report), media_type=rr.MediaType.MARKDOWN))


def send_curves(pen: Pen, report: DelayReport) -> None:
    """Indices by iteration, timing and its parts by step, clock errors by event."""
    curves: dict[str, tuple[list[float], list[float]]] = {}
    for graph in report.graphs:
        for name in ("gsi", "gsi_full_edges", "gsi_truth"):
            _add(curves, f"group/{name}", graph.t_s, getattr(graph, name))
        for i, first in enumerate(graph.agents):
            for j in range(i + 1, len(graph.agents)):
                _add(curves, f"pairs/{first}-{graph.agents[j]}", graph.t_s, float(graph.pairs[i, j]))
    for step in report.steps:
        _add(curves, "delay/total", step.t_s, step.late_s)
        for stage, part in zip(STAGES, step.parts_s, strict=True):
            _add(curves, f"delay/{stage}", step.t_s, part)
    for t_s, value in sorted(report.ta):
        _add(curves, "timing/appropriateness", t_s, value)
    for sensor, (times, errors) in report.clocks.items():
        for t_s, error in zip(times, errors, strict=True):
            _add(curves, f"clocks/{sensor}", float(t_s), float(error) * 1e3)
    palette = ((165, 165, 165), (60, 150, 220), ORANGE, (0, 158, 115), PURPLE, (230, 159, 0), SKY)
    counts: dict[str, int] = {}
    for name, (times_s, values) in curves.items():
        group, _, label = name.partition("/")
        colour = palette[counts.get(group, 0) % len(palette)]
        counts[group] = counts.get(group, 0) + 1
        dots = group in ("timing", "clocks")
        dot = rr.SeriesPoints(names=label, colors=[colour], markers="circle", marker_sizes=[3.0])
        line = rr.SeriesLines(names=label, colors=[colour], widths=[3.0 if label in ("total", "gsi") else 1.5])
        pen.fixed(f"curves/{name}", dot if dots else line)
        pen.columns(f"curves/{name}", times_s, rr.Scalars.columns(scalars=values))


def _add(curves: dict[str, tuple[list[float], list[float]]], name: str, t_s: float, value: float) -> None:
    if np.isfinite(value):
        times, values = curves.setdefault(name, ([], []))
        times.append(t_s)
        values.append(value)


def send_graph(pen: Pen, graph: Graph) -> None:
    """The topology graph, from the close of its iteration on.

    Agents stand on a circle with their individual indices, lines are as wide as their pairs are synchronous, and an
    arrow leads from the robot to whom it follows.
    """
    angles = np.pi / 2 + 2 * np.pi * np.arange(len(graph.agents)) / len(graph.agents)
    places = np.stack([np.cos(angles), -np.sin(angles)], axis=1) * 100.0
    colours = [AMBER if name == ROBOT else dancer_colour(k) for k, name in enumerate(graph.agents)]
    labels = [f"{name} {value:.2f}" for name, value in zip(graph.agents, graph.individual, strict=True)]
    nodes = rr.Points2D.columns(positions=places, colors=colours, labels=labels)
    pen.columns("graph/agents", [graph.t_s], nodes.partition([len(places)]))
    pairs = [(i, j) for i in range(len(graph.agents)) for j in range(i) if graph.pairs[i, j] > 0]
    edges = rr.LineStrips2D.columns(
        strips=[[places[i], places[j]] for i, j in pairs],
        radii=[1.0 + 5.0 * float(graph.pairs[i, j]) for i, j in pairs],
        labels=[f"{graph.pairs[i, j]:.2f}" for i, j in pairs],
    )
    pen.columns("graph/pairs", [graph.t_s], edges.partition([len(pairs)]))
    ways = [(graph.agents.index(ROBOT), graph.agents.index(graph.follows))] if graph.follows else []
    origins = np.array([places[a] for a, _ in ways]).reshape(-1, 2)
    vectors = np.array([0.85 * (places[b] - places[a]) for a, b in ways]).reshape(-1, 2)
    arrow = rr.Arrows2D.columns(origins=origins, vectors=vectors)
    pen.columns("graph/follows", [graph.t_s], arrow.partition([len(ways)]))


def fix_graph(pen: Pen) -> None:
    """What all graphs share."""
    pen.fixed("graph/agents", rr.Points2D.from_fields(radii=[9.0], show_labels=True, draw_order=60.0))
    pen.fixed("graph/pairs", rr.LineStrips2D.from_fields(colors=[GREY], show_labels=True, draw_order=40.0))
    pen.fixed("graph/follows", rr.Arrows2D.from_fields(colors=[AMBER], radii=[3.5], draw_order=50.0))


def send_texts(pen: Pen, log: SessionLog, span: Span) -> None:
    """The method's decisions and what went wrong, as text."""
    decisions = [
        (
            item.t_s,
            f"{item.action} {item.kind.value} ({item.iteration}.{item.ordinal + 1}): {item.why}",
            "INFO" if item.action == "sent" else "DEBUG",
        )
        for item in log.decisions
    ]
    notices = [(item.t_s, f"{item.source}: {item.what}", "WARN") for item in log.notices]
    for entity, lines in (("log/decisions", decisions), ("log/notices", notices)):
        inside = [line for line in lines if span.since_s < line[0] <= span.until_s]
        if inside:
            columns = rr.TextLog.columns(text=[line[1] for line in inside], level=[line[2] for line in inside])
            pen.columns(entity, [line[0] for line in inside], columns)
