"""Charts of a session: events of all iterations, and the robot's lateness step by step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from markupsafe import Markup

from ...core import ROBOT, Kind
from ...record.rerun.explanation import StepDelay
from .axes import Axes, Margins, padded, ticks
from .step_events import LOGGED, NOT_LOGGED, IterationEvents, StepEvent
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
}
"""Kind of an event -> marker and text of the legend."""


def raster(title: str, iterations: Sequence[IterationEvents], followed: Mapping[int, str]) -> Markup:
    """Events of all agents in all iterations, with marks where one is missing.

    Args:
        title: title of the drawing.
        iterations: from `step_events.iteration_events`.
        followed: iteration -> the dancer whom the robot followed, or "".
    """
    length_s = max(item.length_s for item in iterations)
    height = 46.0 + sum(HEAD + ROW * len(item.agents) + 8 for item in iterations)
    drawing = Drawing(WIDTH, height, title, _raster_description(iterations))
    axes = Axes(drawing, (0.0, length_s), (0.0, 1.0), Margins(left=92, top=0, right=10, bottom=42))

    top = 0.0
    for item in iterations:
        top += HEAD
        drawing.text((4, top - 8), _iteration_title(item, followed.get(item.iteration, "")), style="head")
        _draw_iteration(axes, item, top, followed.get(item.iteration, ""))
        top += ROW * len(item.agents) + 8
    axes.bottom("time since the first beat of the iteration [s]", ticks(0.0, length_s, 9))
    return drawing.markup()


def raster_legend() -> list[tuple[Markup, str]]:
    """Legend of `raster`."""
    return [
        *((swatch([(shape, "ink fill")]), text) for shape, text in MARKERS.values()),
        (swatch([("cross", "fault stroke")]), "performed, but not logged"),
        (swatch([("diamond", "fault hollow")]), "not performed"),
        (swatch([("circle", "ink hollow")]), "logged, but belongs to no step"),
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


def _draw_iteration(axes: Axes, item: IterationEvents, top: float, followed: str) -> None:
    """Rows of one iteration: guides at the music's beats, names, and events."""
    bottom = top + ROW * len(item.agents)
    for beat_s in item.beats_s:
        axes.drawing.line((axes.x.clipped(beat_s), top), (axes.x.clipped(beat_s), bottom), "grid")
    rows = {agent: top + ROW * (index + 0.5) for index, agent in enumerate(item.agents)}

    if followed in rows and ROBOT in rows:
        _connect(axes, item, rows, followed)
    for agent, y in rows.items():
        axes.drawing.text((axes.x.start - 10, y + 4), agent_text(agent), "end", "label")
    for step in item.steps:
        _draw_step(axes, step, rows[step.agent])
    for event in item.extra:
        axes.drawing.marker((axes.x.clipped(event.t_s), rows[event.agent]), "circle", f"{_style(event.agent)} hollow")


def _draw_step(axes: Axes, step: StepEvent, y: float) -> None:
    """The marker of one step; that of a missing event says why it is missing."""
    place = (axes.x.clipped(step.t_s), y)
    if step.status == LOGGED:
        axes.drawing.marker(place, MARKERS[step.kind][0], f"{_style(step.agent)} fill")
    else:
        shape = ("cross", "fault stroke") if step.status == NOT_LOGGED else ("diamond", "fault hollow")
        axes.drawing.marker(place, *shape)


def _connect(axes: Axes, item: IterationEvents, rows: Mapping[str, float], followed: str) -> None:
    """Lines from the events of the followed dancer to those of the robot; their slope is the robot's lateness."""
    logged = {(step.agent, step.ordinal): step.t_s for step in item.steps if step.status == LOGGED}
    for (agent, ordinal), t_s in logged.items():
        leader_s = logged.get((followed, ordinal))
        if agent == ROBOT and leader_s is not None:
            start = (axes.x.clipped(leader_s), rows[followed])
            axes.drawing.line(start, (axes.x.clipped(t_s), rows[ROBOT]), "ink thin")


def _lateness_bar(axes: Axes, position: float, step: StepDelay) -> None:
    if not math.isfinite(step.late_s):
        axes.drawing.marker(axes.point(position, 0.0), "diamond", "fault hollow")
        return
    x = axes.x(position - 0.4)
    top = axes.y(max(step.late_s, 0.0))
    axes.drawing.rectangle((x, top), axes.x(position + 0.4) - x, axes.y(min(step.late_s, 0.0)) - top, "c0 fill soft")


def _iteration_title(item: IterationEvents, followed: str) -> str:
    if item.iteration == 0:
        return "Rehearsal, without the robot"
    return f"Iteration {item.iteration}" + (f": the robot followed {agent_text(followed)}" if followed else "")


def _raster_description(iterations: Sequence[IterationEvents]) -> str:
    steps = [step for item in iterations for step in item.steps]
    missing = [step for step in steps if step.status != LOGGED]
    return (
        f"Rows are dancers and robot, in {len(iterations)} iterations. {len(steps) - len(missing)} of {len(steps)} "
        f"steps have a logged event; {len(missing)} are marked as missing."
    )


def _style(agent: str) -> str:
    """Class of an agent's series."""
    return "ink" if agent == ROBOT else DANCER_SERIES[(int(agent.rpartition("_")[2]) - 1) % len(DANCER_SERIES)]


def _mean(values: Sequence[float]) -> str:
    return f"{sum(values) / len(values):.2f}" if values else "unknown"
