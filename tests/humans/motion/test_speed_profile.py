"""Tests of speed profiles, which cross the onset speed on time at any duration and distance."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from sjasim.core.errors import ConfigError
from sjasim.humans.motion.speed_profile import MAX_CRUISE_M_S, MIN_CRUISE_M_S, ONSET_M_S, minimum_jerk, speed_profile

DURATIONS = (0.8, 2.0, 3.0)


def speed(profile, t: float) -> float:
    return float(profile.speed_at(np.array(t)))


@pytest.mark.parametrize("duration", [*DURATIONS, 0.5, 1.3, 6.0])
@pytest.mark.parametrize("distance", [0.05, 0.3, 0.5, 0.8])
def test_the_onset_speed_is_crossed_exactly_at_start_and_stop(distance, duration):
    profile = speed_profile(distance, duration)
    start = brentq(lambda t: speed(profile, t) - ONSET_M_S, -profile.rise_s, duration / 2, xtol=1e-12)
    stop = brentq(lambda t: speed(profile, t) - ONSET_M_S, duration / 2, duration + profile.rise_s, xtol=1e-12)
    assert start == pytest.approx(0.0, abs=1e-9)
    assert stop == pytest.approx(duration, abs=1e-9)


@pytest.mark.parametrize("duration", DURATIONS)
def test_the_distance_is_the_integral_of_the_speed(duration):
    profile = speed_profile(0.5, duration)
    corners = [-profile.rise_s + profile.ramp_s, duration + profile.rise_s - profile.ramp_s]
    for t in (-0.05, 0.2, duration / 2, duration, duration + 1.0):
        way, _ = quad(lambda s: speed(profile, s), -profile.rise_s, t, points=[c for c in corners if c < t], limit=200)
        assert float(profile.distance_at(np.array(t))) == pytest.approx(way, abs=1e-7)
    assert float(profile.distance_at(np.array(duration + 1.0))) == pytest.approx(profile.distance_m, abs=1e-12)


def test_the_wanted_distance_is_kept_where_speeds_allow():
    assert speed_profile(0.5, 1.5).distance_m == pytest.approx(0.5, abs=2e-3)


def test_a_short_move_keeps_its_duration_and_covers_less_distance():
    profile = speed_profile(1.0, 0.8)
    assert profile.cruise_m_s <= MAX_CRUISE_M_S
    assert profile.distance_m < 0.45
    assert profile.duration_s == 0.8


def test_a_long_move_covers_more_distance():
    profile = speed_profile(0.5, 3.0)
    assert profile.cruise_m_s >= MIN_CRUISE_M_S
    assert profile.distance_m > 0.5


@pytest.mark.parametrize("duration", DURATIONS)
def test_the_speed_rises_quickly(duration):
    profile = speed_profile(0.5, duration)
    times = np.linspace(-profile.rise_s, duration / 2, 20001)
    speeds = profile.speed_at(times)
    assert np.interp(0.25, speeds, times) - np.interp(0.05, speeds, times) <= 0.35
    assert (np.diff(speeds) >= -1e-12).all()


@pytest.mark.parametrize("duration", [0.49, 0.0, -1.0, float("nan"), float("inf")])
def test_an_impossible_duration_is_refused(duration):
    with pytest.raises(ConfigError, match=r"0\.5 s or longer"):
        speed_profile(0.5, duration)


def test_minimum_jerk_is_flat_at_both_ends():
    u = np.array([-1.0, 0.0, 1e-4, 0.5, 1.0 - 1e-4, 1.0, 2.0])
    assert minimum_jerk(u) == pytest.approx([0, 0, 0, 0.5, 1, 1, 1], abs=1e-10)
