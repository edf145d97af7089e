"""Configuration of the event-level world."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TimingConfig:
    """Event-level simulation (``fidelity = timing``), which has neither bodies nor sensors.

    Attributes:
        statistics: delays, misses and false events of detectors and robot: ``measured`` (measured in simulated
            physics), or a TOML file of the same form as sjasim/assets/timing_statistics.toml.
    """

    statistics: str = "measured"
