"""Curves of a recording (synchrony, delays, timing, clock errors) and its group topology graph."""

from __future__ import annotations

import numpy as np
import rerun as rr

from ...assets.colours import dancer_colour
from ...core import ROBOT
from .entity_stream import AMBER, GREY, EntityStream
from .explanation import STAGES, DelayReport, Graph
from .timeline import ORANGE, PURPLE, SKY_BLUE

PALETTE = ((165, 165, 165), (60, 150, 220), ORANGE, (0, 158, 115), PURPLE, (230, 159, 0), SKY_BLUE)
"""Colours of the curves of one plot, in order."""

POINT_PLOTS = ("timing", "clocks")
"""Plots whose values are drawn as points, since nothing lies between them."""

WIDE_CURVES = ("total", "gsi_full_edges")
"""Curves that are drawn wider than the others of their plot."""

LABELS = {
    "gsi": "paper's edges", "gsi_full_edges": "full edges", "gsi_truth": "true onsets, full edges",
    "total": "in all", "dancer": "followed dancer", "decision": "method", "wheels": "command to motion",
}  # fmt: skip
"""Curve -> its label in the legend, where it differs from the name of the curve."""

Curves = dict[str, tuple[list[float], list[float]]]
"""``PLOT/CURVE`` -> session times [s] and values."""


def send_curves(stream: EntityStream, report: DelayReport) -> None:
    """Send indices by iteration, delays and timing by step, and clock errors [ms] by event."""
    curve_counts: dict[str, int] = {}

    for name, (times_s, values) in _curves(report).items():
        plot, _, curve = name.partition("/")
        colour = _colour(plot, curve, curve_counts.get(plot, 0))
        curve_counts[plot] = curve_counts.get(plot, 0) + 1
        label = LABELS.get(curve, curve)

        if plot in POINT_PLOTS:
            style = rr.SeriesPoints(names=label, colors=[colour], markers="circle", marker_sizes=[3.0])
        else:
            style = rr.SeriesLines(names=label, colors=[colour], widths=[3.0 if curve in WIDE_CURVES else 1.5])
        stream.log_static(f"curves/{name}", style)
        stream.send_columns(f"curves/{name}", times_s, rr.Scalars.columns(scalars=values))


def log_static_graph(stream: EntityStream) -> None:
    """Log the style that the graphs of all iterations share."""
    agents = rr.Points2D.from_fields(radii=[9.0], show_labels=True, draw_order=60.0)
    pairs = rr.LineStrips2D.from_fields(colors=[GREY], show_labels=True, draw_order=40.0)
    follows = rr.Arrows2D.from_fields(colors=[AMBER], radii=[3.5], draw_order=50.0)

    stream.log_static("graph/agents", agents)
    stream.log_static("graph/pairs", pairs)
    stream.log_static("graph/follows", follows)


def send_graph(stream: EntityStream, graph: Graph) -> None:
    """Send the topology graph of one iteration, shown from the end of its window.

    Agents stand on a circle with their individual indices. The width of a line is the synchrony of its pair, and an
    arrow leads from the robot to the dancer it follows.
    """
    angles = np.pi / 2 + 2 * np.pi * np.arange(len(graph.agents)) / len(graph.agents)
    positions = np.stack([np.cos(angles), -np.sin(angles)], axis=1) * 100.0
    colours = [AMBER if name == ROBOT else dancer_colour(k) for k, name in enumerate(graph.agents)]
    labels = [f"{name} {value:.2f}" for name, value in zip(graph.agents, graph.individual, strict=True)]
    vertices = rr.Points2D.columns(positions=positions, colors=colours, labels=labels)
    stream.send_columns("graph/agents", [graph.t_s], vertices.partition([len(positions)]))

    pairs = [(i, j) for i in range(len(graph.agents)) for j in range(i) if graph.pairs[i, j] > 0]
    lines = rr.LineStrips2D.columns(
        strips=[[positions[i], positions[j]] for i, j in pairs],
        radii=[1.0 + 5.0 * float(graph.pairs[i, j]) for i, j in pairs],
        labels=[f"{graph.pairs[i, j]:.2f}" for i, j in pairs],
    )
    stream.send_columns("graph/pairs", [graph.t_s], lines.partition([len(pairs)]))

    # Without a followed dancer an empty row is sent, which removes the arrow of the iteration before.
    arrows = [(graph.agents.index(ROBOT), graph.agents.index(graph.follows))] if graph.follows else []
    origins = np.array([positions[a] for a, _ in arrows]).reshape(-1, 2)
    vectors = np.array([0.85 * (positions[b] - positions[a]) for a, b in arrows]).reshape(-1, 2)
    columns = rr.Arrows2D.columns(origins=origins, vectors=vectors)
    stream.send_columns("graph/follows", [graph.t_s], columns.partition([len(arrows)]))


def _curves(report: DelayReport) -> Curves:
    """Every curve of a report, without values that are not finite."""
    curves: Curves = {}

    for graph in report.graphs:
        for name in ("gsi", "gsi_full_edges", "gsi_truth"):
            _append(curves, f"group/{name}", graph.t_s, getattr(graph, name))
        for agent, value in zip(graph.agents, graph.individual, strict=True):
            _append(curves, f"individual/{agent}", graph.t_s, float(value))
        for i, first in enumerate(graph.agents):
            for j in range(i + 1, len(graph.agents)):
                _append(curves, f"pairs/{first}-{graph.agents[j]}", graph.t_s, float(graph.pairs[i, j]))

    for step in report.steps:
        _append(curves, "delay/total", step.t_s, step.late_s)
        for stage, part_s in zip(STAGES, step.parts_s, strict=True):
            _append(curves, f"delay/{stage}", step.t_s, part_s)

    for t_s, value in sorted(report.ta):
        _append(curves, "timing/appropriateness", t_s, value)

    for sensor, (times, errors) in report.clocks.items():
        for t_s, error_s in zip(times, errors, strict=True):
            _append(curves, f"clocks/{sensor}", float(t_s), float(error_s) * 1e3)

    return curves


def _colour(plot: str, curve: str, index: int) -> tuple[int, int, int]:
    """Colour of a curve: that of the agent where the curve belongs to one, else the next one of the palette."""
    if plot != "individual":
        return PALETTE[index % len(PALETTE)]
    return AMBER if curve == ROBOT else dancer_colour(index)


def _append(curves: Curves, name: str, t_s: float, value: float) -> None:
    """Append a value to a curve, unless it is not finite."""
    if np.isfinite(value):
        times, values = curves.setdefault(name, ([], []))
        times.append(t_s)
        values.append(value)
