"""Errors of the sensor clients' clocks."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class ClockConfig:
    """Errors of the sensor clients' clocks.

    Attributes:
        max_offset_s: largest offset from the server's clock at the start [s]; drawn uniformly in both directions.
        max_skew: largest relative rate error; drawn uniformly in both directions (quartz of a PC: about 50e-6).
    """

    max_offset_s: float = 0.5
    max_skew: float = 50e-6

    def __post_init__(self) -> None:
        within("clocks.max_offset_s", self.max_offset_s, 0.0, 3600.0)
        within("clocks.max_skew", self.max_skew, 0.0, 1e-3)
