"""Observers of a session during its simulation: rerun viewer, video writer and depth recorder."""

from __future__ import annotations

import contextlib
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.session_log import SessionLog

if TYPE_CHECKING:
    from ..record.rerun.explanation import DelayReport
    from ..record.rerun.live_view import LiveView
    from ..session.session import Session
    from .depth_recorder import DepthRecorder
    from .video import VideoWriter


class SessionObservers:
    """Attaches observers to a session, and closes them at its end. Observers do not change the session.

    Args:
        closing: closes the viewer and removes an unfinished video, however the session ends.
        view: whether to show the session in the rerun viewer.
        video: .mp4 file to write, or None.
        log_depth: whether to keep depth images of the active sensor.
    """

    def __init__(
        self, closing: contextlib.ExitStack, *, view: bool = False, video: Path | None = None, log_depth: bool = False
    ) -> None:
        self._closing = closing
        self._view = view
        self._video = video
        self._log_depth = log_depth

        self._writer: VideoWriter | None = None
        self._depth_recorder: DepthRecorder | None = None
        self._live_view: LiveView | None = None

    def attach(self, session: Session) -> None:
        """Add the observers to a session that has not begun."""
        if self._video is not None:
            from .video import VideoWriter

            self._writer = VideoWriter(session, self._video)
            self._closing.callback(self._discard_video)
            session.world.watchers.append(self._writer.tick)

        if self._log_depth:
            from .depth_recorder import DepthRecorder

            self._depth_recorder = DepthRecorder(session)
            session.world.watchers.append(self._depth_recorder.tick)

        if self._view:
            from ..record.rerun.live_view import LiveView

            live_view = LiveView(session.config)
            self._live_view = live_view
            self._closing.callback(live_view.close)
            session.world.watchers.append(lambda now: live_view.tick(now, session.log))

    def with_depth(self, log: SessionLog) -> SessionLog:
        """The log with the depth images that were recorded."""
        return log if self._depth_recorder is None else replace(log, depth=tuple(self._depth_recorder.pictures))

    def finish(self, log: SessionLog, report: DelayReport) -> None:
        """Complete the video, and show in the viewer what is known now that the session is over."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None
            sys.stderr.write(f"video written to {self._video}\n")
        if self._live_view is not None:
            self._live_view.finish(log, report)

    def wait_until_closed(self) -> None:
        """Wait until the user closes the viewer; return at once without one."""
        if self._live_view is not None:
            sys.stderr.write("close the viewer, or press Ctrl-C, to end\n")
            self._live_view.process.wait()

    def _discard_video(self) -> None:
        """Remove a video that `finish` has not completed."""
        if self._writer is not None:
            self._writer.close(keep=False)
