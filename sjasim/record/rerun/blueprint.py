"""Layout of the viewer for one session, or for several side by side.

To add a view: write a function that returns it, and place it in `_single_session` or `_compact_session`.
"""

from __future__ import annotations

from collections.abc import Mapping

import rerun as rr
import rerun.blueprint as rrb

from ...config import SessionConfig
from ...core import dancer_name
from .entity_stream import TIMELINE
from .timeline import lane_names

LANES_HALF_WIDTH_S = 12.0
"""Time that the lanes show before and after the cursor [s]."""


def blueprint(configs: Mapping[str, SessionConfig], with_depth: bool = False) -> rrb.Blueprint:
    """Layout of the viewer.

    A single session has the scene, the summary and the graph on the left; lanes, curves and decisions on the right.
    Several sessions stand side by side, each with fewer views.

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

    columns = [_compact_session(prefix, config) for prefix, config in configs.items()]
    return rrb.Blueprint(rrb.Horizontal(*columns), *panels)


def _single_session(prefix: str, config: SessionConfig, with_depth: bool) -> rrb.Horizontal:
    """All views of one session."""
    scene: rrb.View | rrb.Tabs = _scene(prefix, config)
    if with_depth:
        scene = rrb.Tabs(
            scene, rrb.Spatial2DView(origin=_path(prefix, "depth"), name="Depth image of the active sensor")
        )
    summary = rrb.TextDocumentView(origin=_path(prefix, "story"), name="What happened")
    graph = rrb.Spatial2DView(origin=_path(prefix, "graph"), name="Synchrony of pairs, last iteration")
    left = rrb.Vertical(scene, rrb.Horizontal(summary, graph, column_shares=[3, 2]), row_shares=[3, 2])

    curves = rrb.Grid(
        _group_indices(prefix),
        _plot(_path(prefix, "curves/pairs"), "Synchrony of pairs, by iteration"),
        _delays(prefix),
        rrb.Tabs(
            _plot(_path(prefix, "curves/timing"), "Timing appropriateness [s]"),
            _plot(_path(prefix, "curves/clocks"), "Clock error [ms]"),
        ),
        grid_columns=2,
    )
    texts = rrb.TextLogView(origin=_path(prefix, "log"), name="Decisions of the method, notices")
    right = rrb.Vertical(_lanes(prefix, config), curves, texts, row_shares=[9, 5, 2])

    return rrb.Horizontal(left, right, column_shares=[1, 1])


def _compact_session(prefix: str, config: SessionConfig) -> rrb.Vertical:
    """The views of one session among several."""
    return rrb.Vertical(
        _scene(prefix, config),
        _lanes(prefix, config),
        _group_indices(prefix),
        _delays(prefix),
        row_shares=[18, 58, 12, 12],
        name=prefix,
    )


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


def _lanes(prefix: str, config: SessionConfig) -> rrb.StateTimelineView:
    """The lanes, in a window of time about the cursor."""
    ends = [rr.TimeRangeBoundary.cursor_relative(seconds=sign * LANES_HALF_WIDTH_S) for sign in (-1.0, 1.0)]
    axis = rrb.TimeAxis(link=rrb.components.LinkAxis.Independent, view_range=rr.TimeRange(start=ends[0], end=ends[1]))
    return rrb.StateTimelineView(
        origin=_path(prefix, "lanes"),
        contents=[_path(prefix, f"lanes/{name}") for name in lane_names(config)],
        name=_title(prefix, "Who did what when"),
        time_view=axis,
    )


def _group_indices(prefix: str) -> rrb.TimeSeriesView:
    """Plot of the group synchronisation indices."""
    return _plot(_path(prefix, "curves/group"), _title(prefix, "Group synchronisation index, by iteration"))


def _delays(prefix: str) -> rrb.TimeSeriesView:
    """Plot of the robot's delays."""
    return _plot(_path(prefix, "curves/delay"), _title(prefix, "Robot's delay behind the dancers, by part [s]"))


def _plot(origin: str, name: str) -> rrb.TimeSeriesView:
    """Curves over the whole session."""
    axis = rrb.TimeAxis(
        link=rrb.components.LinkAxis.Independent,
        view_range=rr.TimeRange(start=rr.TimeRangeBoundary.infinite(), end=rr.TimeRangeBoundary.infinite()),
    )
    return rrb.TimeSeriesView(origin=origin, name=name, axis_x=axis, plot_legend=rrb.Corner2D.LeftTop)


def _path(prefix: str, entity: str) -> str:
    """Absolute path of an entity."""
    return f"/{prefix}/{entity}" if prefix else f"/{entity}"


def _title(prefix: str, name: str) -> str:
    """Title of a view, with the prefix of its session."""
    return f"{prefix}: {name}" if prefix else name
