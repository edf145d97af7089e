"""Writes entities of one session to a rerun stream: static values, and columns on the session's clock."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

Floats = NDArray[np.floating]

TIMELINE = "session_time"
"""Name of the time axis in recordings."""

AMBER = (240, 168, 13)
GREEN = (60, 200, 90)
GREY = (120, 120, 125)
MAGENTA = (220, 40, 160)
RED = (200, 40, 40)
WHITE = (245, 245, 245)


@dataclass(frozen=True, slots=True)
class Span:
    """An interval of session time: later than ``since_s``, up to and including ``until_s`` [s]."""

    since_s: float = -np.inf
    until_s: float = np.inf

    def contains(self, t_s: float) -> bool:
        """Whether a time lies in the interval."""
        return self.since_s < t_s <= self.until_s

    def rows(self, t_s: Floats) -> NDArray[np.intp]:
        """Indices of the times in the interval."""
        return np.flatnonzero((t_s > self.since_s) & (t_s <= self.until_s))


@dataclass(frozen=True, slots=True)
class EntityStream:
    """A rerun stream with a prefix before every entity, so that one recording can hold several sessions.

    Attributes:
        stream: the stream to write to.
        prefix: first part of every entity's path; "" for none.
    """

    stream: rr.RecordingStream
    prefix: str = ""

    def path(self, entity: str) -> str:
        """Full path of an entity."""
        return f"{self.prefix}/{entity}" if self.prefix else entity

    def log_static(self, entity: str, *values: object) -> None:
        """Log values that hold at all times."""
        self.stream.log(self.path(entity), *values, static=True)

    def send_columns(self, entity: str, t_s: Floats | list[float], columns: Iterable[Any]) -> None:
        """Send columns of values, one row for each time.

        Args:
            entity: path of the entity below the prefix.
            t_s: session time of each row [s]; nothing is sent if there are none.
            columns: from the ``columns`` method of an archetype.
        """
        times = np.asarray(t_s, dtype=np.float64)
        if len(times):
            self.stream.send_columns(self.path(entity), [rr.TimeColumn(TIMELINE, duration=times)], columns)
