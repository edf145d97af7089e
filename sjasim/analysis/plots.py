"""Figures of a session: what everyone did in an iteration, the robot's timing, the group's graph, delays by part."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..assets.colours import ROBOT as ROBOT_COLOUR
from ..assets.colours import dancer_colour
from ..choreography.timetable import Timetable, timetable
from ..config import SessionConfig
from ..config.toml_file import from_plain
from ..core import ROBOT, Array, Kind, Move, dancer_name
from ..core.errors import RecordError
from ..core.session_log import SessionLog
from ..record.rerun.explanation import STAGES, DelayReport, Graph
from .ground_truth_events import dancer_events, robot_events

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FILES = ("raster.png", "timing.png", "graph.png", "delays.png")
MARKERS = {
    Kind.START_FORWARD: (">", "start forward"), Kind.STOP_FORWARD: ("|", "stop forward"),
    Kind.START_BACKWARD: ("<", "start backward"), Kind.STOP_BACKWARD: ("x", "stop backward"),
    Kind.CLAP: ("*", "clap"), Kind.TURN: ("*", "turn"),
}  # fmt: skip
PART_COLOURS = ("#CC79A7", "#56B4E9", "#0072B2", "#009E73", "#E69F00", "#D55E00")
"""One for each of `record.rerun.explanation.STAGES`."""

PART_NAMES = {
    "dancer": "followed dancer behind the mean", "sensor": "sensor", "detector": "detector",
    "network": "network", "decision": "method", "wheels": "command to motion",
}  # fmt: skip


def check_plots(folder: Path, overwrite: bool) -> None:
    """Make sure that plots can be drawn, and that none is lost by it.

    Raises:
        RecordError: matplotlib is missing, or the folder holds plots already.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise RecordError("plots need matplotlib: pip install matplotlib") from None
    if folder.exists() and not folder.is_dir():
        raise RecordError(f"{folder} is a file: name a folder")
    held = [name for name in FILES if (folder / name).exists()]
    if held and not overwrite:
        raise RecordError(f"{folder / held[0]} exists: name another folder, or allow it with --overwrite")


def save_plots(log: SessionLog, report: DelayReport, folder: Path, overwrite: bool = False) -> list[Path]:
    """Write every figure that the session gives rise to.

    Args:
        log: the session.
        report: what follows from it.
        folder: where to; made if absent.
        overwrite: whether earlier plots may be replaced.

    Returns:
        the files; a humans-only session has neither timing nor delays.

    Raises:
        RecordError: see `check_plots`, or the folder cannot be written.
    """
    check_plots(folder, overwrite)
    config = from_plain(log.config)
    figures = {"raster.png": raster(log, config), "graph.png": graphs(report.graphs)}
    if report.ta:
        figures["timing.png"] = timing([value for _, value in report.ta])
    if any(np.isfinite(step.late_s) for step in report.steps):
        figures["delays.png"] = delays(report)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, figure in figures.items():
            figure.savefig(folder / name, dpi=140)
    except OSError as error:
        raise RecordError(f"{folder} cannot be written: {error.strerror or error}") from None
    return [folder / name for name in figures]


def raster(log: SessionLog, config: SessionConfig, iteration: int | None = None) -> Figure:
    """Everybody's events in one iteration, the last by default: planned moves, true onsets, what was logged."""
    table = timetable(config)
    number = table.last if iteration is None else iteration
    agents = [dancer_name(index) for index in range(config.dancers)] + ([] if config.method == "none" else [ROBOT])
    figure = _figure(9.0, 1.6 + 0.75 * len(agents))
    axes = figure.add_subplot()
    rows = {agent: len(agents) - 1 - place for place, agent in enumerate(agents)}
    start_s = table.start_s(number)
    for cue in log.cues:
        if cue.iteration == number and cue.move in (Move.FORWARD, Move.BACKWARD):
            bar = (cue.t_s - start_s, cue.duration_s)
            axes.broken_barh([bar], (rows[cue.dancer] - 0.3, 0.6), facecolors=_colour(cue.dancer), alpha=0.18)
    true = [*dancer_events(log.truth, log.cues, table), *robot_events(log.odometry, table)]
    for event in true:
        if event.iteration == number and event.agent in rows:
            _mark(axes, event.t_s - start_s, rows[event.agent] + 0.16, event.kind, _colour(event.agent), 0.35)
    logged = [(e.person, e.kind, e.t_s, e.iteration) for e in log.events if not e.early]
    logged += [(e.agent, e.kind, e.t_s, e.iteration) for e in log.robot_events]
    for agent, kind, t_s, of in logged:
        if of == number and agent in rows:
            _mark(axes, t_s - start_s, rows[agent] - 0.16, kind, _colour(agent), 1.0)
    _beats(axes, table, number)
    axes.set_yticks(list(rows.values()), list(rows))
    axes.set_xlabel("time in the iteration [s]")
    axes.set_title(
        f"Who did what when: iteration {number} (faint: true onset; full: as logged; bars: planned; lines: music)",
        fontsize=11,
    )
    shown = [(marker, name) for kind, (marker, name) in MARKERS.items() if kind is not Kind.TURN]
    handles = [axes.plot([], [], marker, color="0.3", label=name)[0] for marker, name in shown]
    axes.legend(handles=handles, ncol=5, loc="upper center", bbox_to_anchor=(0.5, -0.16), frameon=False)
    return figure


def timing(values_s: Sequence[float]) -> Figure:
    """How far the robot was from the dancers' mean: a histogram, and the share of events below each value."""
    figure = _figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)
    top = max(2.0, float(np.ceil(max(values_s) * 5) / 5))
    left.hist(values_s, bins=np.arange(0.0, top + 0.2, 0.2), color="#0072B2", edgecolor="white")
    left.set(xlabel="distance from the dancers' mean [s]", ylabel="robot's events", title="Timing appropriateness")
    ordered = np.sort(values_s)
    share = 100.0 * np.arange(1, len(ordered) + 1) / len(ordered)
    right.step([0.0, *ordered, top], [0.0, *share, 100.0], where="post", color="#D55E00")
    for bound in (0.8, 1.2, 1.6):
        right.axvline(bound, color="0.8", linewidth=0.8, zorder=0)
    right.set(xlabel="distance from the dancers' mean [s]", ylabel="events up to here [%]", title="Cumulative share")
    right.set(xlim=(0.0, top), ylim=(0.0, 103.0))
    return figure


def graphs(found: Sequence[Graph]) -> Figure:
    """The group topology graph of every iteration: wider lines are more synchronous pairs."""
    columns = min(4, max(1, len(found)))
    lines = -(-max(1, len(found)) // columns)
    figure = _figure(max(6.4, 2.7 * columns + 0.4), 3.2 * lines)  # never narrower than its title
    panels = np.atleast_1d(figure.subplots(lines, columns, squeeze=False)).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, graph in zip(panels, found, strict=False):
        _graph(axes, graph)
    figure.suptitle("Synchrony of pairs in each iteration (Q, 0 to 1); arrow: whom the robot followed", fontsize=10)
    return figure


def delays(report: DelayReport) -> Figure:
    """Where the time between the dancers' mean and the robot's motion goes, by event kind."""
    led = [step for step in report.steps if step.follows]
    told = led or report.steps
    kinds = list(dict.fromkeys(step.kind for step in told))
    figure = _figure(9.0, 1.8 + 0.5 * len(kinds))
    axes = figure.add_subplot()
    for row, kind in enumerate(reversed(kinds)):
        steps = [step for step in told if step.kind is kind and np.isfinite(step.late_s)]
        if not steps:
            continue
        parts = np.nan_to_num(np.array([step.parts_s for step in steps])).mean(axis=0)
        ahead, behind = 0.0, 0.0
        for stage, part, colour in zip(STAGES, parts, PART_COLOURS, strict=True):
            label = PART_NAMES[stage] if row == 0 else None
            axes.barh(row, part, left=behind if part >= 0 else ahead, color=colour, height=0.6, label=label)
            behind, ahead = behind + max(part, 0.0), ahead + min(part, 0.0)
        total = float(np.mean([step.late_s for step in steps]))
        axes.plot([total], [row], "kD", markersize=5, label="in all" if row == 0 else None)
    axes.axvline(0.0, color="0.4", linewidth=0.8)
    axes.set_yticks(range(len(kinds)), [kind.value.replace("_", " ") for kind in reversed(kinds)])
    axes.set_xlabel("mean delay behind the dancers' mean time [s]; negative is early")
    axes.set_title("Where the robot's delay comes from" + (" (steps in which it followed a dancer)" if led else ""))
    axes.legend(ncol=4, loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)
    return figure


def _figure(width: float, height: float) -> Figure:
    """A figure of its own, known to no window system and no global state."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Sheet

    sheet = Sheet(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(sheet)
    return sheet


def _graph(axes: Axes, graph: Graph) -> None:
    angles = np.pi / 2 + 2 * np.pi * np.arange(len(graph.agents)) / len(graph.agents)
    places: Array = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for i in range(len(places)):
        for j in range(i):
            weight = float(graph.pairs[i, j])
            axes.plot(*zip(places[i], places[j], strict=True), color="0.6", linewidth=0.3 + 6 * weight, zorder=1)
            x, y = (0.66 * places[i] + 0.34 * places[j]).tolist()  # off the middle, where the diagonals cross
            ground = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
            axes.text(x, y, f"{weight:.2f}", fontsize=7, ha="center", va="center", zorder=4, bbox=ground)
    if graph.follows:
        a, b = places[graph.agents.index(ROBOT)], places[graph.agents.index(graph.follows)]
        style = {"arrowstyle": "-|>", "color": "#E69F00", "linewidth": 2.5}
        axes.annotate("", xy=tuple(a + 0.86 * (b - a)), xytext=tuple(a), arrowprops=style, zorder=2)
    for place, agent in zip(places, graph.agents, strict=True):
        axes.plot(*place, "o", color=_colour(agent), markersize=15, zorder=3)
        axes.text(1.62 * place[0], 1.32 * place[1], agent, ha="center", va="center", fontsize=8)
    axes.set(xlim=(-2.1, 2.1), ylim=(-1.6, 1.6), aspect="equal")
    axes.set_title(f"iteration {graph.iteration}: GSI {graph.gsi_full_edges:.2f} (full edges)", fontsize=9)


def _mark(axes: Axes, t_s: float, row: float, kind: Kind, colour: tuple[float, ...], alpha: float) -> None:
    axes.plot([t_s], [row], MARKERS[kind][0], color=colour, alpha=alpha, markersize=9, markeredgewidth=2)


def _beats(axes: Axes, table: Timetable, number: int) -> None:
    start_s = table.start_s(number)
    for step in table.choreography.steps():
        axes.axvline(table.time_s(number, step.beat) - start_s, color="0.85", linewidth=0.8, zorder=0)


def _colour(agent: str) -> tuple[float, ...]:
    value = ROBOT_COLOUR if agent == ROBOT else dancer_colour(int(agent.rpartition("_")[2]) - 1)
    return tuple(part / 255 for part in value)
