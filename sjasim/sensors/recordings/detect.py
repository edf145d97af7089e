"""Events of recorded joints: the detectors on skeletons from anywhere, such as a laboratory's own Kinect."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...config import DetectorConfig
from ...core import INFERRED, NOT_TRACKED, TRACKED, Array, Kind, RecordedJoints, SkeletonFrame, Skeletons
from ...core.errors import RecordError
from ..events.detectors import EventDetector
from .interpolation import BRIDGE_S, SMOOTH_S, preprocess
from .validation import check_units


class Detected(NamedTuple):
    """An event of a recording.

    Attributes:
        t_s: time of the frame that shows it; never back-dated. In a preprocess recording frames a little later have their
            part in what it shows.
        person: as the recording names them.
        kind: what happened.
        early: whether it is an early event.
        t_onset_s: estimated onset, or None.
    """

    t_s: float
    person: int | str
    kind: Kind
    early: bool
    t_onset_s: float | None


def detect_events(
    t_s: Sequence[float] | Array,
    joints_m: Array,
    state: np.typing.ArrayLike | None = None,
    persons: Sequence[int] | Sequence[str] | NDArray[np.generic] | None = None,
    config: DetectorConfig | None = None,
    *,
    bridge_s: float = BRIDGE_S,
    smooth_s: float = SMOOTH_S,
) -> list[Detected]:
    """Run the detectors on recorded skeletons. Frames may be missing and unevenly spaced, at any rate.

    Args:
        t_s: (T,) rising times of the frames [s].
        joints_m: (T, P, 25, 3) or (T, 25, 3) joints in the Kinect's camera space: x to the sensor's left, y up, z
            away from it, in the order of `assets.names.JOINTS` [m]; NaN, or the sensor's own place 0, 0, 0, where a
            joint is unknown.
        state: (T, P, 25) or (T, 25) tracking states, 2 tracked, 1 inferred, 0 not tracked; by default tracked where
            the joint is known.
        persons: (P,) names of the rows, numbers or words; by default 0, 1, ...
        config: thresholds.
        bridge_s: gaps of a joint no longer than this are bridged, see `mending`; 0 bridges none, as live.
        smooth_s: width over which trunks are smoothed, see there; 0 smooths nothing, as live.

    Returns:
        the events in order of time; none from fewer than two frames.

    Raises:
        RecordError: shapes do not fit together, times do not rise, a state is not a code, or units cannot be right.
        ConfigError: ``bridge_s`` or ``smooth_s`` is out of range.
    """
    return events_of(
        preprocess(recording(t_s, joints_m, state, persons), bridge_s, smooth_s), config or DetectorConfig()
    )


def recording(
    t_s: Sequence[float] | Array,
    joints_m: Array,
    state: np.typing.ArrayLike | None = None,
    persons: Sequence[int] | Sequence[str] | NDArray[np.generic] | None = None,
) -> RecordedJoints:
    """Recorded skeletons, checked; arguments and errors as in `detect_events`."""
    times, joints = np.asarray(t_s, dtype=np.float64), np.array(joints_m, dtype=np.float64)
    if joints.ndim == 3:
        joints = joints[:, None]
    if joints.shape[:1] != times.shape or joints.ndim != 4 or joints.shape[2:] != (len(JOINTS), 3):
        raise RecordError(f"joints of shape {np.shape(joints_m)} for {len(times)} times: wanted (T, P, 25, 3)")
    if not np.all(np.isfinite(times)) or np.any(np.diff(times) <= 0.0):
        raise RecordError("times must be finite and rise from frame to frame")
    known = np.isfinite(joints).all(axis=3) & joints.any(axis=3)
    codes = np.where(known, TRACKED, NOT_TRACKED) if state is None else np.asarray(state).reshape(known.shape)
    if not np.isin(codes, (NOT_TRACKED, INFERRED, TRACKED)).all():
        raise RecordError("states must be 2 (tracked), 1 (inferred) or 0 (not tracked)")
    codes = np.where(known, codes, NOT_TRACKED).astype(np.int8)
    joints[codes == NOT_TRACKED] = np.nan
    rows = np.arange(joints.shape[1]) if persons is None else np.asarray(persons)
    if rows.shape != joints.shape[1:2]:
        raise RecordError(f"{len(rows)} names for {joints.shape[1]} persons")
    whole = RecordedJoints(times, joints, codes, rows)
    check_units(whole)
    return whole


def events_of(recording: RecordedJoints, config: DetectorConfig) -> list[Detected]:
    """The detectors' events in order of time; none from fewer than two frames."""
    times, joints, codes, persons = recording
    if len(times) < 2:
        return []
    detectors = EventDetector(config, 1.0 / float(np.median(np.diff(times))))
    names: list[int | str] = persons.tolist()
    rows = np.arange(len(names))
    found: list[Detected] = []
    for time, points, codes_now in zip(times.tolist(), joints, codes, strict=True):
        frame = SkeletonFrame("recording", time, time, time, Skeletons(rows, points, codes_now))
        found += [Detected(one.t_device_s, names[one.person], one.kind, one.early, one.t_onset_device_s)
                  for one in detectors.update(frame)]  # fmt: skip
    return found
