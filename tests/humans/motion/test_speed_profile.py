"""Speed profiles cross the onset speed on time, whatever else has to give way."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from sjasim.core.errors import ConfigError
from sjasim.humans.motion.speed_profile import FASTEST_M_S, ONSET_M_S, SLOWEST_M_S, smooth, speed_profile

DURATIONS = (0.8, 2.0, 3.0)


def speed(profile, t: float) -> float:
    return float(profile.speed(np.array(t)))


@pytest.mark.parametrize("duration", [*DURATIONS, 0.5, 1.3, 6.0])
@pytest.mark.parametrize("distance", [0.05, 0.3, 0.5, 0.8])
def test_the_onset_speed_is_crossed_exactly_at_start_and_stop(distance, duration):
    profile = speed_profile(distance, duration)
    start = brentq(lambda t: speed(profile, t) - ONSET_M_S, -profile.rise_s, duration / 2, xtol=1e-12)
    stop = brentq(lambda t: speed(profile, t) - ONSET_M_S, duration / 2, duration + profile.rise_s, xtol=1e-12)
    assert start == pytest.approx(0.0, abs=1e-9)
    assert stop == pytest.approx(duration, abs=1e-9)


@pytest.mark.parametrize("duration", DURATIONS)
def test_the_way_is_the_integral_of_the_speed(duration):
    profile = speed_profile(0.5, duration)
    corners = [-profile.rise_s + profile.ramp_s, duration + profile.rise_s - profile.ramp_s]
    for t in (-0.05, 0.2, duration / 2, duration, duration + 1.0):
        way, _ = quad(lambda s: speed(profile, s), -profile.rise_s, t, points=[c for c in corners if c < t], limit=200)
        assert float(profile.travelled(np.array(t))) == pytest.approx(way, abs=1e-7)
    assert float(profile.travelled(np.array(duration + 1.0))) == pytest.approx(profile.distance_m, abs=1e-12)


def test_a_wanted_way_is_walked_where_speeds_allow():
    assert speed_profile(0.5, 1.5).distance_m == pytest.approx(0.5, abs=2e-3)


def test_a_move_too_short_for_its_way_gives_up_way_not_time():
    profile = speed_profile(1.0, 0.8)
    assert profile.cruise_m_s <= FASTEST_M_S
    assert profile.distance_m < 0.45
    assert profile.duration_s == 0.8


def test_slow_moves_go_farther_rather_than_creep():
    profile = speed_profile(0.5, 3.0)
    assert profile.cruise_m_s >= SLOWEST_M_S
    assert profile.distance_m > 0.5


@pytest.mark.parametrize("duration", DURATIONS)
def test_starts_are_crisp(duration):
    profile = speed_profile(0.5, duration)
    times = np.linspace(-profile.rise_s, duration / 2, 20001)
    speeds = profile.speed(times)
    assert np.interp(0.25, speeds, times) - np.interp(0.05, speeds, times) <= 0.35
    assert (np.diff(speeds) >= -1e-12).all()


@pytest.mark.parametrize("duration", [0.49, 0.0, -1.0, float("nan"), float("inf")])
def test_a_move_too_short_to_be_possible_is_refused(duration):
    with pytest.raises(ConfigError, match=r"0\.5 s or longer"):
        speed_profile(0.5, duration)


def test_smooth_is_flat_at_both_ends():
    u = np.array([-1.0, 0.0, 1e-4, 0.5, 1.0 - 1e-4, 1.0, 2.0])
    assert smooth(u) == pytest.approx([0, 0, 0, 0.5, 1, 1, 1], abs=1e-10)
