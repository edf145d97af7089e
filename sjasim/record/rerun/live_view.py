"""A session in the viewer while it is danced."""

from __future__ import annotations

import subprocess
from collections.abc import Callable

import rerun as rr

from ...config import SessionConfig
from ...core.session_log import SessionLog
from .explanation import DelayReport
from .recording import APPLICATION, Recorder, blueprint
from .scene import Span
from .viewer import start

BLOCK_S = 1.0
"""How much session time goes to the viewer at once."""

SETTLED_S = 1.5
"""So long after they happened all events have arrived."""


class LiveView:
    """Opens a viewer on this machine and feeds it as the session goes on.

    Args:
        config: the session's.
        headless: a viewer without a window, for tests.
    """

    def __init__(self, config: SessionConfig, headless: bool = False) -> None:
        self.process: subprocess.Popen[bytes]
        self.process, self.url = start(headless=headless)
        name = f"{config.method}-{config.seed}-live"
        self._stream = rr.RecordingStream(APPLICATION, recording_id=name, send_properties=False)
        self._stream.connect_grpc(self.url, default_blueprint=blueprint({"": config}))
        self._recorder = Recorder(self._stream, config)
        self._sent_s = float("-inf")
        self._due_s = BLOCK_S

    def tick(self, now: float, log: Callable[[], SessionLog]) -> None:
        """Send another block if one is due.

        Args:
            now: session time.
            log: gives the log as it stands.
        """
        if now >= self._due_s:
            self._due_s += BLOCK_S
            self._send(log(), now - SETTLED_S)

    def finish(self, log: SessionLog, report: DelayReport) -> None:
        """Send the rest, and what can be said now that the session is over."""
        self._send(log, float("inf"))
        self._recorder.finish(report)
        self._stream.flush()

    def close(self) -> None:
        """End the viewer."""
        self._stream.disconnect()
        self.process.terminate()
        self.process.wait(10)

    def _send(self, log: SessionLog, until_s: float) -> None:
        if until_s > self._sent_s:
            self._recorder.send(log, Span(self._sent_s, until_s))
            self._sent_s = until_s
