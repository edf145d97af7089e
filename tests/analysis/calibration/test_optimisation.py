"""Confidence intervals from the curvature and from the profile of a cost, against costs whose profiles are known."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.analysis.calibration.optimisation import Z_95, minimise, minimum_with_intervals

BOUNDS = [(-10.0, 10.0), (-10.0, 10.0)]


def ends(cost, start, bounds=BOUNDS):
    minimum = minimise(cost, np.array(start), bounds, np.ones(2, dtype=bool), 100)
    return minimum_with_intervals(cost, [minimum], bounds, 100)[1]


def test_a_quadratic_cost_has_the_intervals_of_its_covariance():
    covariance = np.array([[1.0, 0.6], [0.6, 0.5]])
    inverse = np.linalg.inv(covariance)
    found = ends(lambda x: 0.5 * float(x @ inverse @ x), (0.5, -0.5))
    half_width = Z_95 * np.sqrt(np.diag(covariance))
    assert found == pytest.approx(np.stack([-half_width, half_width], axis=1), rel=1e-3)


def test_a_lopsided_cost_has_the_ends_of_its_profile():
    """The profile over the second parameter is exp(a) - a - 1, which rises by Z_95^2 / 2 at -2.893 and 1.327."""
    found = ends(lambda x: float(np.exp(x[0]) - x[0] - 1.0 + (x[1] - x[0] ** 2) ** 2), (0.1, 0.1))
    rise = np.exp(found[0]) - found[0] - 1.0
    assert np.sqrt(2 * rise) == pytest.approx(Z_95, abs=0.1)
    assert found[0] == pytest.approx([-2.893, 1.327], abs=0.2)


def test_an_interval_ends_at_the_bound_if_the_profile_does_not_rise_before_it():
    found = ends(lambda x: 0.5 * float((x[0] + 0.2) ** 2 + x[1] ** 2), (0.5, 0.5), [(0.0, 10.0), (-10.0, 10.0)])
    assert found[0, 0] == 0.0
    assert found[0, 1] == pytest.approx(np.sqrt(Z_95**2 + 0.04) - 0.2, abs=0.1)


def test_an_interval_includes_another_minimum_that_is_not_significantly_higher():
    def two_valleys(x):
        return float(min(10 * (x[0] + 1) ** 2, 1.0 + 10 * (x[0] - 1) ** 2) + x[1] ** 2)

    minima = [
        minimise(two_valleys, np.array([start, 0.1]), BOUNDS, np.ones(2, dtype=bool), 10) for start in (-1.2, 1.2)
    ]
    at, found = minimum_with_intervals(two_valleys, minima, BOUNDS, 10)
    assert at[0] == pytest.approx(-1.0, abs=0.01)
    assert found[0] == pytest.approx([-1 - np.sqrt(0.192), 1 + np.sqrt(0.0921)], abs=0.05)
