"""Tells of functions that are being compiled: for half a minute after an installation or an update, then never."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

from numba.core.event import Event, Listener, install_listener


class _Counter(Listener):  # type: ignore[misc]
    """Counts functions as their compilation begins; what a cache holds is not compiled."""

    def __init__(self, tell: Callable[[int], None]) -> None:
        self._tell = tell
        self._begun = 0

    def on_start(self, event: Event) -> None:
        self._begun += 1
        self._tell(self._begun)

    def on_end(self, event: Event) -> None:
        """Nothing to tell."""


@contextlib.contextmanager
def on_compile(tell: Callable[[int], None]) -> Iterator[None]:
    """While this lasts, ``tell`` is called with the number of functions so far whenever one is being compiled."""
    with install_listener("numba:compile", _Counter(tell)):
        yield
