"""The detectors' thresholds as compiled code reads them: a row whose columns have names."""

from __future__ import annotations

from dataclasses import asdict, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...config import DetectorConfig

Record = Any
"""One row of a structured array: its columns are attributes, in compiled code only."""

Records = NDArray[Any]
"""A structured array."""

RULES = np.dtype(
    [(field.name, np.int64 if field.type == "int" else np.float64) for field in fields(DetectorConfig)]
    + [("step_frames", np.int64)]
)
"""`DetectorConfig`'s fields, and how many frames back a joint's single steps are taken."""

BASE_HZ = 30
"""Frame rate that the thresholds' frames are meant for; at another one they stand for the same times."""


def frames_at(rate_hz: float, frames: int) -> int:
    """How many frames of another rate last as long as so many at `BASE_HZ`; at least one."""
    return max(1, round(frames * rate_hz / BASE_HZ))


def rules(config: DetectorConfig, rate_hz: float) -> Records:
    """(1,) the thresholds at a frame rate."""
    values = asdict(config)
    step = frames_at(rate_hz, 1)
    values["difference_frames"] = max(step, frames_at(rate_hz, config.difference_frames))
    values["early_frames"] = frames_at(rate_hz, config.early_frames)
    return np.array([(*values.values(), step)], dtype=RULES)
