"""Statistics of detection and execution from which the event-level world draws: delays, misses and false events.

The file ``assets/timing_statistics.toml`` holds what was measured in simulated physics; the command that made it stands
in its first lines. A file of the same form with other values, such as those of a real laboratory, is named by
``SessionConfig.timing``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ..core import Array, Kind
from ..core.errors import ConfigError

MEASURED = "measured"
"""Value of ``TimingConfig.statistics`` that stands for the file that ships with sjasim."""

QUANTILES: Array = np.linspace(0.0, 1.0, 21)
"""Shares at which a distribution of delays is given; values between them are interpolated linearly."""

DETECTED_KINDS = (
    Kind.START_FORWARD, Kind.STOP_FORWARD, Kind.START_BACKWARD, Kind.STOP_BACKWARD, Kind.CLAP,
)  # fmt: skip
"""Kinds of events that sensors detect."""

ROBOT_KINDS = (
    Kind.START_FORWARD, Kind.STOP_FORWARD, Kind.START_BACKWARD, Kind.STOP_BACKWARD, Kind.TURN,
)  # fmt: skip
"""Kinds of events of the robot."""


@dataclass(frozen=True, slots=True)
class DelayStatistics:
    """Statistics of one kind of event.

    Attributes:
        missed: probability that the event does not follow from its cause. For a stop of a dancer, the cause is a move
            whose start was detected.
        delay_s: (21,) delay of the event behind its cause at `QUANTILES` [s]; negative for most early events.
        false_per_minute: rate of such events without a cause, for each dancer.
    """

    missed: float
    delay_s: Array
    false_per_minute: float = 0.0

    def delay_at(self, share: float) -> float:
        """Delay at a share of the distribution, from 0 to 1 [s]."""
        position = share * (len(self.delay_s) - 1)
        below = min(int(position), len(self.delay_s) - 2)
        rest = position - below
        return float(self.delay_s[below]) * (1.0 - rest) + float(self.delay_s[below + 1]) * rest


@dataclass(frozen=True, slots=True)
class TimingStatistics:
    """Everything that the event-level world draws from.

    Attributes:
        regular: kind -> delay of the logged event behind the dancer's planned one.
        early: kind -> delay of the early event behind the planned one that it announces.
        robot: kind -> delay of the robot's event behind the arrival of its command.
    """

    regular: Mapping[Kind, DelayStatistics]
    early: Mapping[Kind, DelayStatistics]
    robot: Mapping[Kind, DelayStatistics]


def timing_statistics(name: str, sensing: str, layout: str) -> TimingStatistics:
    """Statistics for a session.

    Args:
        name: `MEASURED`, or a TOML file of the same form.
        sensing: source of the skeletons, a table of the file.
        layout: arrangement of the dancers, a table of the sensing's table; one without a table has that of ``square``.

    Raises:
        ConfigError: the file cannot be read, or lacks a table or a value; the message names it.
    """
    return _shared_statistics(name, sensing, layout) if name == MEASURED else _statistics_of(name, sensing, layout)


def _statistics_of(name: str, sensing: str, layout: str) -> TimingStatistics:
    """Read the statistics of a file; see `timing_statistics`."""
    data = _read(name)
    where = f"timing.statistics ({name})"
    sensing_table = data.get(sensing)
    if not isinstance(sensing_table, Mapping):
        known = ", ".join(key for key in data if key != "robot")
        raise ConfigError("sensing", sensing, f"with fidelity timing one of {known}, which {where} describes")

    table = sensing_table.get(layout, sensing_table.get("square", {}))
    return TimingStatistics(
        regular=_kinds(table.get("regular", {}), DETECTED_KINDS, f"{where}: {sensing}.regular"),
        early=_kinds(table.get("early", {}), DETECTED_KINDS[:-1], f"{where}: {sensing}.early"),
        robot=_kinds(data.get("robot", {}), ROBOT_KINDS, f"{where}: robot"),
    )


_shared_statistics = cache(_statistics_of)
"""The statistics that ship with sjasim, which sessions share."""


def _read(name: str) -> Mapping[str, Any]:
    """Content of a file of statistics."""
    try:
        if name == MEASURED:
            text = resources.files("sjasim.assets").joinpath("timing_statistics.toml").read_text("utf-8")
        else:
            text = Path(name).read_text(encoding="utf-8")
        return tomllib.loads(text)
    except OSError as error:
        allowed = f"{MEASURED}, or a readable TOML file ({error.strerror or error})"
        raise ConfigError("timing.statistics", name, allowed) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError("timing.statistics", name, f"a TOML file ({error})") from error


def _kinds(table: Mapping[str, Any], kinds: tuple[Kind, ...], where: str) -> dict[Kind, DelayStatistics]:
    """Statistics of every kind; each has its own table."""
    return {kind: _statistics(table.get(kind.value), f"{where}.{kind.value}") for kind in kinds}


def _statistics(row: Any, where: str) -> DelayStatistics:
    """Statistics of one kind, checked."""
    if not isinstance(row, Mapping):
        raise ConfigError(where, row, "a table with missed and delay_s")

    missed = row.get("missed")
    if isinstance(missed, bool) or not isinstance(missed, int | float) or not 0.0 <= missed <= 1.0:
        raise ConfigError(f"{where}.missed", missed, "a probability from 0 to 1")
    rate = row.get("false_per_minute", 0.0)
    if isinstance(rate, bool) or not isinstance(rate, int | float) or not 0.0 <= rate <= 60.0:
        raise ConfigError(f"{where}.false_per_minute", rate, "a rate from 0 to 60")

    delay_s = np.array(row.get("delay_s", ()), dtype=np.float64)
    if delay_s.shape != QUANTILES.shape or not (np.diff(delay_s) >= 0.0).all():
        raise ConfigError(f"{where}.delay_s", row.get("delay_s"), f"{len(QUANTILES)} numbers that do not fall")
    return DelayStatistics(float(missed), delay_s, float(rate))
