"""Recordings with the defects of a real Kinect v2, and their true events: noise, lost frames and joints, absences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sjasim.core import Kind
from sjasim.sensors.recordings.detect import Detected

from ..scripted import Script, ScriptedView, Walk, match_events


@dataclass(frozen=True)
class Defects:
    """Defects of a recording.

    Attributes:
        rate_hz: nominal frame rate.
        jitter_s: largest error of a frame's time.
        lost_frames: share of frames that are missing.
        lost_joints: share of joints that are missing, independently of one another.
        outage_hz: rate at which a joint disappears for a while.
        outage_s: mean duration of such an outage.
        bias_m: standard deviation of a joint's constant error.
        drift_m: standard deviation of a joint's first-order autoregressive error.
        drift_s: correlation time of that error.
        white_m: standard deviation of the error that is independent from frame to frame.
        away_s: times between which the second person is out of the picture.
    """

    rate_hz: float = 30.0
    jitter_s: float = 0.004
    lost_frames: float = 0.05
    lost_joints: float = 0.0
    outage_hz: float = 0.0
    outage_s: float = 0.1
    bias_m: float = 0.01
    drift_m: float = 0.01
    drift_s: float = 0.5
    white_m: float = 0.003
    away_s: tuple[float, float] = (20.0, 30.0)


def scripts() -> list[Script]:
    """Two persons who walk, clap and stand."""
    out = []
    for late_s, x in ((0.0, -0.4), (0.25, 0.5)):
        walks = [Walk(2.0 + 8.0 * k + late_s, 1.6, 0.5) for k in range(6)]
        walks += [Walk(5.0 + 8.0 * k + late_s, 1.8, -0.5) for k in range(6)]
        out.append(Script((x, 0.2), walks=walks, claps=[8.4 + 8.0 * k + late_s for k in range(6)]))
    return out


def record(defects: Defects, seed: int, until_s: float = 52.0) -> tuple[np.ndarray, np.ndarray]:
    """(T,) times [s] and (T, 2, 25, 3) joints, NaN where missing [m]."""
    rng = np.random.default_rng(seed)
    view = ScriptedView(scripts())
    times = np.arange(0.0, until_s, 1.0 / defects.rate_hz)
    times = times[rng.random(len(times)) >= defects.lost_frames]
    times = np.maximum.accumulate(times + rng.uniform(-1.0, 1.0, len(times)) * defects.jitter_s)
    joints = np.stack([view.sensor_joints(float(t)) for t in times])

    # The drift keeps less of itself over a longer gap between two frames.
    gaps = np.diff(times, prepend=times[0])
    kept = np.exp(-gaps / defects.drift_s)
    fresh = defects.drift_m * np.sqrt(1.0 - kept**2)[:, None, None, None] * rng.standard_normal(joints.shape)
    error = defects.drift_m * rng.standard_normal(joints.shape[1:])
    for index, share in enumerate(kept):
        error = share * error + fresh[index]
        joints[index] += error

    bias = defects.bias_m * rng.standard_normal(joints.shape[1:])
    joints += bias + defects.white_m * rng.standard_normal(joints.shape)
    joints[_missing(defects, times, joints.shape[:3], rng)] = np.nan
    away = (times >= defects.away_s[0]) & (times < defects.away_s[1])
    joints[away, 1] = np.nan
    return times, joints


def _missing(defects: Defects, times: np.ndarray, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """(T, P, 25) whether a joint is missing."""
    missing = rng.random(shape) < defects.lost_joints
    for person in range(shape[1]):
        for joint in range(shape[2]):
            for start_s in rng.uniform(0.0, times[-1], rng.poisson(defects.outage_hz * times[-1])):
                until_s = start_s + rng.exponential(defects.outage_s)
                missing[(times >= start_s) & (times < until_s), person, joint] = True
    return missing


def true_events(defects: Defects) -> list[list[tuple[float, Kind]]]:
    """True events of each person while in the picture."""
    first, second = (script.events() for script in scripts())
    return [first, [event for event in second if not defects.away_s[0] <= event[0] < defects.away_s[1]]]


class EventCounts(NamedTuple):
    """Numbers of true, missed and false regular events."""

    true: int
    missed: int
    false: int


def count_events(found: Sequence[Detected], defects: Defects, kinds: Sequence[Kind] = tuple(Kind)) -> EventCounts:
    """Count regular events of some kinds, over both persons."""
    true = 0
    missed = 0
    false = 0
    for person, events in enumerate(true_events(defects)):
        wanted = [event for event in events if event[1] in kinds]
        own = [(one.t_s, one.kind) for one in found if one.person == person and not one.early and one.kind in kinds]
        match = match_events(own, wanted, 0.1, 0.5)
        true += len(wanted)
        missed += match.missed
        false += match.false
    return EventCounts(true, missed, false)
