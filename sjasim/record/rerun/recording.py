"""A session as a rerun recording: the room, lanes of what happened, curves, the group's graph, and the story in words.

Everything is sent by column, once the session is over or block by block while it runs, on a stream of its own and on
the session's clock. Entities, below a prefix where a recording holds several sessions:

- ``world/dancer_1``...: ``true`` joints, ``body``, joints that the active client ``tracked`` and ``inferred``, ``name``
- ``world/robot``, ``world/trail``, ``world/sensors/north``..., ``world/floor``
- ``lanes/...``: see `lanes.lane_names`
- ``curves/group``, ``pairs``, ``timing``, ``delay`` [s], ``clocks`` [ms]
- ``graph``: the group topology graph, from the close of each iteration
- ``depth``: depth images of the active sensor, where they were asked for
- ``log/decisions``, ``log/notices``, ``story``: texts
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from ...choreography.layout import layout
from ...config import SessionConfig
from ...config.toml_file import from_plain
from ...core import dancer_name
from ...core.errors import RecordError
from ...core.session_log import SessionLog
from .explanation import DelayReport
from .scene import (
    TIMELINE,
    Pen,
    Span,
    fix_scene,
    send_dancers,
    send_depth,
    send_robot,
    send_sensors,
    send_tethers,
)
from .timeline import fix_lanes, lane_names, send_lanes, send_report, send_texts

APPLICATION = "sjasim"


def save(log: SessionLog, path: Path, report: DelayReport | None = None) -> None:
    """Write a session's recording.

    Args:
        log: the session; its ``joints`` and ``skeletons`` may be None.
        path: the .rrd file.
        report: what follows from the log; without it lanes and scene alone are written.
    """
    save_all({"": (log, report)}, path)


def save_all(sessions: Mapping[str, tuple[SessionLog, DelayReport | None]], path: Path) -> None:
    """Write several sessions into one recording, on one time axis.

    Args:
        sessions: prefix of the entities -> session; a single session may have the prefix "".
        path: the .rrd file.

    Raises:
        RecordError: it cannot be written.
    """
    configs = {prefix: from_plain(log.config) for prefix, (log, _) in sessions.items()}
    name = "-".join(f"{config.method}-{config.seed}" for config in configs.values())
    stream = rr.RecordingStream(APPLICATION, recording_id=name, send_properties=False)
    with_depth = any(log.depth for log, _ in sessions.values())
    stream.save(path, default_blueprint=blueprint(configs, with_depth))
    try:
        for prefix, (log, report) in sessions.items():
            recorder = Recorder(stream, configs[prefix], prefix)
            recorder.send(log)
            if report is not None:
                recorder.finish(report)
        stream.flush()
    except RuntimeError as error:
        raise RecordError(f"{path.name} cannot be written ({error}): is the disk full?") from None
    finally:
        stream.disconnect()


class Recorder:
    """Sends one session to a stream, as far as it has come.

    Args:
        stream: where to.
        config: the session's.
        prefix: before every entity.
    """

    def __init__(self, stream: rr.RecordingStream, config: SessionConfig, prefix: str = "") -> None:
        self._pen = Pen(stream, prefix)
        self._config = config
        self._place = layout(config)
        fix_scene(self._pen, config, self._place)
        fix_lanes(self._pen, config)

    def send(self, log: SessionLog, span: Span | None = None) -> None:
        """Send what lies in a stretch of time; all of it by default."""
        span = span or Span()
        send_sensors(self._pen, log, self._place, span)
        send_dancers(self._pen, log, self._config, span)
        send_tethers(self._pen, log, self._config, span)
        send_robot(self._pen, log, span)
        send_lanes(self._pen, log, self._config, span)
        send_texts(self._pen, log, span)
        send_depth(self._pen, log, span)

    def finish(self, report: DelayReport) -> None:
        """Send what can be said once the session is over."""
        send_report(self._pen, report, self._config)


def blueprint(configs: Mapping[str, SessionConfig], with_depth: bool = False) -> rrb.Blueprint:
    """The layout of the viewer.

    Left the room, the story and the graph; right the lanes, the curves and the decisions. Several sessions stand
    side by side.
    """
    panel = rrb.TimePanel(timeline=TIMELINE, state="collapsed")
    hidden = [rrb.SelectionPanel(state="hidden"), rrb.BlueprintPanel(state="hidden")]
    (prefix, config), *others = configs.items()
    if not others:
        return rrb.Blueprint(_single(prefix, config, with_depth), panel, *hidden)
    columns = [
        rrb.Vertical(
            _room(key, own), _lanes(key, own), _indices(key), _delays(key), row_shares=[18, 58, 12, 12], name=key
        )
        for key, own in configs.items()
    ]
    return rrb.Blueprint(rrb.Horizontal(*columns), panel, *hidden)


def _single(prefix: str, config: SessionConfig, with_depth: bool) -> rrb.Horizontal:
    story = rrb.TextDocumentView(origin=_at(prefix, "story"), name="What happened")
    graph = rrb.Spatial2DView(origin=_at(prefix, "graph"), name="Synchrony of pairs, last iteration")
    curves = rrb.Grid(
        _indices(prefix),
        _plot(_at(prefix, "curves/pairs"), "Synchrony of pairs, by iteration"),
        _delays(prefix),
        rrb.Tabs(
            _plot(_at(prefix, "curves/timing"), "Timing appropriateness [s]"),
            _plot(_at(prefix, "curves/clocks"), "Clock error [ms]"),
        ),
        grid_columns=2,
    )
    texts = rrb.TextLogView(origin=_at(prefix, "log"), name="Decisions of the method, notices")
    room: rrb.View | rrb.Tabs = _room(prefix, config)
    if with_depth:
        room = rrb.Tabs(room, rrb.Spatial2DView(origin=_at(prefix, "depth"), name="What the active sensor sees"))
    left = rrb.Vertical(room, rrb.Horizontal(story, graph, column_shares=[3, 2]), row_shares=[3, 2])
    right = rrb.Vertical(_lanes(prefix, config), curves, texts, row_shares=[9, 5, 2])
    return rrb.Horizontal(left, right, column_shares=[1, 1])


def _at(prefix: str, entity: str) -> str:
    return f"/{prefix}/{entity}" if prefix else f"/{entity}"


def _named(prefix: str, name: str) -> str:
    return f"{prefix}: {name}" if prefix else name


def _room(prefix: str, config: SessionConfig) -> rrb.Spatial3DView:
    eye = rrb.EyeControls3D(position=(1.7, 3.5, 2.1), look_target=(0.0, 0.0, 0.7), eye_up=(0.0, 0.0, 1.0))
    tethers = [_at(prefix, f"world/{dancer_name(index)}/tether") for index in range(config.dancers)]
    return rrb.Spatial3DView(
        origin=_at(prefix, "world"),
        overrides={entity: rrb.EntityBehavior(visible=False) for entity in tethers},
        name=_named(prefix, f"Room ({config.method}, seed {config.seed})"),
        eye_controls=eye,
    )


def _lanes(prefix: str, config: SessionConfig) -> rrb.StateTimelineView:
    lanes: Sequence[str] = [_at(prefix, f"lanes/{name}") for name in lane_names(config)]
    return rrb.StateTimelineView(
        origin=_at(prefix, "lanes"),
        contents=lanes,
        name=_named(prefix, "Who did what when"),
        time_view=_around(12.0),
    )


def _around(half_s: float) -> rrb.TimeAxis:
    """A stretch of time about the cursor."""
    ends = [rr.TimeRangeBoundary.cursor_relative(seconds=sign * half_s) for sign in (-1.0, 1.0)]
    return rrb.TimeAxis(link=rrb.components.LinkAxis.Independent, view_range=rr.TimeRange(start=ends[0], end=ends[1]))


def _plot(origin: str, name: str) -> rrb.TimeSeriesView:
    """Curves over the whole session."""
    axis = rrb.TimeAxis(
        link=rrb.components.LinkAxis.Independent,
        view_range=rr.TimeRange(start=rr.TimeRangeBoundary.infinite(), end=rr.TimeRangeBoundary.infinite()),
    )
    return rrb.TimeSeriesView(origin=origin, name=name, axis_x=axis, plot_legend=rrb.Corner2D.LeftTop)


def _indices(prefix: str) -> rrb.TimeSeriesView:
    return _plot(_at(prefix, "curves/group"), _named(prefix, "Group synchronisation index, by iteration"))


def _delays(prefix: str) -> rrb.TimeSeriesView:
    return _plot(_at(prefix, "curves/delay"), _named(prefix, "Robot's delay behind the dancers, by part [s]"))
