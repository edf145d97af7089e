"""Detection of events in recorded joints of any sensor, such as the Kinect of a laboratory."""

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
    """An event in a recording.

    Attributes:
        t_s: time of the frame that shows the event. In a smoothed recording this frame also depends on later ones.
        person: the person, as the recording names them.
        kind: what happened.
        early: whether it is an early event.
        t_onset_s: estimated onset; None for early events.
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
    """Detect starts, stops and claps in recorded skeletons.

    Frames may come at any rate, unevenly, and some may be missing.

    Args:
        t_s: (T,) rising times of the frames [s].
        joints_m: (T, P, 25, 3) or (T, 25, 3) joints in the Kinect's camera space: x to the sensor's left, y up, z
            away from it, in the order of `assets.names.JOINTS` [m]. An unknown joint is NaN, or 0, 0, 0, which is the
            place of the sensor itself.
        state: (T, P, 25) or (T, 25) tracking states, 2 tracked, 1 inferred, 0 not tracked; by default each known joint
            is tracked.
        persons: (P,) names of the persons, numbers or words; by default 0, 1, ...
        config: thresholds of the detectors.
        bridge_s: longest gap of a joint that is interpolated; 0 interpolates none, as in a live session.
        smooth_s: width of the window over which trunks are smoothed; 0 smooths nothing, as in a live session.

    Returns:
        the events in the order of their times; none if there are fewer than two frames.

    Raises:
        RecordError: shapes do not fit together, times do not rise, a state has no meaning, or units cannot be right.
        ConfigError: ``bridge_s`` or ``smooth_s`` is out of range.
    """
    recorded = preprocess(recording(t_s, joints_m, state, persons), bridge_s, smooth_s)
    return events_of(recorded, config or DetectorConfig())


def recording(
    t_s: Sequence[float] | Array,
    joints_m: Array,
    state: np.typing.ArrayLike | None = None,
    persons: Sequence[int] | Sequence[str] | NDArray[np.generic] | None = None,
) -> RecordedJoints:
    """Return checked arrays of recorded skeletons; arguments and errors are those of `detect_events`."""
    times = np.asarray(t_s, dtype=np.float64)
    joints = np.array(joints_m, dtype=np.float64)
    if joints.ndim == 3:
        joints = joints[:, None]
    if joints.shape[:1] != times.shape or joints.ndim != 4 or joints.shape[2:] != (len(JOINTS), 3):
        raise RecordError(f"joints of shape {np.shape(joints_m)} for {len(times)} times: wanted (T, P, 25, 3)")
    if not np.all(np.isfinite(times)) or np.any(np.diff(times) <= 0.0):
        raise RecordError("times must be finite and rise from frame to frame")

    # The place 0, 0, 0 is how some recorders write an unknown joint.
    known = np.isfinite(joints).all(axis=3) & joints.any(axis=3)
    states = np.where(known, TRACKED, NOT_TRACKED) if state is None else np.asarray(state).reshape(known.shape)
    if not np.isin(states, (NOT_TRACKED, INFERRED, TRACKED)).all():
        raise RecordError("states must be 2 (tracked), 1 (inferred) or 0 (not tracked)")
    states = np.where(known, states, NOT_TRACKED).astype(np.int8)
    joints[states == NOT_TRACKED] = np.nan

    names = np.arange(joints.shape[1]) if persons is None else np.asarray(persons)
    if names.shape != joints.shape[1:2]:
        raise RecordError(f"{len(names)} names for {joints.shape[1]} persons")

    recorded = RecordedJoints(times, joints, states, names)
    check_units(recorded)
    return recorded


def events_of(recording: RecordedJoints, config: DetectorConfig) -> list[Detected]:
    """Return the events of a recording in the order of their times; none if there are fewer than two frames."""
    times, joints, states, persons = recording
    if len(times) < 2:
        return []

    # The median is the nominal rate even if many frames are missing.
    detector = EventDetector(config, 1.0 / float(np.median(np.diff(times))))
    names: list[int | str] = persons.tolist()
    rows = np.arange(len(names))
    found: list[Detected] = []
    for t_s, frame_joints, frame_states in zip(times.tolist(), joints, states, strict=True):
        frame = SkeletonFrame("recording", t_s, t_s, t_s, Skeletons(rows, frame_joints, frame_states))
        for event in detector.update(frame):
            name = names[event.person]
            found.append(Detected(event.t_device_s, name, event.kind, event.early, event.t_onset_device_s))
    return found
