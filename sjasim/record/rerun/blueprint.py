"""Layout of the viewer for one session, or for several side by side.

To add a view: write a function that returns it, and place it in `_single_session` or `_several_sessions`.
"""

from __future__ import annotations

from collections.abc import Mapping

import rerun as rr
import rerun.blueprint as rrb

from ...config import SessionConfig
from ...core import dancer_name
from .entity_stream import TIMELINE
from .timeline import lane_names

HALF_WIDTH_S = 8.2
"""Time that the lanes of a single session show before and after the cursor [s]."""

COMPACT_HALF_WIDTH_S = 5.2
"""The same for a session among several, whose lanes have two thirds of that width [s]."""

LANE_PIXELS = 40
LANES_MARGIN_PIXELS = 64
VIEWPORT_PIXELS = 1015
"""Height of a lane, of title and axis above the lanes, and of all views in a window of 1920 x 1080."""

UNIT_RANGE = (0.0, 1.1)
"""Range of the axes of synchrony, so that plots of different sessions can be compared; a label fits at 1."""


def blueprint(configs: Mapping[str, SessionConfig], with_depth: bool = False) -> rrb.Blueprint:
    """Layout of the viewer.

    A single session has the scene, the texts and the graph on the left, lanes and curves on the right. Several sessions
    stand side by side, each with fewer views, beside what compares them.

    Args:
        configs: prefix of a session's entities -> its configuration.
        with_depth: whether a single session has depth images.
    """
    panels = [
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
    ]
    if len(configs) == 1:
        ((prefix, config),) = configs.items()
        return rrb.Blueprint(_single_session(prefix, config, with_depth), *panels)

    return rrb.Blueprint(_several_sessions(configs), *panels)


def _single_session(prefix: str, config: SessionConfig, with_depth: bool) -> rrb.Horizontal:
    """All views of one session."""
    scene: rrb.View | rrb.Tabs = _scene(prefix, config)
    if with_depth:
        scene = rrb.Tabs(
            scene, rrb.Spatial2DView(origin=_path(prefix, "depth"), name="Depth image of the active sensor")
        )
    texts = rrb.Tabs(
        rrb.TextDocumentView(origin=_path(prefix, "story"), name="What happened"),
        rrb.TextLogView(origin=_path(prefix, "log"), name="Decisions of the method, notices"),
    )
    graph = rrb.Spatial2DView(origin=_path(prefix, "graph"), name="Synchrony of pairs, last iteration")
    left = rrb.Vertical(scene, rrb.Horizontal(texts, graph, column_shares=[3, 2]), row_shares=[3, 2])

    # The lanes get the height that they need, as far as there is some; the plots need space for their legends.
    lanes_pixels = min(LANES_MARGIN_PIXELS + LANE_PIXELS * len(lane_names(config)), 0.7 * VIEWPORT_PIXELS)
    right = rrb.Vertical(
        _lanes(prefix, config, HALF_WIDTH_S),
        _curves(prefix),
        row_shares=[lanes_pixels, VIEWPORT_PIXELS - lanes_pixels],
    )
    return rrb.Horizontal(left, right, column_shares=[1, 1])


def _curves(prefix: str) -> rrb.Vertical:
    """The plots of one session; the lower ones are higher, since the delays have the longest legend."""
    synchrony = rrb.Horizontal(
        _plot(_path(prefix, "curves/group"), "Group synchronisation index, by iteration", UNIT_RANGE),
        rrb.Tabs(
            _plot(_path(prefix, "curves/individual"), "Individual synchronisation index", UNIT_RANGE),
            _plot(_path(prefix, "curves/pairs"), "Synchrony of pairs", UNIT_RANGE),
        ),
    )
    timing = rrb.Horizontal(
        _delays(prefix),
        rrb.Tabs(
            _plot(_path(prefix, "curves/timing"), "Timing appropriateness [s]"),
            _plot(_path(prefix, "curves/clocks"), "Clock error [ms]"),
        ),
    )
    return rrb.Vertical(synchrony, timing, row_shares=[2, 3])


def _several_sessions(configs: Mapping[str, SessionConfig]) -> rrb.Horizontal:
    """A column for each session, and one in which all of them are compared on common axes."""
    sessions = [
        rrb.Vertical(
            _scene(prefix, config),
            rrb.Tabs(_lanes(prefix, config, COMPACT_HALF_WIDTH_S), _delays(prefix)),
            row_shares=[2, 3],
            name=prefix,
        )
        for prefix, config in configs.items()
    ]
    comparison = rrb.Vertical(
        rrb.TextDocumentView(origin="/comparison/table", name="Differences, and what happened"),
        rrb.Horizontal(
            _plot("/comparison/gsi", "GSI, full edges, by iteration", UNIT_RANGE),
            _plot("/comparison/late", "Robot behind the dancers [s]"),
        ),
        row_shares=[4, 1],
    )
    return rrb.Horizontal(*sessions, comparison, column_shares=[*(5 for _ in sessions), 6])


def _scene(prefix: str, config: SessionConfig) -> rrb.Spatial3DView:
    """The 3D view; forces of the balance support are hidden until somebody shows them."""
    camera = rrb.EyeControls3D(position=(1.7, 3.5, 2.1), look_target=(0.0, 0.0, 0.7), eye_up=(0.0, 0.0, 1.0))
    forces = [_path(prefix, f"world/{dancer_name(index)}/tether") for index in range(config.dancers)]
    return rrb.Spatial3DView(
        origin=_path(prefix, "world"),
        overrides={entity: rrb.EntityBehavior(visible=False) for entity in forces},
        name=_title(prefix, f"Scene ({config.method}, seed {config.seed})"),
        eye_controls=camera,
    )


def _lanes(prefix: str, config: SessionConfig, half_width_s: float) -> rrb.StateTimelineView:
    """The lanes, in a window of time about the cursor."""
    ends = [rr.TimeRangeBoundary.cursor_relative(seconds=sign * half_width_s) for sign in (-1.0, 1.0)]
    axis = rrb.TimeAxis(link=rrb.components.LinkAxis.Independent, view_range=rr.TimeRange(start=ends[0], end=ends[1]))
    return rrb.StateTimelineView(
        origin=_path(prefix, "lanes"),
        contents=[_path(prefix, f"lanes/{name}") for name in lane_names(config)],
        name=_title(prefix, "Who did what when"),
        time_view=axis,
    )


def _delays(prefix: str) -> rrb.TimeSeriesView:
    """Plot of the robot's delays."""
    return _plot(_path(prefix, "curves/delay"), _title(prefix, "Robot's delay behind the dancers, by part [s]"))


def _plot(origin: str, name: str, value_range: tuple[float, float] | None = None) -> rrb.TimeSeriesView:
    """Curves over the whole session; the range of the values follows the data by default."""
    axis = rrb.TimeAxis(
        link=rrb.components.LinkAxis.Independent,
        view_range=rr.TimeRange(start=rr.TimeRangeBoundary.infinite(), end=rr.TimeRangeBoundary.infinite()),
    )
    values = rrb.ScalarAxis(range=value_range) if value_range else None
    return rrb.TimeSeriesView(origin=origin, name=name, axis_x=axis, axis_y=values, plot_legend=rrb.Corner2D.LeftTop)


def _path(prefix: str, entity: str) -> str:
    """Absolute path of an entity."""
    return f"/{prefix}/{entity}" if prefix else f"/{entity}"


def _title(prefix: str, name: str) -> str:
    """Title of a view, with the prefix of its session."""
    return f"{prefix}: {name}" if prefix else name
