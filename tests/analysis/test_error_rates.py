"""Type I error of the tests on nested values whose two methods have the same distribution."""

import numpy as np
import pytest

from sjasim.analysis.error_rates import RECOMMENDED, rejection_shares
from sjasim.analysis.paired_tests import sign_flip_p


def nested_null(rng, studies, groups=9, iterations=4, steps=9):
    """Positive values that share a part within each group, session and iteration, as timing errors do."""
    level = 0.3 * rng.standard_normal((studies, groups, 1, 1, 1))
    session = 0.2 * rng.standard_normal((studies, groups, 2, 1, 1))
    iteration = 0.5 * rng.standard_normal((studies, groups, 2, iterations, 1))
    own = 0.3 * rng.standard_normal((studies, groups, 2, iterations, steps))
    return np.exp(level + session + iteration + own - 0.7)


@pytest.fixture(scope="module")
def shares():
    rng = np.random.default_rng(41)
    return rejection_shares(nested_null(rng, 200), rng)


def test_the_recommended_test_rejects_in_3_to_7_percent_of_studies_without_a_difference():
    rng = np.random.default_rng(42)
    means = nested_null(rng, 4000).mean(axis=(3, 4))
    p = sign_flip_p(means[:, :, 1] - means[:, :, 0], rng)
    assert 0.03 <= np.mean(p <= 0.05) <= 0.07


def test_a_test_of_events_rejects_far_too_often(shares):
    assert shares["events: signed ranks"]["low"] > 0.2
    assert shares["iterations: signed ranks"]["share"] < shares["events: signed ranks"]["share"]


def test_group_level_tests_agree_with_one_another(shares):
    for name in ("groups: t test", "groups: signed ranks"):
        assert shares[name]["share"] == pytest.approx(shares[RECOMMENDED]["share"], abs=0.04)


def test_a_real_difference_is_found_and_missing_steps_are_left_out():
    rng = np.random.default_rng(42)
    values = nested_null(rng, 40)
    values[:, :, 1] *= 3.0
    values[:, :, :, 1, 2] = np.nan
    for row in rejection_shares(values, rng).values():
        assert row["share"] > 0.9
