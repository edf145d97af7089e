"""A session as a rerun recording: 3D scene, lanes, curves, the topology graph, texts, and a summary in words.

Values are sent as columns on the session's clock, after the session or in blocks while it runs. A recording of several
sessions has a prefix before each session's entities. The entities are:

- ``world/dancer_1``...: ``true`` joints, ``body``, joints that the active client ``tracked`` and ``inferred``,
  ``name``, ``tether`` (force of the balance support)
- ``world/robot``, ``world/trail``, ``world/sensors/north``..., ``world/floor``
- ``lanes/...``: see `timeline.lane_names`
- ``curves/group``, ``individual``, ``pairs``, ``timing``, ``delay`` [s], ``clocks`` [ms]
- ``graph``: the group topology graph of the last finished iteration
- ``depth``: depth images of the active sensor, if the session recorded them
- ``log/decisions``, ``log/notices``, ``story``: texts
- ``comparison``, without a prefix: a table of differences, and curves ``gsi`` and ``late`` of all sessions
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import rerun as rr

from ...choreography.layout import layout
from ...config import SessionConfig
from ...config.toml_file import from_plain
from ...core.errors import RecordError
from ...core.session_log import SessionLog
from .blueprint import blueprint
from .comparison import send_comparison
from .curves import log_static_graph, send_curves, send_graph
from .entity_stream import EntityStream, Span
from .explanation import DelayReport, as_markdown
from .scene import log_static_scene, send_balance_support, send_dancers, send_depth, send_robot, send_sensors
from .timeline import log_static_lanes, send_lanes, send_report_lanes, send_texts

APPLICATION = "sjasim"
"""Application id of the recordings, under which the viewer remembers a changed layout."""


def save(log: SessionLog, path: Path, report: DelayReport | None = None) -> None:
    """Write a session's recording.

    Args:
        log: the session; its ``joints`` and ``skeletons`` may be None.
        path: the .rrd file to write.
        report: delays and graphs of the session; without it, only scene, lanes of the log and texts are written.

    Raises:
        RecordError: the file cannot be written.
    """
    save_all({"": (log, report)}, path)


def save_all(sessions: Mapping[str, tuple[SessionLog, DelayReport | None]], path: Path) -> None:
    """Write several sessions into one recording, on one time axis.

    Args:
        sessions: prefix of the entities -> log and report; the prefix of a single session may be "".
        path: the .rrd file to write.

    Raises:
        RecordError: the file cannot be written.
    """
    configs = {prefix: from_plain(log.config) for prefix, (log, _) in sessions.items()}
    name = "-".join(f"{config.method}-{config.seed}" for config in configs.values())
    with_depth = any(log.depth for log, _ in sessions.values())

    stream = rr.RecordingStream(APPLICATION, recording_id=name, send_properties=False)
    stream.save(path, default_blueprint=blueprint(configs, with_depth))
    try:
        for prefix, (log, report) in sessions.items():
            recorder = Recorder(stream, configs[prefix], prefix)
            recorder.send(log)
            if report is not None:
                recorder.finish(report)
        if len(sessions) > 1:
            send_comparison(
                EntityStream(stream), {prefix: report for prefix, (_, report) in sessions.items() if report}
            )
        stream.flush()
    except RuntimeError as error:
        # rerun has no exception of its own for a file that it cannot write.
        raise RecordError(f"{path.name} cannot be written ({error}): is the disk full?") from None
    finally:
        stream.disconnect()


class Recorder:
    """Sends one session to a rerun stream, at once or in blocks.

    Args:
        stream: the stream to write to.
        config: configuration of the session.
        prefix: first part of every entity's path; "" for none.
    """

    def __init__(self, stream: rr.RecordingStream, config: SessionConfig, prefix: str = "") -> None:
        self._stream = EntityStream(stream, prefix)
        self._config = config
        self._layout = layout(config)

        log_static_scene(self._stream, config, self._layout)
        log_static_lanes(self._stream, config)

    def send(self, log: SessionLog, span: Span | None = None) -> None:
        """Send the part of a log that lies in an interval of session time; the whole log by default."""
        span = span or Span()
        send_sensors(self._stream, log, self._layout, span)
        send_dancers(self._stream, log, self._config, span)
        send_balance_support(self._stream, log, self._config, span)
        send_robot(self._stream, log, span)
        send_lanes(self._stream, log, self._config, span)
        send_texts(self._stream, log, span)
        send_depth(self._stream, log, span)

    def finish(self, report: DelayReport) -> None:
        """Send what is known once the session is over: remaining lanes, curves, graphs and the summary."""
        send_report_lanes(self._stream, report, self._config)
        send_curves(self._stream, report)

        log_static_graph(self._stream)
        for graph in report.graphs:
            send_graph(self._stream, graph)

        summary = rr.TextDocument(as_markdown(report), media_type=rr.MediaType.MARKDOWN)
        self._stream.log_static("story", summary)
