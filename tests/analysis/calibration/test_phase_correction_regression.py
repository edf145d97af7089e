"""Regression of intervals on asynchronies, against a simulation of the published model written here."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.analysis.calibration.phase_correction_regression import EnsembleIntervals, regress_ensemble
from sjasim.analysis.calibration.tapping_trials import FitError

GAINS = np.array([[0.0, 0.05, 0.05, 0.05], [0.30, 0.0, 0.05, 0.05], [0.25, 0.10, 0.0, 0.05], [0.30, 0.0, 0.10, 0.0]])
"""Players 2 to 4 follow player 1, who corrects little."""


def played(rng, events: int, timekeeper_s=0.012, motor_s=0.006, tempo_s=0.0) -> np.ndarray:
    """(E, P) onsets: t(k + 1) = t(k) + interval - sum of gains times asynchronies + T + M(k + 1) - M(k)."""
    motor = rng.normal(0.0, motor_s, 4)
    onsets = [rng.normal(0.0, timekeeper_s, 4) + motor]
    for _ in range(events - 1):
        new = rng.normal(0.0, motor_s, 4)
        now = onsets[-1]
        correction = np.array([sum(GAINS[i, j] * (now[i] - now[j]) for j in range(4)) for i in range(4)])
        onsets.append(now + 0.25 + rng.normal(0, tempo_s) - correction + rng.normal(0, timekeeper_s, 4) + new - motor)
        motor = new
    return np.array(onsets)


def take(onsets: np.ndarray, left_out=()) -> EnsembleIntervals:
    number = np.array([k for k in range(len(onsets) - 1) if k not in left_out])
    return EnsembleIntervals(onsets[number], onsets[number + 1] - onsets[number] - 0.25, number)


def test_gains_and_noise_of_an_asymmetric_quartet_are_recovered():
    rng = np.random.default_rng(3)
    fit = regress_ensemble([take(played(rng, 400)) for _ in range(10)])
    assert np.abs(fit.gains - GAINS).max() < 0.06
    assert (np.abs(fit.gains - GAINS)[~np.eye(4, dtype=bool)] < 3.5 * fit.errors[~np.eye(4, dtype=bool)]).all()
    assert fit.timekeeper_s == pytest.approx(0.012, rel=0.1)
    assert fit.motor_s == pytest.approx(0.006, rel=0.2)
    assert fit.tempo_s < 0.004


def test_changes_of_the_common_tempo_are_not_the_players_noise():
    rng = np.random.default_rng(4)
    fit = regress_ensemble([take(played(rng, 400, tempo_s=0.01)) for _ in range(10)])
    assert fit.timekeeper_s == pytest.approx(0.012, rel=0.12)
    assert fit.tempo_s == pytest.approx(0.01, rel=0.15)
    assert np.abs(fit.gains - GAINS).max() < 0.12


def test_gaps_between_intervals_do_not_bias_the_gains():
    rng = np.random.default_rng(5)
    fit = regress_ensemble([take(played(rng, 400), left_out=range(0, 400, 4)) for _ in range(10)])
    assert np.abs(fit.gains - GAINS).max() < 0.08
    assert fit.motor_s == pytest.approx(0.006, rel=0.3)


def test_constant_leads_and_tempi_do_not_matter():
    onsets = played(np.random.default_rng(6), 200)
    leads = onsets + np.array([0.0, 0.02, -0.03, 0.01])
    slower = take(leads)
    slower = EnsembleIntervals(slower.onsets_s, slower.intervals_s + 0.05, slower.number)
    assert regress_ensemble([slower]).gains == pytest.approx(regress_ensemble([take(onsets)]).gains)


def test_too_little_is_refused():
    with pytest.raises(FitError, match="29 intervals"):
        regress_ensemble([take(played(np.random.default_rng(7), 30))])
    with pytest.raises(FitError, match="0 intervals"):
        regress_ensemble([])
