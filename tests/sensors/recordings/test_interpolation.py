"""Interpolation and smoothing of recordings with the defects of real ones, and the events that are then detected."""

from __future__ import annotations

import numpy as np
import pytest

import sjasim
from sjasim.core import Kind
from sjasim.core.errors import ConfigError
from sjasim.sensors.recordings.interpolation import gaussian_smooth, interpolate_gaps

from .scripted_recordings import Defects, count_events, record

NEARLY_EXACT = {"bias_m": 0.0, "drift_m": 0.0, "white_m": 0.001}
LOST_STOPS = 1
"""Stops per recording that cannot be detected: the second person comes back into the picture during a move."""


def one_joint(places):
    """(T, 1, 1, 3) places of one joint, the same on all axes, and its states: tracked where it is known."""
    joints = np.array(places, dtype=float)[:, None, None, None] * np.ones(3)
    return joints, np.where(np.isfinite(joints[..., 0]), 2, 0).astype(np.int8)


def test_short_gaps_are_interpolated_linearly_and_long_ones_remain():
    times = np.array([0.0, 0.1, 0.15, 0.2, 0.5, 0.6])
    joints, state = one_joint([0.0, np.nan, 3.0, np.nan, 5.0, np.nan])
    state[2] = 1
    found, codes = interpolate_gaps(times, joints, state, 0.2)
    assert found[:, 0, 0, 0] == pytest.approx([0.0, 2.0, 3.0, np.nan, 5.0, np.nan], nan_ok=True)
    assert codes[:, 0, 0].tolist() == [2, 1, 1, 0, 2, 0]
    assert np.isnan(joints[1]).all()  # the arguments are not changed
    assert interpolate_gaps(times, joints, state, 0.0)[1] is state


def test_smoothing_keeps_straight_lines_and_unknown_joints():
    times = np.arange(0.0, 4.0, 1 / 30)
    line = 0.3 * times
    line[40] = np.nan
    smooth = gaussian_smooth(times, one_joint(line)[0], 0.3)[:, 0, 0, 0]
    assert smooth[10:30] == pytest.approx(line[10:30])
    assert np.flatnonzero(np.isnan(smooth)).tolist() == [40]


def test_smoothing_halves_white_noise_at_least():
    times = np.arange(0.0, 4.0, 1 / 30)
    noise = one_joint(0.01 * np.random.default_rng(0).standard_normal(len(times)))[0]
    assert gaussian_smooth(times, noise, 0.3)[10:-10].std() < 0.5 * noise.std()
    assert np.array_equal(gaussian_smooth(times, noise, 0.0), noise)


@pytest.mark.parametrize("lost_joints", [0.01, 0.05, 0.1])
def test_claps_are_detected_when_joints_are_missing(lost_joints):
    defects = Defects(lost_joints=lost_joints, **NEARLY_EXACT)
    for seed in range(2):
        times, joints = record(defects, seed)
        assert count_events(sjasim.detect_events(times, joints), defects, (Kind.CLAP,))[1:] == (0, 0)


def test_most_claps_are_missed_without_interpolation_when_a_tenth_of_the_joints_is_missing():
    defects = Defects(lost_joints=0.1, **NEARLY_EXACT)
    found = sjasim.detect_events(*record(defects, 1), bridge_s=0.0)
    true, missed, _ = count_events(found, defects, (Kind.CLAP,))
    assert missed > 0.5 * true


@pytest.mark.parametrize(
    "defects", [Defects(lost_joints=0.05), Defects(rate_hz=15.0, lost_joints=0.02), Defects(drift_s=2.0)]
)
def test_errors_of_a_centimetre_cause_no_missed_and_no_false_events(defects):
    for seed in range(2):
        assert count_events(sjasim.detect_events(*record(defects, seed)), defects)[1:] == (LOST_STOPS, 0)


def test_white_noise_causes_false_events_without_smoothing():
    defects = Defects(white_m=0.01)
    times, joints = record(defects, 0)
    assert count_events(sjasim.detect_events(times, joints, smooth_s=0.0), defects)[2] > 10
    assert count_events(sjasim.detect_events(times, joints), defects)[2] <= 1


@pytest.mark.parametrize("name", ["bridge_s", "smooth_s"])
def test_times_out_of_range_are_refused(name):
    times, joints = record(Defects(), 0, until_s=1.0)
    with pytest.raises(ConfigError, match=f"{name} = -0.1"):
        sjasim.detect_events(times, joints, **{name: -0.1})
