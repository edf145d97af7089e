"""Intervals over groups: coverage at nine groups, agreement with the tests, and degenerate samples."""

import numpy as np
import pytest
from scipy import stats

from sjasim.analysis.paired_intervals import (
    mean_interval,
    rank_biserial,
    sign_flip_interval,
    standardised_difference,
)
from sjasim.analysis.paired_tests import sign_flip_p


def coverage(interval, draw, truth, studies):
    """Share of studies whose interval contains the truth."""
    rng = np.random.default_rng(5)
    results = [interval(draw(rng), rng) for _ in range(studies)]
    return np.mean([result.low <= truth <= result.high for result in results])


def test_the_bootstrap_interval_of_nine_groups_covers_the_mean_of_normal_and_skewed_values():
    for draw, truth in [(lambda rng: rng.normal(0.4, 0.1, 9), 0.4), (lambda rng: rng.exponential(0.5, 9), 0.5)]:
        assert 0.92 <= coverage(mean_interval, draw, truth, 400) <= 0.98


def test_a_percentile_interval_of_nine_groups_would_not_cover_the_mean():
    """The reason for the studentised bootstrap."""
    rng = np.random.default_rng(5)
    hits = 0
    for _ in range(400):
        values = rng.normal(0.4, 0.1, 9)
        low, high = np.quantile(values[rng.integers(0, 9, (999, 9))].mean(axis=1), (0.025, 0.975))
        hits += low <= 0.4 <= high
    assert hits / 400 < 0.92


def test_the_interval_of_a_difference_excludes_zero_exactly_if_the_test_is_significant():
    rng = np.random.default_rng(6)
    significant = 0
    for groups in (6, 7, 9, 13):
        for _ in range(40):
            differences = rng.standard_normal(groups) + 0.6
            interval = sign_flip_interval(differences, rng)
            excluded = not interval.low <= 0.0 <= interval.high
            assert excluded == (sign_flip_p(differences, rng)[0] <= 0.05)
            significant += excluded
    assert 20 < significant < 140


def test_the_interval_of_a_difference_agrees_with_the_test_at_every_shift():
    differences = np.random.default_rng(7).standard_normal(8)
    interval = sign_flip_interval(differences, np.random.default_rng(0))
    for shift in np.linspace(interval.low - 1.0, interval.high + 1.0, 301):
        p = sign_flip_p(differences - shift, np.random.default_rng(0))[0]
        assert (p > 0.05) == (interval.low < shift < interval.high), shift


def test_the_interval_of_a_difference_covers_it_in_95_percent_of_studies_of_nine_and_of_thirty_groups():
    for groups, studies in ((9, 400), (30, 120)):
        draw = lambda rng, n=groups: rng.standard_t(4, n) + 1.0  # noqa: E731
        assert 0.9 <= coverage(sign_flip_interval, draw, 1.0, studies) <= 0.99


def test_five_groups_have_no_exact_interval_at_95_percent():
    assert np.isnan(sign_flip_interval(np.arange(5.0), np.random.default_rng(0)).low)
    assert np.isfinite(sign_flip_interval(np.arange(6.0), np.random.default_rng(0)).low)
    assert np.isfinite(sign_flip_interval(np.arange(5.0), np.random.default_rng(0), 0.9).low)


def test_the_interval_of_the_standardised_difference_inverts_the_noncentral_t_distribution():
    differences = np.random.default_rng(8).standard_normal(9) + 0.7
    result = standardised_difference(differences)
    t = stats.ttest_1samp(differences, 0.0).statistic
    assert result.value == pytest.approx(t / 3.0)
    assert stats.nct.sf(t, 8, 3.0 * result.low) == pytest.approx(0.025, abs=1e-5)
    assert stats.nct.cdf(t, 8, 3.0 * result.high) == pytest.approx(0.025, abs=1e-5)


def test_the_interval_of_the_standardised_difference_covers_it():
    interval = lambda values, _: standardised_difference(values)  # noqa: E731
    assert 0.92 <= coverage(interval, lambda rng: rng.standard_normal(9) + 0.8, 0.8, 300) <= 0.98


def test_the_interval_of_the_rank_biserial_correlation_covers_its_expectation():
    rng = np.random.default_rng(9)
    for mean in (0.0, 0.5, 1.0):
        truth = np.mean([rank_biserial(rng.standard_normal(9) + mean).value for _ in range(400)])
        interval = lambda values, _: rank_biserial(values)  # noqa: E731
        share = coverage(interval, lambda draw, shift=mean: draw.standard_normal(9) + shift, truth, 200)
        assert share >= 0.92


def test_groups_that_all_agree_have_a_rank_biserial_correlation_of_one_with_an_honest_interval():
    result = rank_biserial(np.linspace(0.1, 0.9, 9))
    assert (result.value, result.high) == (1.0, 1.0)
    assert 0.0 < result.low < 0.5


def test_samples_that_say_nothing_have_no_bounds():
    rng = np.random.default_rng(0)
    assert np.isnan(mean_interval(np.array([0.4, 0.5]), rng).low)
    assert mean_interval(np.array([0.4, np.nan, 0.5]), rng).value == pytest.approx(0.45)
    assert mean_interval(np.full(9, 0.4), rng) == (0.4, 0.4, 0.4)
    assert np.isnan(mean_interval(np.zeros(0), rng).value)
    assert np.isnan(standardised_difference(np.full(9, 0.1)).value)
    assert np.isnan(rank_biserial(np.zeros(9)).value)
    assert np.isnan(sign_flip_interval(np.zeros(0), rng).value)
