"""Price of a study before it starts: computing time and room on disk."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..choreography.timetable import timetable
from ..config import HUMANS_ONLY, SessionConfig
from ..core.errors import RecordError
from .design_checks import one_session_of_each_condition
from .study_design import StudyPlan

CPU_S_PER_MINUTE: Mapping[tuple[str, str], float] = {
    ("timing", "joints"): 0.008,
    ("timing", "depth"): 0.008,
    ("physics", "joints"): 1.8,
    ("physics", "depth"): 13.0,
}
"""(fidelity, sensing) -> computing time of a session per minute of three dancers [s], rounded from docs/figures.md."""

BYTES_PER_EVENT = 12.0
"""Room on disk for an event in the tables of a study [bytes]."""

BYTES_PER_SESSION = 500.0
"""Room on disk for a session without its events [bytes]."""

COPIES = 2.5
"""Largest number of copies of the tables that are on disk at once: parts, which are less compressed, and tables."""


@dataclass(frozen=True, slots=True)
class Price:
    """What a study costs.

    Attributes:
        sessions: number of sessions.
        cpu_s: computing time of all sessions on one core [s].
        disk_bytes: room on disk while the study runs [bytes].
    """

    sessions: int
    cpu_s: float
    disk_bytes: float

    def text(self, jobs: int) -> str:
        """The price in words, for a number of processes."""
        plural = "" if jobs == 1 else "es"
        return (
            f"{self.sessions:,} sessions: about {duration_text(self.cpu_s / jobs)} on {jobs} process{plural}, "
            f"{size_text(self.disk_bytes)} on disk"
        )


def price(plan: StudyPlan) -> Price:
    """Estimate the price of a study from the mean over one session of each condition."""
    specs = one_session_of_each_condition(plan)
    share = len(plan) / len(specs)
    cpu_s = sum(session_cpu_s(spec.config) for spec in specs) * share
    disk_bytes = sum(_session_bytes(spec.config, plan.design.events) for spec in specs) * share
    return Price(len(plan), cpu_s, COPIES * disk_bytes)


def session_cpu_s(config: SessionConfig) -> float:
    """Estimate the computing time of a session on one core [s]."""
    minutes = timetable(config).end_s() / 60.0
    per_minute_s = CPU_S_PER_MINUTE.get((config.fidelity, config.sensing), CPU_S_PER_MINUTE["physics", "joints"])
    return minutes * per_minute_s * config.dancers / 3.0


def check_room(needed: Price, folder: Path) -> None:
    """Refuse a study whose tables do not fit on the disk of a folder.

    Args:
        needed: price of the study.
        folder: where it is written; it need not exist.

    Raises:
        RecordError: there is less room than the study needs.
    """
    existing = next(place for place in (folder, *folder.parents) if place.is_dir())
    free = shutil.disk_usage(existing).free
    if needed.disk_bytes > free:
        raise RecordError(
            f"{needed.sessions:,} sessions need {size_text(needed.disk_bytes)} on disk, and {folder} has "
            f"{size_text(free)}: take fewer groups, --no-events or another --out"
        )


def duration_text(seconds: float) -> str:
    """A duration in the unit that fits it, such as ``3 min``."""
    for unit, length_s in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * length_s:
            return f"{seconds / length_s:.0f} {unit}"
    return f"{max(seconds, 1.0):.0f} s"


def size_text(size: float) -> str:
    """A number of bytes in the unit that fits it, such as ``12 MB``."""
    for unit, length in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if size >= length:
            return f"{size / length:.1f} {unit}" if size < 10.0 * length else f"{size / length:.0f} {unit}"
    return f"{max(size / 1e3, 1.0):.0f} kB"


def _session_bytes(config: SessionConfig, events: bool) -> float:
    """Room on disk for the rows of a session in one copy of the tables [bytes]."""
    robots = 0 if config.method == HUMANS_ONLY else 1
    steps = len(timetable(config).choreography.steps())
    count = config.iterations * steps * (config.dancers + robots) if events else 0
    return BYTES_PER_SESSION + BYTES_PER_EVENT * count
