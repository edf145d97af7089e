"""Errors of the sensor clients' clocks."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class ClockConfig:
    """Errors of the sensor clients' clocks.

    Attributes:
        max_offset_s: largest initial offset from the server's clock [s]; positive and negative offsets up to it are
            equally probable.
        max_skew: largest relative rate error (quartz of a PC: about 50e-6); positive and negative errors up to it are
            equally probable.
    """

    max_offset_s: float = 0.5
    max_skew: float = 50e-6

    def __post_init__(self) -> None:
        within("clocks.max_offset_s", self.max_offset_s, 0.0, 3600.0)
        within("clocks.max_skew", self.max_skew, 0.0, 1e-3)
