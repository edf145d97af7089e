"""Events of recorded joints: the detectors on skeletons from anywhere, such as a laboratory's own Kinect."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .assets.names import JOINTS
from .config import DetectorConfig
from .errors import RecordError
from .sensors.detectors import Detectors
from .types import INFERRED, NOT_TRACKED, TRACKED, Array, IntArray, Kind, SkeletonFrame, Skeletons


class Detected(NamedTuple):
    """An event of a recording.

    Attributes:
        t_s: time of the frame that shows it; never back-dated.
        person: as the recording names them.
        kind: what happened.
        early: whether it is an early event.
        t_onset_s: estimated onset, or None.
    """

    t_s: float
    person: int
    kind: Kind
    early: bool
    t_onset_s: float | None


def detect_events(
    t_s: Sequence[float] | Array,
    joints_m: Array,
    state: np.typing.ArrayLike | None = None,
    persons: Sequence[int] | IntArray | None = None,
    config: DetectorConfig | None = None,
) -> list[Detected]:
    """Run the detectors on recorded skeletons. Frames may be missing and unevenly spaced, at any rate.

    Args:
        t_s: (T,) rising times of the frames [s].
        joints_m: (T, P, 25, 3) or (T, 25, 3) joints in the Kinect's camera space: x to the sensor's left, y up, z
            away from it, in the order of `assets.names.JOINTS` [m]; NaN where a joint is unknown.
        state: (T, P, 25) or (T, 25) tracking states, 2 tracked, 1 inferred, 0 not tracked; by default tracked where
            the joint is known.
        persons: (P,) names of the rows; by default 0, 1, ...
        config: thresholds.

    Returns:
        the events in order of time; none from fewer than two frames.

    Raises:
        RecordError: shapes do not fit together, times do not rise, or a state is not a code.
    """
    times, joints = np.asarray(t_s, dtype=np.float64), np.array(joints_m, dtype=np.float64)
    if joints.ndim == 3:
        joints = joints[:, None]
    if joints.shape[:1] != times.shape or joints.ndim != 4 or joints.shape[2:] != (len(JOINTS), 3):
        raise RecordError(f"joints of shape {np.shape(joints_m)} for {len(times)} times: wanted (T, P, 25, 3)")
    rising = np.diff(times)
    if not np.all(np.isfinite(times)) or np.any(rising <= 0.0):
        raise RecordError("times must be finite and rise from frame to frame")
    known = np.isfinite(joints).all(axis=3)
    codes = np.where(known, TRACKED, NOT_TRACKED) if state is None else np.asarray(state).reshape(known.shape)
    if not np.isin(codes, (NOT_TRACKED, INFERRED, TRACKED)).all():
        raise RecordError("states must be 2 (tracked), 1 (inferred) or 0 (not tracked)")
    codes = np.where(known, codes, NOT_TRACKED).astype(np.int8)
    joints[codes == NOT_TRACKED] = np.nan
    rows = np.arange(joints.shape[1]) if persons is None else np.asarray(persons, dtype=np.int64)
    if rows.shape != joints.shape[1:2]:
        raise RecordError(f"{len(rows)} names for {joints.shape[1]} persons")
    if len(times) < 2:
        return []
    detectors = Detectors(config or DetectorConfig(), 1.0 / float(np.median(rising)))
    found: list[Detected] = []
    for time, points, codes_now in zip(times.tolist(), joints, codes, strict=True):
        frame = SkeletonFrame("recording", time, time, time, Skeletons(rows, points, codes_now))
        found += [Detected(one.t_device_s, one.person, one.kind, one.early, one.t_onset_device_s)
                  for one in detectors.update(frame)]  # fmt: skip
    return found
