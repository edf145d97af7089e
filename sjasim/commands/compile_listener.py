"""Reports the functions that Numba compiles: for about half a minute after an installation or update, then none."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

from numba.core.event import Event, Listener, install_listener


class _CompileCounter(Listener):  # type: ignore[misc]
    """Counts functions as their compilation starts. A function that is read from numba's cache is not compiled."""

    def __init__(self, report: Callable[[int], None]) -> None:
        self._report = report
        self._started = 0

    def on_start(self, event: Event) -> None:
        self._started += 1
        self._report(self._started)

    def on_end(self, event: Event) -> None:
        """Do nothing; numba requires the method."""


@contextlib.contextmanager
def on_compile(report: Callable[[int], None]) -> Iterator[None]:
    """Call ``report`` inside the block whenever a function starts compiling, with the number of functions so far."""
    with install_listener("numba:compile", _CompileCounter(report)):
        yield
