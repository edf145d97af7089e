"""The event table of recorded joints, and warnings about the recording."""

from __future__ import annotations

import bisect
from collections.abc import Collection
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

from ...config import DetectorConfig
from ...core import RecordedJoints
from ...core.errors import ConfigError
from ...core.text import counted
from .detect import Detected, events_of
from .interpolation import BRIDGE_S, SMOOTH_S, preprocess
from .validation import quality_warnings

COLUMNS = ("session", "iteration", "agent", "kind", "t_s", "early", "t_onset_s")
"""Columns of the event table."""

DECIMALS = 6
"""Decimals of the times: no recording has a better clock than microseconds."""


@dataclass(frozen=True)
class EventTableConfig:
    """How an event table is made of recorded joints.

    Attributes:
        session: name of the session in the event table; by default that of the file.
        iteration_starts_s: times at which iterations 0, 1, ... start; events before the first are left out. By default
            all events are of iteration 0.
        bridge_s: longest gap of a joint that is interpolated; 0 interpolates none.
        smooth_s: width over which the joints of the trunk are smoothed; 0 smooths nothing.
        detectors: thresholds of the detectors.
    """

    session: str | None = None
    iteration_starts_s: tuple[float, ...] = ()
    bridge_s: float = BRIDGE_S
    smooth_s: float = SMOOTH_S
    detectors: DetectorConfig = field(default_factory=DetectorConfig)

    def __post_init__(self) -> None:
        if not all(before < after for before, after in pairwise(self.iteration_starts_s)):
            raise ConfigError("iteration_starts_s", self.iteration_starts_s, "times that rise")
        if self.session is not None and not self.session.strip():
            raise ConfigError("session", self.session, "a name")


class EventTable(NamedTuple):
    """Events of a recording as rows.

    Attributes:
        rows: by the names of `COLUMNS`, in order of time.
        warnings: what keeps events from being found, and which events have no row; one line each.
    """

    rows: list[dict[str, Any]]
    warnings: list[str]


def event_table(recording: RecordedJoints, config: EventTableConfig, file_name: str) -> EventTable:
    """Detect the events of a recording.

    Args:
        recording: the joints, as `detect.recording` checks them.
        config: how the table is made.
        file_name: what the table calls the session if the configuration does not name it.

    Raises:
        ConfigError: a duration is out of range.
    """
    joints = preprocess(recording, config.bridge_s, config.smooth_s)
    events = events_of(joints, config.detectors)
    rows = _rows(events, config, config.session or file_name)
    return EventTable(rows, quality_warnings(joints) + _table_warnings(joints, events, rows))


def _rows(events: Collection[Detected], config: EventTableConfig, session: str) -> list[dict[str, Any]]:
    """Rows of the events that do not precede the first iteration."""
    starts_s = config.iteration_starts_s or (float("-inf"),)
    rows = []
    for event in events:
        iteration = bisect.bisect_right(starts_s, event.t_s) - 1
        if iteration < 0:
            continue
        onset_s = None if event.t_onset_s is None else round(event.t_onset_s, DECIMALS)
        time_s = round(event.t_s, DECIMALS)
        values = (session, iteration, event.person, event.kind.value, time_s, event.early, onset_s)
        rows.append(dict(zip(COLUMNS, values, strict=True)))
    return rows


def _table_warnings(joints: RecordedJoints, events: Collection[Detected], rows: Collection[object]) -> list[str]:
    """Warnings of a table that is empty, or lacks events before the first iteration."""
    warnings = []
    if not events:
        frames = counted(len(joints.t_s), "frame")
        warnings.append(f"no events in {frames} of {counted(len(joints.persons), 'person')}")
    if len(rows) < len(events):
        warnings.append(f"left out: {counted(len(events) - len(rows), 'event')} before the first iteration starts")
    return warnings
