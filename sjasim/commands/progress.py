"""ProgressReporter of life on stderr while a session is danced: a bar on a terminal, elsewhere a line from time to time."""

from __future__ import annotations

import contextlib
import math
import sys
import time
from collections.abc import Iterator
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

SIGN_S = 20.0
"""Longest silence between two lines, as far as anything happens."""


class ProgressReporter(Protocol):
    """What is on_compile while a session is prepared and danced."""

    def compiling(self, begun: int) -> None:
        """The so-manieth function is being compiled."""
        ...

    def dancing(self, share: float) -> None:
        """A share of the dance, 0 to 1, is over."""
        ...


class LineProgress:
    """LineProgress for a pipe or a file; a short session that compiles nothing gives none.

    Args:
        what: what goes on, in words.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._said_s = math.inf

    def compiling(self, begun: int) -> None:
        """See `ProgressReporter`; the first function gives a line at once."""
        if begun == 1:
            self._said_s = -math.inf
        self._say(compiling(begun))

    def dancing(self, share: float) -> None:
        """See `ProgressReporter`."""
        if self._said_s == math.inf:
            self._said_s = time.monotonic()
        self._say(f"{self._what}: {100.0 * share:.0f} %")

    def _say(self, text: str) -> None:
        now_s = time.monotonic()
        if now_s - self._said_s >= SIGN_S:
            self._said_s = now_s
            sys.stderr.write(f"{text}\n")
            sys.stderr.flush()


class BarProgress:
    """A bar that appears once there is something to dance, or to compile.

    Args:
        what: what goes on, in words.
        progress: the bar, not yet shown.
    """

    def __init__(self, what: str, progress: Progress) -> None:
        self._what, self._progress = what, progress
        self._task = progress.add_task(what, total=1.0)

    def compiling(self, begun: int) -> None:
        """See `ProgressReporter`."""
        self._progress.start()
        self._progress.update(self._task, description=compiling(begun))

    def dancing(self, share: float) -> None:
        """See `ProgressReporter`."""
        self._progress.start()
        self._progress.update(self._task, completed=share, description=self._what)


@contextlib.contextmanager
def progress_reporter(what: str) -> Iterator[ProgressReporter]:
    """Whom to tell; what is left on a terminal's last line is cleared at the end.

    Args:
        what: what goes on, in words.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield LineProgress(what)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    progress = Progress(*columns, TimeRemainingColumn(), console=console, transient=True)
    try:
        yield BarProgress(what, progress)
    finally:
        if progress.live.is_started:
            progress.stop()


def compiling(begun: int) -> str:
    """What is said while functions are compiled."""
    functions = "1 function" if begun == 1 else f"{begun} functions"
    return f"compiling for this machine, the first time only ({functions})"
