"""Charts of a session: events of all iterations, and the robot's lateness step by step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from markupsafe import Markup

from ...core import ROBOT, Kind
from ...core.session_log import AgentEvent
from ...record.rerun.explanation import StepDelay
from .axes import Axes, Margins, padded, ticks
from .session_events import IterationEvents
from .svg import Drawing, swatch
from .text import agent as agent_text

WIDTH = 980.0
"""Width of a chart that takes the whole page [px]."""

ROW = 22.0
"""Height of an agent's row [px]."""

HEAD = 26.0
"""Height of the title of an iteration [px]."""

DANCER_SERIES = ("c1", "c2", "c0", "c3", "c4", "c5")
"""Classes of the dancers in their order; they have the hues of `assets.colours`."""

MARKERS = {
    Kind.START_FORWARD: ("right", "start forward"),
    Kind.STOP_FORWARD: ("bar", "stop forward"),
    Kind.START_BACKWARD: ("left", "start backward"),
    Kind.STOP_BACKWARD: ("square", "stop backward"),
    Kind.CLAP: ("star", "clap, or the robot's turn"),
    Kind.TURN: ("star", ""),
}
"""Kind of an event -> marker and text of the legend; a turn shares that of a clap."""


def raster(title: str, iterations: Sequence[IterationEvents]) -> Markup:
    """Events of all agents in all iterations, with marks where one is missing or false.

    Args:
        title: title of the drawing.
        iterations: from `session_events.iteration_events`.
    """
    length_s = max(item.length_s for item in iterations)
    height = 46.0 + sum(HEAD + ROW * len(item.agents) + 8 for item in iterations)
    drawing = Drawing(WIDTH, height, title, _raster_description(iterations))
    axes = Axes(drawing, (0.0, length_s), (0.0, 1.0), Margins(left=92, top=0, right=10, bottom=42))

    top = 0.0
    for item in iterations:
        top += HEAD
        drawing.text((4, top - 8), _iteration_title(item), style="head")
        _draw_iteration(axes, item, top)
        top += ROW * len(item.agents) + 8
    axes.bottom("time since the first beat of the iteration [s]", ticks(0.0, length_s, 9))
    return drawing.markup()


def raster_legend() -> list[tuple[Markup, str]]:
    """Legend of `raster`."""
    return [
        *((swatch([(shape, "ink fill")]), text) for shape, text in MARKERS.values() if text),
        (swatch([("cross", "fault stroke")]), "happened, but was not logged"),
        (swatch([("diamond", "fault hollow")]), "not performed"),
        (swatch([("circle", "fault hollow")]), "logged, but did not happen"),
        (swatch([("line", "ink thin")]), "from the followed dancer's event to the robot's"),
    ]


def lateness(title: str, steps: Sequence[StepDelay], tau_s: float) -> Markup:
    """The robot's lateness in every step, with marks where it did not move.

    Args:
        title: title of the drawing.
        steps: all steps in order.
        tau_s: half width of the coincidence window, which is shaded [s].
    """
    known = [step.late_s for step in steps if math.isfinite(step.late_s)]
    low, high = padded([*known, -tau_s, tau_s])
    described = f"{len(known)} of {len(steps)} steps were performed; mean lateness {_mean(known)} s."
    drawing = Drawing(WIDTH, 250, title, described)
    numbers = list(dict.fromkeys(step.iteration for step in steps))
    # A gap of one bar divides the iterations.
    axes = Axes(drawing, (-1.0, len(steps) + len(numbers) - 1.0), (low, high), Margins(bottom=34))

    axes.left("robot later than the dancers' mean [s]", ticks(low, high))
    corner = (axes.x.start, axes.y(tau_s))
    drawing.rectangle(corner, axes.x.end - axes.x.start, axes.y(-tau_s) - axes.y(tau_s), "band")
    drawing.line((axes.x.start, axes.y(0.0)), (axes.x.end, axes.y(0.0)), "axis")

    for place, number in enumerate(numbers):
        own = [(index + place, step) for index, step in enumerate(steps) if step.iteration == number]
        for position, step in own:
            _lateness_bar(axes, position, step)
        middle = (own[0][0] + own[-1][0]) / 2
        drawing.text((axes.x(middle), axes.y.start + 22), f"iteration {number}", "middle", "label")
    return drawing.markup()


def _draw_iteration(axes: Axes, item: IterationEvents, top: float) -> None:
    """Rows of one iteration: guides at the music's beats, names, and events."""
    bottom = top + ROW * len(item.agents)
    for beat_s in item.beats_s:
        axes.drawing.line((axes.x.clipped(beat_s), top), (axes.x.clipped(beat_s), bottom), "grid")
    rows = {agent: top + ROW * (index + 0.5) for index, agent in enumerate(item.agents)}

    for leader_s, robot_s in item.links:
        start = (axes.x.clipped(leader_s), rows[item.followed])
        axes.drawing.line(start, (axes.x.clipped(robot_s), rows[ROBOT]), "ink thin")
    for agent, y in rows.items():
        axes.drawing.text((axes.x.start - 10, y + 4), agent_text(agent), "end", "label")

    _draw_events(axes, rows, item.not_performed, "diamond", "fault hollow")
    _draw_events(axes, rows, item.not_logged, "cross", "fault stroke")
    _draw_events(axes, rows, item.false, "circle", "fault hollow")
    for event in item.logged:
        if event.agent in rows:
            place = (axes.x.clipped(event.t_s), rows[event.agent])
            axes.drawing.marker(place, MARKERS[event.kind][0], f"{_style(event.agent)} fill")


def _draw_events(axes: Axes, rows: Mapping[str, float], events: Sequence[AgentEvent], shape: str, style: str) -> None:
    """Draw the same marker for all of some events."""
    for event in events:
        if event.agent in rows:
            axes.drawing.marker((axes.x.clipped(event.t_s), rows[event.agent]), shape, style)


def _lateness_bar(axes: Axes, position: float, step: StepDelay) -> None:
    if not math.isfinite(step.late_s):
        axes.drawing.marker(axes.point(position, 0.0), "diamond", "fault hollow")
        return
    x = axes.x(position - 0.4)
    top = axes.y(max(step.late_s, 0.0))
    axes.drawing.rectangle((x, top), axes.x(position + 0.4) - x, axes.y(min(step.late_s, 0.0)) - top, "c0 fill soft")


def _iteration_title(item: IterationEvents) -> str:
    if item.iteration == 0:
        return "Rehearsal, without the robot"
    followed = f": the robot followed {agent_text(item.followed)}" if item.followed else ""
    return f"Iteration {item.iteration}{followed}"


def _raster_description(iterations: Sequence[IterationEvents]) -> str:
    return (
        f"Rows are dancers and robot, in {len(iterations)} iterations: {sum(len(item.logged) for item in iterations)} "
        f"events are logged, {sum(len(item.not_logged) for item in iterations)} happened and are not logged, "
        f"{sum(len(item.not_performed) for item in iterations)} steps were not performed, and "
        f"{sum(len(item.false) for item in iterations)} logged events did not happen."
    )


def _style(agent: str) -> str:
    """Class of an agent's series."""
    return "ink" if agent == ROBOT else DANCER_SERIES[(int(agent.rpartition("_")[2]) - 1) % len(DANCER_SERIES)]


def _mean(values: Sequence[float]) -> str:
    return f"{sum(values) / len(values):.2f}" if values else "unknown"
