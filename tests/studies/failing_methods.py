"""Anticipation methods that fail, for tests of studies."""

from __future__ import annotations

import os
import signal
from pathlib import Path


class FailsSometimes:
    """Raises in about a third of the sessions."""

    def reset(self, context, rng):
        self.fails = rng.random() < 1 / 3

    def on_event(self, event):
        return ()

    def on_iteration_start(self, iteration, t_s):
        if self.fails:
            raise RuntimeError("no idea\nwhat to do")
        return ()

    def on_iteration_end(self, iteration, t_s):
        return ()

    def on_timer(self, t_s):
        return ()


class KillsItsWorker(FailsSometimes):
    """Kills its process the first time, before the file that SJASIM_TEST_MARK names exists; later it does nothing."""

    def on_iteration_start(self, iteration, t_s):
        mark = Path(os.environ["SJASIM_TEST_MARK"])
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return ()


class AlwaysKillsItsWorker(FailsSometimes):
    """Kills its process in every session."""

    def on_iteration_start(self, iteration, t_s):
        os.kill(os.getpid(), signal.SIGKILL)
        return ()
