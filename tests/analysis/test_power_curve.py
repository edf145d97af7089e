"""Power of the sign-flip test from a pool of groups: against independent studies, statsmodels and known limits."""

import itertools

import numpy as np
import pytest
from statsmodels.stats.power import TTestPower
from statsmodels.stats.proportion import proportion_confint

from sjasim.analysis.power_curve import (
    GroupsNeeded,
    PowerPoint,
    groups_needed,
    partitions,
    power_curve,
    smallest_size,
    wilson_interval,
)
from sjasim.core.errors import ConfigError


def skewed(rng, *shape):
    """Differences whose distribution is not normal: a normal and an exponential part."""
    return 0.05 + 0.06 * rng.standard_normal(shape) + 0.05 * (rng.exponential(1.0, shape) - 1.0)


def independent_power(rng, groups, studies):
    """Power by studies of fresh groups, tested by a loop over all sign patterns."""
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=groups)))
    rejected = 0
    for _ in range(studies):
        differences = skewed(rng, groups)
        as_extreme = np.abs(signs @ differences) >= abs(differences.sum()) - 1e-12
        rejected += as_extreme.mean() <= 0.05
    return rejected / studies


@pytest.mark.parametrize("groups", [7, 11])
def test_the_predicted_power_is_that_of_independent_studies(groups):
    rng = np.random.default_rng(31)
    (point,) = power_curve(skewed(rng, 4000), (groups,), rng)
    assert point.power == pytest.approx(independent_power(rng, groups, 1500), abs=0.05)
    assert point.low < point.power < point.high


def test_the_power_of_many_normal_groups_is_nearly_that_of_the_t_test():
    rng = np.random.default_rng(32)
    pool = 0.5 + rng.standard_normal(3000)
    pool = 0.5 + (pool - pool.mean()) / pool.std()
    for point in power_curve(pool, (15, 25, 35), rng, studies=1500):
        assert point.power == pytest.approx(TTestPower().power(0.5, point.groups, 0.05), abs=0.03)


def test_a_given_effect_replaces_the_mean_of_the_pool_and_keeps_its_spread():
    rng = np.random.default_rng(33)
    pool = skewed(rng, 1000)
    (own,) = power_curve(pool, (12,), rng, studies=1000)
    (same,) = power_curve(pool, (12,), rng, studies=1000, effect=float(pool.mean()))
    (none,) = power_curve(pool, (12,), rng, studies=1000, effect=0.0)
    assert same.power == pytest.approx(own.power, abs=0.05)
    assert same.high - same.low < own.high - own.low
    assert none.power < 0.08


def test_no_group_occurs_twice_in_a_study_and_successive_studies_share_none():
    drawn = partitions(50, 12, np.random.default_rng(0), 10)
    assert drawn.shape == (12, 12)
    for study in drawn:
        assert len(set(study)) == 12
    for first in range(0, len(drawn), 4):
        assert len(set(drawn[first : first + 4].ravel())) == 48


def test_a_pool_drawn_with_replacement_would_give_another_power():
    """The reason for drawing without replacement: a group that counts twice looks like more evidence."""
    rng = np.random.default_rng(34)
    pool = 0.4 + rng.standard_normal(40)
    pool -= pool.mean()
    (honest,) = power_curve(pool + 0.4, (38,), rng, studies=400)
    repeated = pool[rng.integers(0, 40, (400, 38))] + 0.4
    again = np.mean(np.abs(repeated.mean(axis=1)) / repeated.std(axis=1, ddof=1) * np.sqrt(38) > 2.03)
    assert abs(again - honest.power) > 0.05


@pytest.mark.slow
def test_the_intervals_cover_the_power():
    rng = np.random.default_rng(35)
    truth = independent_power(rng, 9, 6000)
    for effect in (None, 0.05):
        points = [power_curve(skewed(rng, 400), (9,), rng, studies=600, effect=effect)[0] for _ in range(100)]
        assert np.mean([point.low <= truth <= point.high for point in points]) >= 0.88
        assert np.mean([point.high - point.low for point in points]) < 0.35


def test_an_interval_that_ignored_the_pool_would_be_too_narrow():
    """Two thousand studies from two hundred groups are not two thousand independent studies."""
    rng = np.random.default_rng(36)
    (point,) = power_curve(skewed(rng, 200), (15,), rng)
    low, high = wilson_interval(point.power, 2000)
    assert point.high - point.low > 2.0 * (high - low)


@pytest.mark.parametrize(("share", "number"), [(0.0, 12), (0.05, 500), (0.8, 100), (1.0, 30)])
def test_wilson_s_interval_agrees_with_statsmodels(share, number):
    other = proportion_confint(round(share * number), number, method="wilson")
    assert wilson_interval(share, number) == pytest.approx(other, abs=1e-12)


def test_fewer_groups_than_the_test_needs_have_no_power():
    rng = np.random.default_rng(37)
    points = power_curve(5.0 + rng.standard_normal(100), (5, 6), rng)
    assert points[0] == PowerPoint(5, 0.0, 0.0, 0.0)
    assert points[1].power > 0.99
    assert (smallest_size(0.05), smallest_size(0.01), smallest_size(0.1)) == (6, 8, 5)


def test_the_number_of_groups_needed_is_where_the_power_stays_above_the_target():
    curve = [
        PowerPoint(6, 0.5, 0.4, 0.6),
        PowerPoint(7, 0.81, 0.7, 0.9),
        PowerPoint(8, 0.79, 0.7, 0.88),
        PowerPoint(9, 0.85, 0.78, 0.91),
        PowerPoint(10, 0.9, 0.84, 0.95),
    ]
    assert groups_needed(curve, 0.8) == GroupsNeeded(9, 7, 10)
    assert groups_needed(curve, 0.92) == GroupsNeeded(None, 10, None)


def test_a_pool_that_cannot_answer_is_refused():
    rng = np.random.default_rng(38)
    with pytest.raises(ConfigError, match="at least as many groups as a study, 20"):
        power_curve(rng.standard_normal(10), (6, 20), rng)
    with pytest.raises(ConfigError, match="vary between groups"):
        power_curve(np.full(50, 0.1), (6,), rng)
