"""Recordings as a laboratory's Kinect v2 makes them, with their truth: jitter, lost frames, lost joints, absences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sjasim.core import Kind

from ..scripted import NORTH, Script, ScriptedView, Walk, match_events

Truth = list[tuple[float, Kind]]


@dataclass(frozen=True)
class Flaws:
    """What is wrong with a recording.

    Attributes:
        rate_hz: nominal frame rate.
        jitter_s: frames come as much too early or too late.
        lost_frames: share of frames that are missing.
        lost_joints: share of joints that are missing, each on its own.
        outage_hz, outage_s: how often a joint disappears for a while, and for how long on average.
        bias_m: constant error of a joint.
        drift_m, drift_s: AR(1) error and its correlation time.
        white_m: error of its own in every frame.
        away_s: from when to when the second person is out of the picture.
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
    """Two people who step, clap and stand."""
    out = []
    for late_s, x in ((0.0, -0.4), (0.25, 0.5)):
        walks = [Walk(2.0 + 8.0 * k + late_s, 1.6, 0.5) for k in range(6)]
        walks += [Walk(5.0 + 8.0 * k + late_s, 1.8, -0.5) for k in range(6)]
        out.append(Script((x, 0.2), walks=walks, claps=[8.4 + 8.0 * k + late_s for k in range(6)]))
    return out


def record(flaws: Flaws, seed: int, until_s: float = 52.0) -> tuple[np.ndarray, np.ndarray]:
    """(T,) times [s] and (T, 2, 25, 3) joints, NaN where missing [m]."""
    rng, view = np.random.default_rng(seed), ScriptedView(scripts())
    times = np.arange(0.0, until_s, 1.0 / flaws.rate_hz)
    times = times[rng.random(len(times)) >= flaws.lost_frames]
    times = np.maximum.accumulate(times + rng.uniform(-1.0, 1.0, len(times)) * flaws.jitter_s)
    joints = np.stack([(view.at(float(t)).joints_m - NORTH.position) @ NORTH.world_from_sensor for t in times])
    gaps = np.diff(times, prepend=times[0])
    kept = np.exp(-gaps / flaws.drift_s)
    fresh = flaws.drift_m * np.sqrt(1.0 - kept**2)[:, None, None, None] * rng.standard_normal(joints.shape)
    error = flaws.drift_m * rng.standard_normal(joints.shape[1:])
    for index, share in enumerate(kept):
        error = share * error + fresh[index]
        joints[index] += error
    joints += flaws.bias_m * rng.standard_normal(joints.shape[1:]) + flaws.white_m * rng.standard_normal(joints.shape)
    joints[_hidden(flaws, times, joints.shape[:3], rng)] = np.nan
    away = (times >= flaws.away_s[0]) & (times < flaws.away_s[1])
    joints[away, 1] = np.nan
    return times, joints


def _hidden(flaws: Flaws, times: np.ndarray, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """(T, P, 25) which joints are missing."""
    hidden = rng.random(shape) < flaws.lost_joints
    for person in range(shape[1]):
        for joint in range(shape[2]):
            for start_s in rng.uniform(0.0, times[-1], rng.poisson(flaws.outage_hz * times[-1])):
                until_s = start_s + rng.exponential(flaws.outage_s)
                hidden[(times >= start_s) & (times < until_s), person, joint] = True
    return hidden


def truths(flaws: Flaws) -> list[Truth]:
    """What each of them did in the picture."""
    first, second = (script.events() for script in scripts())
    return [first, [one for one in second if not flaws.away_s[0] <= one[0] < flaws.away_s[1]]]


def judged(found: Sequence, flaws: Flaws, kinds: Sequence[Kind] = tuple(Kind)) -> tuple[int, int, int]:
    """How many regular events of some kinds there are, how many of them are missed, how many are invented."""
    totals = [0, 0, 0]
    for person, truth in enumerate(truths(flaws)):
        wanted = [one for one in truth if one[1] in kinds]
        own = [(one.t_s, one.kind) for one in found if one.person == person and not one.early and one.kind in kinds]
        _, missed, false = match_events(own, wanted, 0.1, 0.5)
        totals = [total + more for total, more in zip(totals, (len(wanted), missed, false), strict=True)]
    return totals[0], totals[1], totals[2]
