"""Tests of the oscillators of ASHLE against a solver of differential equations, and against their invariances."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sjasim.core.errors import ConfigError
from sjasim.humans.timing.ashle import (
    STEP_S,
    OscillatorParameters,
    Oscillators,
    asynchronies_s,
    metronome,
    passage_times_s,
    tap_times_s,
)

QUIET = OscillatorParameters(noise=0.0)


def derivative(t_s, state, period_s, spontaneous_hz):
    """Right-hand side of roman2023, eq. (3), in polar coordinates: radius, phase and frequency of both oscillators."""
    sensory_radius, sensory, sensory_hz, motor_radius, motor, motor_hz = state
    music = 2 * np.pi * t_s / period_s
    return [
        sensory_hz * (sensory_radius * (1 - sensory_radius**2) + np.cos(music - sensory)),
        sensory_hz * (2 * np.pi + np.sin(music - sensory) / sensory_radius),
        sensory_hz * (4.0 * np.sin(music - sensory) - 0.02 * (np.exp((sensory_hz - motor_hz) / motor_hz) - 1)),
        motor_hz * (motor_radius * (1 - motor_radius**2) + np.cos(sensory - motor)),
        motor_hz * (2 * np.pi + np.sin(sensory - motor) / motor_radius),
        motor_hz * (4.0 * np.sin(sensory - motor) - 2.0 * (np.exp((motor_hz - spontaneous_hz) / spontaneous_hz) - 1)),
    ]


@pytest.mark.parametrize("ratio", [0.75, 1.0, 1.2])
def test_a_person_with_a_metronome_follows_the_differential_equations(ratio):
    period_s = 0.4 * ratio
    person = Oscillators(np.array([0.4]), QUIET, np.random.default_rng(0))
    cycles = person.advance(metronome(period_s, 30.0))[:, 0]

    start = [0.01, 0.0, 2.5, 0.01, 0.0, 2.5]
    times_s = np.arange(0.0, 30.0, 1.0)
    solved = solve_ivp(derivative, (0, 30), start, "LSODA", times_s, args=(period_s, 2.5), rtol=1e-9, atol=1e-9)
    steps = np.round(times_s / STEP_S).astype(int)
    # Euler's method lags by a few thousandths of a cycle, most where the frequencies change fast.
    assert cycles[steps] == pytest.approx(solved.y[4] / (2 * np.pi), abs=0.02)
    assert person.frequencies_hz[0] == pytest.approx(solved.y[[2, 5], -1], rel=0.01)


def test_a_person_follows_a_tempo_change_and_keeps_the_new_tempo_for_a_while():
    person = Oscillators(np.array([0.4]), QUIET, np.random.default_rng(0))
    slower = np.concatenate([metronome(0.4, 16.0), metronome(0.46, 18.4), np.zeros(4000, dtype=complex)])
    taps_s = tap_times_s(person, slower, 92)[0]
    intervals_s = np.diff(taps_s)
    assert intervals_s[30:38] == pytest.approx(0.4, abs=2e-3)
    assert intervals_s[70:78] == pytest.approx(0.46, abs=2e-3)
    # After the metronome has stopped, the interval moves back towards the spontaneous one.
    alone = intervals_s[82:]
    assert 0.41 < alone.mean() < 0.46
    assert np.polyfit(np.arange(len(alone)), alone, 1)[0] < -1e-5


def test_duet_partners_with_equal_tempi_stay_together_and_meet_between_different_ones():
    clicks = metronome(0.4, 40.0, clicks=4)
    for periods, apart_s in (((0.40, 0.40), 1e-6), ((0.38, 0.44), 0.03)):
        pair = Oscillators(np.array(periods), QUIET, np.random.default_rng(0))
        taps_s = tap_times_s(pair, clicks, 80)
        assert np.abs(taps_s[0, 60:] - taps_s[1, 60:]).max() < apart_s
        assert np.diff(taps_s[:, 60:]) == pytest.approx(np.mean(periods), abs=0.02)


def test_noise_has_the_same_size_whatever_the_number_of_persons_and_depends_on_the_generator_alone():
    def spread(seed):
        person = Oscillators(np.full(8, 0.4), OscillatorParameters(noise=0.2, partner_weight=0.0), stream(seed))
        taps_s = tap_times_s(person, metronome(0.4, 60.0), 140)[:, 40:]
        return (taps_s - 0.4 * np.arange(40, 140)).std()

    stream = np.random.default_rng
    assert spread(1) == spread(1)
    assert spread(1) != spread(2)
    assert spread(1) == pytest.approx(spread(2), rel=0.2)


def test_passage_times_take_the_first_passage_and_interpolate():
    cycles = np.array([0.0, 0.5, 0.4, 0.9, 1.4])
    times = passage_times_s(cycles, np.array([0.0, 0.45, 0.7, 1.4, 2.0]))
    assert times[:4] == pytest.approx(np.array([0.0, 0.9, 2.5, 4.0]) * STEP_S)
    assert np.isnan(times[4])


def test_asynchronies_are_those_with_the_nearest_click():
    assert asynchronies_s(np.array([0.1, 0.9, 1.4, np.nan, 2.7]), [0.0, 1.0, 2.0]) == pytest.approx(
        [0.1, -0.1, 0.4, 0.7]
    )


@pytest.mark.parametrize("wrong", [{"learning": -1.0}, {"noise": float("nan")}, {"partner_weight": 2.0}])
def test_parameters_out_of_range_are_refused(wrong):
    with pytest.raises(ConfigError, match=f"humans.{next(iter(wrong))}"):
        OscillatorParameters(**wrong)
