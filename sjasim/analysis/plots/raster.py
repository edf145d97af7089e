"""Events of all agents in all iterations, with marks where one is missing or false."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...choreography.timetable import Timetable, timetable
from ...config import HUMANS_ONLY
from ...config.toml_file import from_plain
from ...core import ROBOT, Kind, Move, dancer_name
from ...core.session_log import AgentEvent, SessionLog
from ..missing_events import MissingEvents, missing_events
from ..session_metrics import logged_events, true_events
from .figure import Colour, agent_colour, empty_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKERS = {
    Kind.START_FORWARD: (">", "start forward"), Kind.STOP_FORWARD: ("|", "stop forward"),
    Kind.START_BACKWARD: ("<", "start backward"), Kind.STOP_BACKWARD: ("x", "stop backward"),
    Kind.CLAP: ("*", "clap, turn"), Kind.TURN: ("*", "clap, turn"),
}  # fmt: skip
"""Kind of an event -> marker and label."""

TRUE_OFFSET = 0.17
LOGGED_OFFSET = -0.17
"""Places of true and logged events above and below the middle of an agent's row, whose height is 1."""

MISSING_STYLES = {
    "not_performed": ("s", "#D62728", TRUE_OFFSET, "step left out"),
    "not_logged": ("o", "#D62728", LOGGED_OFFSET, "event missed by the sensors"),
    "false": ("D", "#E69F00", LOGGED_OFFSET, "false event"),
}
"""Field of `MissingEvents` -> frame around the event's marker, colour, place in the row and label."""

FRAME: dict[str, Any] = {"markersize": 13, "markerfacecolor": "none", "markeredgewidth": 1.8}
"""Style of the frames around what is missing or false."""


def raster_figure(log: SessionLog) -> Figure:
    """Events of all agents, one panel per iteration: planned moves as bars, true onsets faint, logged events full.

    What is missing is marked: steps that an agent left out, true events that were not logged, and false events.

    Args:
        log: the session.
    """
    config = from_plain(log.config)
    table = timetable(config)
    agents = [dancer_name(index) for index in range(config.dancers)]
    agents += [] if config.method == HUMANS_ONLY else [ROBOT]
    rows = {agent: len(agents) - 1 - index for index, agent in enumerate(agents)}
    iterations = range(1, table.last + 1)

    figure = empty_figure(9.0, 1.4 + len(iterations) * (0.5 + 0.42 * len(agents)))
    panels = figure.subplots(len(iterations), 1, sharex=True, squeeze=False).ravel()
    dancers, robot = true_events(log, table)
    missing = missing_events(log)
    for axes, iteration in zip(panels, iterations, strict=True):
        _draw_plans(axes, log, table, iteration, rows)
        _draw_events(axes, [*dancers, *robot], table, iteration, rows, TRUE_OFFSET, 0.4)
        _draw_events(axes, logged_events(log), table, iteration, rows, LOGGED_OFFSET, 1.0)
        _draw_missing(axes, missing, table, iteration, rows)
        axes.set_yticks(list(rows.values()), list(rows))
        axes.set_ylim(-0.55, len(rows) - 0.45)
        axes.set_title(f"iteration {iteration}", fontsize=9, loc="left")

    panels[-1].set_xlabel("time since the iteration's first beat [s]")
    figure.suptitle(
        "Who did what when (upper, faint: true onset; lower: as logged; bars: planned; lines: music)", fontsize=11
    )
    figure.legend(handles=_legend(panels[0]), ncol=4, loc="outside lower center", frameon=False, fontsize=9)
    return figure


def _draw_plans(axes: Axes, log: SessionLog, table: Timetable, iteration: int, rows: Mapping[str, int]) -> None:
    """Draw the music's beats of all steps as lines, and the dancers' planned moves as bars."""
    start_s = table.start_s(iteration)
    for step in table.choreography.steps():
        axes.axvline(table.time_s(iteration, step.beat) - start_s, color="0.85", linewidth=0.8, zorder=0)

    for cue in log.cues:
        if cue.iteration == iteration and cue.move in (Move.FORWARD, Move.BACKWARD):
            interval = (cue.t_s - start_s, cue.duration_s)
            colour = agent_colour(cue.dancer)
            axes.broken_barh([interval], (rows[cue.dancer] - 0.36, 0.72), facecolors=colour, alpha=0.15)


def _draw_events(
    axes: Axes, events: Sequence[AgentEvent], table: Timetable, iteration: int, rows: Mapping[str, int],
    offset: float, alpha: float,
) -> None:  # fmt: skip
    """Draw the events of one iteration, above or below the middle of their rows."""
    for event in events:
        if event.iteration == iteration and event.agent in rows:
            t_s = event.t_s - table.start_s(iteration)
            marker = MARKERS[event.kind][0]
            colour: Colour = agent_colour(event.agent)
            axes.plot([t_s], [rows[event.agent] + offset], marker, color=colour, alpha=alpha, markersize=6)


def _draw_missing(
    axes: Axes, missing: MissingEvents, table: Timetable, iteration: int, rows: Mapping[str, int]
) -> None:
    """Draw a frame for every missing or false event, and in it the marker of what is missing."""
    for name, (frame, colour, offset, _) in MISSING_STYLES.items():
        for event in getattr(missing, name):
            if event.iteration != iteration or event.agent not in rows:
                continue
            place = ([event.t_s - table.start_s(iteration)], [rows[event.agent] + offset])
            axes.plot(*place, frame, color=colour, zorder=5, **FRAME)
            if name != "false":
                axes.plot(*place, MARKERS[event.kind][0], color=colour, markersize=6, zorder=5)


def _legend(axes: Axes) -> list[object]:
    """Entries of the legend: one per kind of event, and one per kind of mark."""
    # A turn has the marker of a clap, so one entry serves both.
    kinds = dict(MARKERS.values())
    entries: list[object] = [axes.plot([], [], marker, color="0.3", label=label)[0] for marker, label in kinds.items()]
    for frame, colour, _, label in MISSING_STYLES.values():
        entries += axes.plot([], [], frame, color=colour, label=label, **{**FRAME, "markersize": 9})
    return entries
