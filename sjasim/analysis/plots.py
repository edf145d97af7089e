"""Figures of a session: events of an iteration, the robot's timing, the group's graphs, and delays by part."""

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
from ..record.rerun.explanation import STAGES, DelayReport, Graph, StepDelay
from .ground_truth_events import dancer_events, robot_events
from .session_metrics import logged_events

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FILES = ("raster.png", "timing.png", "graph.png", "delays.png")
"""Names of the files that `save_plots` may write."""

MARKERS = {
    Kind.START_FORWARD: (">", "start forward"), Kind.STOP_FORWARD: ("|", "stop forward"),
    Kind.START_BACKWARD: ("<", "start backward"), Kind.STOP_BACKWARD: ("x", "stop backward"),
    Kind.CLAP: ("*", "clap"), Kind.TURN: ("*", "turn"),
}  # fmt: skip
"""Kind of an event -> marker and label."""

STAGE_COLOURS = ("#CC79A7", "#56B4E9", "#0072B2", "#009E73", "#E69F00", "#D55E00")
"""Colour of each of `record.rerun.explanation.STAGES`."""

STAGE_LABELS = {
    "dancer": "followed dancer behind the mean", "sensor": "sensor", "detector": "detector",
    "network": "network", "decision": "method", "wheels": "command to motion",
}  # fmt: skip
"""Stage -> label in the legend."""

GUIDE_LINES_S = (0.8, 1.2, 1.6)
"""Distances at which the cumulative share has a line to read it off [s]."""


def check_plots(folder: Path, overwrite: bool) -> None:
    """Check that figures can be drawn and written without losing earlier ones.

    Args:
        folder: the folder to write into.
        overwrite: whether earlier figures may be replaced.

    Raises:
        RecordError: matplotlib is missing, the path is a file, or the folder holds figures already.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise RecordError("plots need matplotlib: pip install matplotlib") from None

    if folder.exists() and not folder.is_dir():
        raise RecordError(f"{folder} is a file: name a folder")
    existing = [name for name in FILES if (folder / name).exists()]
    if existing and not overwrite:
        raise RecordError(f"{folder / existing[0]} exists: name another folder, or allow it with --overwrite")


def save_plots(log: SessionLog, report: DelayReport, folder: Path, overwrite: bool = False) -> list[Path]:
    """Write every figure for which the session has data.

    Args:
        log: the session.
        report: from `delay_breakdown.delay_report`.
        folder: the folder to write into; it is created if absent.
        overwrite: whether earlier figures may be replaced.

    Returns:
        The files; a humans-only session has neither timing nor delays.

    Raises:
        RecordError: as in `check_plots`, or the folder cannot be written.
    """
    check_plots(folder, overwrite)

    figures = {"raster.png": raster(log, from_plain(log.config)), "graph.png": graphs(report.graphs)}
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
    """Events of all agents in one iteration: planned moves as bars, true onsets faint, logged events full.

    Args:
        log: the session.
        config: its configuration.
        iteration: number of the iteration; by default the last one.
    """
    table = timetable(config)
    number = table.last if iteration is None else iteration
    start_s = table.start_s(number)
    agents = [dancer_name(index) for index in range(config.dancers)] + ([] if config.method == "none" else [ROBOT])
    rows = {agent: len(agents) - 1 - index for index, agent in enumerate(agents)}

    figure = _figure(9.0, 1.6 + 0.75 * len(agents))
    axes = figure.add_subplot()
    for cue in log.cues:
        if cue.iteration == number and cue.move in (Move.FORWARD, Move.BACKWARD):
            interval = (cue.t_s - start_s, cue.duration_s)
            axes.broken_barh([interval], (rows[cue.dancer] - 0.3, 0.6), facecolors=_colour(cue.dancer), alpha=0.18)

    # True onsets stand above the middle of an agent's row, logged events below it.
    true = [*dancer_events(log.truth, log.cues, table), *robot_events(log.odometry, table)]
    for events, offset, alpha in ((true, 0.16, 0.35), (logged_events(log), -0.16, 1.0)):
        for event in events:
            if event.iteration == number and event.agent in rows:
                row = rows[event.agent] + offset
                _draw_event(axes, event.t_s - start_s, row, event.kind, _colour(event.agent), alpha)

    _draw_beats(axes, table, number)
    axes.set_yticks(list(rows.values()), list(rows))
    axes.set_xlabel("time in the iteration [s]")
    axes.set_title(
        f"Who did what when: iteration {number} (faint: true onset; full: as logged; bars: planned; lines: music)",
        fontsize=11,
    )
    # A turn has the marker of a clap, so one entry serves both.
    entries = [(marker, label) for kind, (marker, label) in MARKERS.items() if kind is not Kind.TURN]
    handles = [axes.plot([], [], marker, color="0.3", label=label)[0] for marker, label in entries]
    axes.legend(handles=handles, ncol=5, loc="upper center", bbox_to_anchor=(0.5, -0.16), frameon=False)
    return figure


def timing(values_s: Sequence[float]) -> Figure:
    """Histogram and cumulative share of timing appropriateness.

    Args:
        values_s: distances of the robot's events from the dancers' mean [s].
    """
    figure = _figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)
    # The axis ends at a multiple of the bins' width, and at 2 s at least, so that figures of sessions can be compared.
    top = max(2.0, float(np.ceil(max(values_s) * 5) / 5))

    left.hist(values_s, bins=np.arange(0.0, top + 0.2, 0.2), color="#0072B2", edgecolor="white")
    left.set(xlabel="distance from the dancers' mean [s]", ylabel="robot's events", title="Timing appropriateness")

    ordered = np.sort(values_s)
    share = 100.0 * np.arange(1, len(ordered) + 1) / len(ordered)
    right.step([0.0, *ordered, top], [0.0, *share, 100.0], where="post", color="#D55E00")
    for bound in GUIDE_LINES_S:
        right.axvline(bound, color="0.8", linewidth=0.8, zorder=0)
    right.set(xlabel="distance from the dancers' mean [s]", ylabel="events up to here [%]", title="Cumulative share")
    right.set(xlim=(0.0, top), ylim=(0.0, 103.0))
    return figure


def graphs(iterations: Sequence[Graph]) -> Figure:
    """Group topology graph of every iteration: the wider a line, the more synchronous its pair."""
    columns = min(4, max(1, len(iterations)))
    lines = -(-max(1, len(iterations)) // columns)

    # The title needs a width of 6.4.
    figure = _figure(max(6.4, 2.7 * columns + 0.4), 3.2 * lines)
    panels = np.atleast_1d(figure.subplots(lines, columns, squeeze=False)).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, graph in zip(panels, iterations, strict=False):
        _draw_graph(axes, graph)
    figure.suptitle("Synchrony of pairs in each iteration (Q, 0 to 1); arrow: whom the robot followed", fontsize=10)
    return figure


def delays(report: DelayReport) -> Figure:
    """Mean parts of the robot's delay behind the dancers' mean, by event kind.

    If the robot followed a dancer in any step, only such steps count.
    """
    following = [step for step in report.steps if step.follows]
    used = following or report.steps
    kinds = list(dict.fromkeys(step.kind for step in used))

    figure = _figure(9.0, 1.8 + 0.5 * len(kinds))
    axes = figure.add_subplot()
    for row, kind in enumerate(reversed(kinds)):
        steps = [step for step in used if step.kind is kind and np.isfinite(step.late_s)]
        if steps:
            _draw_delay(axes, row, steps)

    axes.axvline(0.0, color="0.4", linewidth=0.8)
    axes.set_yticks(range(len(kinds)), [kind.value.replace("_", " ") for kind in reversed(kinds)])
    axes.set_xlabel("mean delay behind the dancers' mean time [s]; negative is early")
    scope = " (steps in which it followed a dancer)" if following else ""
    axes.set_title(f"Where the robot's delay comes from{scope}")
    axes.legend(ncol=4, loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)
    return figure


def _draw_delay(axes: Axes, row: int, steps: Sequence[StepDelay]) -> None:
    """Draw the mean parts of some steps as a stacked bar: positive ones to the right, negative ones to the left."""
    parts_s = np.nan_to_num(np.array([step.parts_s for step in steps])).mean(axis=0)
    left_s = 0.0
    right_s = 0.0
    for stage, part_s, colour in zip(STAGES, parts_s, STAGE_COLOURS, strict=True):
        # Labels of the first row are enough for the legend.
        label = STAGE_LABELS[stage] if row == 0 else None
        axes.barh(row, part_s, left=right_s if part_s >= 0 else left_s, color=colour, height=0.6, label=label)
        right_s += max(part_s, 0.0)
        left_s += min(part_s, 0.0)

    total_s = float(np.mean([step.late_s for step in steps]))
    axes.plot([total_s], [row], "kD", markersize=5, label="in all" if row == 0 else None)


def _draw_graph(axes: Axes, graph: Graph) -> None:
    """Draw one topology graph; agents stand on a circle."""
    angles = np.pi / 2 + 2 * np.pi * np.arange(len(graph.agents)) / len(graph.agents)
    positions: Array = np.stack([np.cos(angles), np.sin(angles)], axis=1)

    for i in range(len(positions)):
        for j in range(i):
            weight = float(graph.pairs[i, j])
            ends = zip(positions[i], positions[j], strict=True)
            axes.plot(*ends, color="0.6", linewidth=0.3 + 6 * weight, zorder=1)
            # Labels stand off the middle of a line, where the diagonals cross.
            x, y = (0.66 * positions[i] + 0.34 * positions[j]).tolist()
            box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
            axes.text(x, y, f"{weight:.2f}", fontsize=7, ha="center", va="center", zorder=4, bbox=box)

    if graph.follows:
        robot = positions[graph.agents.index(ROBOT)]
        followed = positions[graph.agents.index(graph.follows)]
        tip = tuple(robot + 0.86 * (followed - robot))
        style = {"arrowstyle": "-|>", "color": "#E69F00", "linewidth": 2.5}
        axes.annotate("", xy=tip, xytext=tuple(robot), arrowprops=style, zorder=2)

    for position, agent in zip(positions, graph.agents, strict=True):
        axes.plot(*position, "o", color=_colour(agent), markersize=15, zorder=3)
        axes.text(1.62 * position[0], 1.32 * position[1], agent, ha="center", va="center", fontsize=8)
    axes.set(xlim=(-2.1, 2.1), ylim=(-1.6, 1.6), aspect="equal")
    axes.set_title(f"iteration {graph.iteration}: GSI {graph.gsi_full_edges:.2f} (full edges)", fontsize=9)


def _draw_event(axes: Axes, t_s: float, row: float, kind: Kind, colour: tuple[float, ...], alpha: float) -> None:
    """Draw one event of the raster."""
    axes.plot([t_s], [row], MARKERS[kind][0], color=colour, alpha=alpha, markersize=9, markeredgewidth=2)


def _draw_beats(axes: Axes, table: Timetable, iteration: int) -> None:
    """Draw a line at the beat of every step of an iteration."""
    start_s = table.start_s(iteration)
    for step in table.choreography.steps():
        axes.axvline(table.time_s(iteration, step.beat) - start_s, color="0.85", linewidth=0.8, zorder=0)


def _colour(agent: str) -> tuple[float, ...]:
    """Colour of a dancer or the robot, from 0 to 1."""
    value = ROBOT_COLOUR if agent == ROBOT else dancer_colour(int(agent.rpartition("_")[2]) - 1)
    return tuple(part / 255 for part in value)


def _figure(width: float, height: float) -> Figure:
    """A figure that is independent of pyplot's state and of window systems; size in inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as MatplotlibFigure

    figure = MatplotlibFigure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure
