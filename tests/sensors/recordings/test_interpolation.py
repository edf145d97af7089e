"""Recordings with a laboratory's flaws: what is interpolate_gaps, what is gaussian_smooth, what the detectors then find."""

from __future__ import annotations

import numpy as np
import pytest

import sjasim
from sjasim.core import Kind
from sjasim.core.errors import ConfigError
from sjasim.sensors.recordings.interpolation import gaussian_smooth, interpolate_gaps

from .scripted_recordings import Flaws, judged, record

STILL = {"bias_m": 0.0, "drift_m": 0.0, "white_m": 0.001}
UNARMED = 1
"""Stops per recording that nobody can find: the second person comes back in mid-move."""


def track(places):
    """One joint's (T, 1, 1, 3) places, and states: tracked where they are known."""
    joints = np.array(places, dtype=float)[:, None, None, None] * np.ones(3)
    return joints, np.where(np.isfinite(joints[..., 0]), 2, 0).astype(np.int8)


def test_short_gaps_are_led_straight_across_and_long_ones_stay():
    times = np.array([0.0, 0.1, 0.15, 0.2, 0.5, 0.6])
    joints, state = track([0.0, np.nan, 3.0, np.nan, 5.0, np.nan])
    state[2] = 1
    found, codes = interpolate_gaps(times, joints, state, 0.2)
    assert found[:, 0, 0, 0] == pytest.approx([0.0, 2.0, 3.0, np.nan, 5.0, np.nan], nan_ok=True)
    assert codes[:, 0, 0].tolist() == [2, 1, 1, 0, 2, 0]
    assert np.isnan(joints[1]).all()  # the caller's own are left alone
    assert interpolate_gaps(times, joints, state, 0.0)[1] is state


def test_smoothing_keeps_lines_and_unknown_joints_and_calms_jitter():
    times = np.arange(0.0, 4.0, 1 / 30)
    line = 0.3 * times
    line[40] = np.nan
    assert gaussian_smooth(times, track(line)[0], 0.3)[10:30, 0, 0, 0] == pytest.approx(line[10:30])
    assert np.isnan(gaussian_smooth(times, track(line)[0], 0.3)[40]).all()
    noise = track(0.01 * np.random.default_rng(0).standard_normal(len(times)))[0]
    assert gaussian_smooth(times, noise, 0.3)[10:-10].std() < 0.5 * noise.std()
    assert np.array_equal(gaussian_smooth(times, noise, 0.0), noise)


@pytest.mark.parametrize("lost_joints", [0.01, 0.05, 0.1])
def test_claps_are_found_though_joints_are_lost(lost_joints):
    flaws = Flaws(lost_joints=lost_joints, **STILL)
    for seed in range(2):
        times, joints = record(flaws, seed)
        assert judged(sjasim.detect_events(times, joints), flaws, (Kind.CLAP,))[1:] == (0, 0)
    live = judged(sjasim.detect_events(times, joints, bridge_s=0.0), flaws, (Kind.CLAP,))
    assert lost_joints < 0.1 or live[1] > 0.5 * live[0]


@pytest.mark.parametrize("flaws", [Flaws(lost_joints=0.05), Flaws(rate_hz=15.0, lost_joints=0.02), Flaws(drift_s=2.0)])
def test_jitter_of_a_centimetre_neither_hides_nor_invents_events(flaws):
    for seed in range(2):
        assert judged(sjasim.detect_events(*record(flaws, seed)), flaws)[1:] == (UNARMED, 0)


def test_jitter_is_heard_where_nothing_smooths_it():
    flaws = Flaws(white_m=0.01)
    times, joints = record(flaws, 0)
    assert judged(sjasim.detect_events(times, joints, smooth_s=0.0), flaws)[2] > 10
    assert judged(sjasim.detect_events(times, joints), flaws)[2] <= 1


@pytest.mark.parametrize("name", ["bridge_s", "smooth_s"])
def test_times_out_of_range_are_refused(name):
    times, joints = record(Flaws(), 0, until_s=1.0)
    with pytest.raises(ConfigError, match=f"{name} = -0.1"):
        sjasim.detect_events(times, joints, **{name: -0.1})
