"""Progress of a session on stderr: a bar on a terminal, elsewhere a line from time to time."""

from __future__ import annotations

import contextlib
import math
import sys
import time
from collections.abc import Iterator
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

LINE_INTERVAL_S = 20.0
"""Shortest time between two lines where there is no terminal [s]."""


class ProgressReporter(Protocol):
    """Reports what goes on while a session is prepared and simulated."""

    def compiling(self, count: int) -> None:
        """Report that the ``count``-th function starts compiling."""
        ...

    def simulating(self, share: float) -> None:
        """Report that this share of the session, 0 to 1, is done."""
        ...


class LineProgress:
    """Prints lines for a pipe or a file. A short session that compiles nothing prints none.

    Args:
        what: what goes on, in words.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._printed_s = math.inf
        """When the last line was printed; infinite before anything has happened."""

    def compiling(self, count: int) -> None:
        """See `ProgressReporter`. The first function prints a line at once."""
        if count == 1:
            self._printed_s = -math.inf
        self._print(_compiling(count))

    def simulating(self, share: float) -> None:
        """See `ProgressReporter`."""
        # The first call only starts the clock, so that a short session prints nothing.
        if self._printed_s == math.inf:
            self._printed_s = time.monotonic()
        self._print(f"{self._what}: {100.0 * share:.0f} %")

    def _print(self, text: str) -> None:
        now_s = time.monotonic()
        if now_s - self._printed_s >= LINE_INTERVAL_S:
            self._printed_s = now_s
            sys.stderr.write(f"{text}\n")
            sys.stderr.flush()


class BarProgress:
    """Shows a bar once there is something to compile or to simulate.

    Args:
        what: what goes on, in words.
        progress: the bar, not yet started.
    """

    def __init__(self, what: str, progress: Progress) -> None:
        self._what = what
        self._progress = progress
        self._task = progress.add_task(what, total=1.0)

    def compiling(self, count: int) -> None:
        """See `ProgressReporter`."""
        self._progress.start()
        self._progress.update(self._task, description=_compiling(count))

    def simulating(self, share: float) -> None:
        """See `ProgressReporter`."""
        self._progress.start()
        self._progress.update(self._task, completed=share, description=self._what)


@contextlib.contextmanager
def progress_reporter(what: str) -> Iterator[ProgressReporter]:
    """Give the reporter that fits stderr. A bar is removed at the end of the block.

    Args:
        what: what goes on, in words.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield LineProgress(what)
        return

    progress = progress_bar(console)
    try:
        yield BarProgress(what, progress)
    finally:
        if progress.live.is_started:
            progress.stop()


def progress_bar(console: Console) -> Progress:
    """A bar with a description, a percentage and the time that remains; it disappears when it is done."""
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    return Progress(*columns, TimeRemainingColumn(), console=console, transient=True)


def _compiling(count: int) -> str:
    functions = "1 function" if count == 1 else f"{count} functions"
    return f"compiling for this machine, the first time only ({functions})"
