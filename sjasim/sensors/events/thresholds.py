"""Thresholds of the detectors as one row of a structured array, which compiled code can read."""

from __future__ import annotations

from dataclasses import asdict, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...config import DetectorConfig

Record = Any
"""One row of a structured array. Its columns are attributes in compiled code and keys in Python."""

Records = NDArray[Any]
"""A structured array."""

THRESHOLDS = np.dtype(
    [(field.name, np.int64 if field.type == "int" else np.float64) for field in fields(DetectorConfig)]
    + [("step_frames", np.int64)]
)
"""Columns: the fields of `DetectorConfig`, and the number of frames over which the step of a joint is taken."""

REFERENCE_RATE_HZ = 30
"""Frame rate to which the frame counts of `DetectorConfig` refer; at other rates they keep their duration."""


def threshold_row(config: DetectorConfig, rate_hz: float) -> Records:
    """Return the thresholds at a frame rate.

    Args:
        config: the thresholds, with frame counts at `REFERENCE_RATE_HZ`.
        rate_hz: nominal frame rate of the sensor.

    Returns:
        (1,) row with the columns of `THRESHOLDS`; frame counts are those of ``rate_hz``.
    """
    values = asdict(config)
    step_frames = _frames_at_rate(1, rate_hz)

    # A speed must not be taken over a shorter time than a single step.
    values["difference_frames"] = max(step_frames, _frames_at_rate(config.difference_frames, rate_hz))
    values["early_frames"] = _frames_at_rate(config.early_frames, rate_hz)
    return np.array([(*values.values(), step_frames)], dtype=THRESHOLDS)


def _frames_at_rate(reference_frames: int, rate_hz: float) -> int:
    """Return the number of frames that last as long as some frames at `REFERENCE_RATE_HZ`; at least one."""
    return max(1, round(reference_frames * rate_hz / REFERENCE_RATE_HZ))
