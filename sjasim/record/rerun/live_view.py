"""Shows a session in the viewer while it runs."""

from __future__ import annotations

import subprocess
from collections.abc import Callable

import rerun as rr

from ...config import SessionConfig
from ...core.session_log import SessionLog
from .blueprint import blueprint
from .entity_stream import Span
from .explanation import DelayReport
from .recording import APPLICATION, Recorder
from .viewer import start

BLOCK_S = 1.0
"""Session time between two transmissions to the viewer [s]."""

ARRIVAL_MARGIN_S = 1.5
"""Age from which every event of the log has arrived, so that nothing is added to a time that has been sent [s]."""


class LiveView:
    """Opens a viewer on this machine and sends it the session as it runs.

    Args:
        config: configuration of the session.
        headless: open the viewer without a window, for tests.
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
            now: session time [s].
            log: returns the log as it stands; it is called only if a block is due.
        """
        if now >= self._due_s:
            self._due_s += BLOCK_S
            self._send(log(), now - ARRIVAL_MARGIN_S)

    def finish(self, log: SessionLog, report: DelayReport) -> None:
        """Send the remaining part of the session, and the report."""
        self._send(log, float("inf"))
        self._recorder.finish(report)
        self._stream.flush()

    def close(self) -> None:
        """End the viewer."""
        self._stream.disconnect()
        self.process.terminate()
        self.process.wait(10)

    def _send(self, log: SessionLog, until_s: float) -> None:
        """Send what lies between the last transmission and a session time."""
        if until_s > self._sent_s:
            self._recorder.send(log, Span(self._sent_s, until_s))
            self._sent_s = until_s
