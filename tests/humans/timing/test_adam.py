"""Tests of ADAM as a model of tapping: equations by a second route, and what the literature finds."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.core.errors import ConfigError
from sjasim.humans.timing.adam import AdamParameters, tap_times_s

PERIOD_S = 0.5
TIMEKEEPER_S = 0.010
MOTOR_S = 0.005


def person(alpha=0.0, beta=0.0, delta=0.0, gamma=0.0, timekeeper_s=TIMEKEEPER_S, motor_s=MOTOR_S) -> AdamParameters:
    """A person by the letters of vandersteen2013."""
    return AdamParameters(alpha, beta, delta, gamma, timekeeper_s, motor_s)


def asynchronies(parameters: AdamParameters, stimulus_s: np.ndarray, seed: int = 0) -> np.ndarray:
    """Asynchronies of one person with a stimulus [s]."""
    rng = np.random.default_rng(seed)
    return tap_times_s(stimulus_s, np.ones(len(stimulus_s)), 1, parameters, rng)[0] - stimulus_s


def metronome(tones: int) -> np.ndarray:
    return PERIOD_S * np.arange(tones)


def tempo_changes(tones: int = 66) -> np.ndarray:
    """Intervals of 400 to 600 ms that change as a sine with three cycles."""
    intervals = PERIOD_S + 0.1 * np.sin(2 * np.pi * np.arange(tones - 1) / 22)
    return np.concatenate([[0.0], np.cumsum(intervals)])


@pytest.mark.parametrize("alpha", [0.2, 0.5, 0.9])
def test_phase_correction_alone_has_the_variance_of_its_closed_form(alpha):
    """The stationary variance of A(k + 1) = (1 - a) A(k) + T + M(k + 1) - M(k)."""
    found = asynchronies(person(alpha), metronome(40_000))[100:]
    expected = (TIMEKEEPER_S**2 + alpha**2 * MOTOR_S**2) / (alpha * (2 - alpha)) + MOTOR_S**2
    assert found.var() == pytest.approx(expected, rel=0.05)


def test_taps_follow_the_equations_computed_step_by_step():
    stimulus = tempo_changes(12)
    alpha, beta, delta, gamma = 0.4, 0.2, 0.6, 0.3
    found = asynchronies(person(alpha, beta, delta, gamma, 0.0, 0.0), stimulus) + stimulus

    taps = [stimulus[0]]
    period = stimulus[1] - stimulus[0]
    for n in range(11):
        error = taps[n] - stimulus[n]
        period -= beta * error
        adapted = taps[n] + period - alpha * error
        heard = np.diff(stimulus[: n + 1])
        expected = period if n == 0 else heard[-1] + (delta * (heard[-1] - heard[-2]) if n > 1 else 0.0)
        taps.append((1 - gamma) * adapted + gamma * (stimulus[n] + expected))
    assert found == pytest.approx(taps)


def test_period_correction_brings_back_the_mean_asynchrony_after_a_step_in_tempo():
    stimulus = np.concatenate([metronome(30), metronome(30)[-1] + 0.45 * np.arange(1, 61)])
    with_phase, with_both = (asynchronies(person(0.4, beta, 0, 0, 0, 0), stimulus) for beta in (0.0, 0.2))
    # Phase correction alone stays late by the interval's error over the gain.
    assert with_phase[-1] == pytest.approx(0.05 / 0.4, rel=1e-3)
    assert abs(with_both[-1]) < 1e-4


def best_sd(stimulus: np.ndarray, gamma: float, delta: float) -> float:
    """Smallest standard deviation of asynchronies over the gains of correction [s]."""
    return min(
        np.mean([asynchronies(person(alpha, beta, delta, gamma), stimulus, seed)[10:].std() for seed in range(12)])
        for alpha in (0.1, 0.3, 0.5, 0.7, 0.9)
        for beta in (0.0, 0.2, 0.5, 0.8)
    )


def test_correction_suffices_for_a_steady_tempo_and_anticipation_helps_with_a_changing_one():
    """What the simulations of harry2019 find."""
    assert best_sd(metronome(66), 0.0, 0.0) < 1.08 * best_sd(metronome(66), 1.0, 1.0)
    assert best_sd(tempo_changes(), 1.0, 1.0) < 0.6 * best_sd(tempo_changes(), 0.0, 0.0)


def test_predictors_are_closer_than_trackers_where_the_tempo_changes():
    """Prediction of tempo changes goes with smaller asynchronies (vandersteen2013)."""
    tracker, predictor = (asynchronies(person(0.4, 0.0, delta, 0.8, 0.0, 0.0), tempo_changes()) for delta in (0, 1))
    assert np.abs(predictor[5:]).mean() < 0.7 * np.abs(tracker[5:]).mean()


def test_a_duet_adapts_in_both_directions():
    """Intervals of two coupled tappers correlate with one another's last interval, and negatively with the present one.

    The pattern is that of konvalinka2010.
    """
    share = np.zeros(3000)
    share[:8] = 1.0
    taps = tap_times_s(metronome(3000), share, 2, person(0.3), np.random.default_rng(1))
    intervals = np.diff(taps[:, 20:])

    def correlation(a, b):
        return np.corrcoef(a, b)[0, 1]

    assert correlation(intervals[0], intervals[1]) < -0.1
    assert correlation(intervals[0, :-1], intervals[1, 1:]) > 0.1
    assert correlation(intervals[1, :-1], intervals[0, 1:]) > 0.1
    assert np.abs(taps[0] - taps[1]).max() < 0.1


@pytest.mark.parametrize("wrong", [{"phase_correction": 2.5}, {"lapse": -0.1}, {"motor_s": float("inf")}])
def test_parameters_out_of_range_are_refused(wrong):
    with pytest.raises(ConfigError, match=f"humans.{next(iter(wrong))}"):
        AdamParameters(**wrong)
