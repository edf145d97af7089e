"""Signed ranks, sign flips and adjusted probabilities, against SciPy, statsmodels and pingouin."""

import numpy as np
import pandas
import pingouin
import pytest
from scipy import stats
from statsmodels.stats.anova import AnovaRM
from statsmodels.stats.multitest import multipletests

from sjasim.analysis.paired_tests import adjust_p, sign_flip_p, signed_rank, smallest_p
from sjasim.core.errors import ConfigError

RNG = np.random.default_rng(11)
FIRST = np.round(RNG.gamma(2.0, 0.35, 300), 2)
SECOND = np.round(np.where(RNG.random(300) < 0.1, FIRST, 0.8 * RNG.gamma(2.0, 0.35, 300)), 2)
"""Rounded values, so that there are ties and pairs without a difference."""


def test_z_p_and_effect_size_of_the_signed_rank_test_follow_from_the_ranks():
    result = signed_rank(FIRST, SECOND)
    differences = (SECOND - FIRST)[SECOND != FIRST]
    ranks = stats.rankdata(np.abs(differences))
    count = len(differences)
    ties = np.unique(ranks, return_counts=True)[1]
    variance = count * (count + 1) * (2 * count + 1) / 24 - (ties**3 - ties).sum() / 48
    z = (ranks[differences > 0].sum() - count * (count + 1) / 4) / np.sqrt(variance)

    assert result.zeros == 300 - count > 0
    assert result.z == pytest.approx(z)
    assert result.z < 0.0
    assert result.p == pytest.approx(2 * stats.norm.cdf(z))
    assert result.r == pytest.approx(z / np.sqrt(600))


def test_the_signed_rank_test_agrees_with_pingouin():
    result = signed_rank(FIRST, SECOND)
    other = pingouin.wilcoxon(SECOND, FIRST, correction=False, method="asymptotic")
    assert result.p == pytest.approx(float(other["p_val"].iloc[0]))
    assert result.rank_biserial == pytest.approx(float(other["RBC"].iloc[0]))


def test_scipy_drops_the_sign_of_z_and_has_no_continuity_correction_here():
    other = stats.wilcoxon(FIRST, SECOND, correction=False, method="asymptotic")
    assert signed_rank(SECOND, FIRST).z == pytest.approx(abs(other.zstatistic))
    assert signed_rank(FIRST, SECOND).z == pytest.approx(-abs(other.zstatistic))


def test_values_without_differences_are_not_significant():
    result = signed_rank(FIRST, FIRST)
    assert (result.p, result.zeros) == (1.0, 300)
    assert np.isnan(result.z)


@pytest.mark.parametrize("groups", [2, 6, 9, 12])
def test_sign_flips_agree_with_scipy_s_permutation_test(groups):
    differences = RNG.standard_normal((5, groups)) + 0.4
    for row, p in zip(differences, sign_flip_p(differences, RNG), strict=True):
        other = stats.permutation_test((row,), np.mean, permutation_type="samples", n_resamples=np.inf)
        assert p == pytest.approx(other.pvalue)


def test_random_sign_flips_of_many_groups_approach_the_t_test():
    differences = 0.25 * RNG.standard_normal(60) + 0.06
    p = sign_flip_p(differences, RNG)[0]
    assert p == pytest.approx(stats.ttest_1samp(differences, 0.0).pvalue, abs=0.015)


def test_equal_differences_are_ties_whatever_their_rounding():
    # In floating point, .1 + .2 + .3 and .3 + .2 + .1 differ.
    assert sign_flip_p(np.array([0.1, 0.2, 0.3]), RNG)[0] == 0.25
    assert sign_flip_p(np.zeros(7), RNG)[0] == 1.0
    assert np.isnan(sign_flip_p(np.zeros((1, 0)), RNG)).all()


def test_five_groups_cannot_be_significant_and_six_can():
    assert sign_flip_p(np.ones(5), RNG)[0] == smallest_p(5) == 0.0625
    assert sign_flip_p(np.ones(6), RNG)[0] == smallest_p(6) < 0.05
    assert smallest_p(0) == smallest_p(1) == 1.0


def test_missing_differences_are_refused():
    with pytest.raises(ConfigError, match="leave out groups"):
        sign_flip_p(np.array([0.1, np.nan]), RNG)


@pytest.mark.parametrize(("ours", "theirs"), [("holm", "holm"), ("benjamini-hochberg", "fdr_bh")])
def test_adjusted_probabilities_agree_with_statsmodels_and_pingouin(ours, theirs):
    p = RNG.random(12) ** 3
    adjusted = adjust_p(p, ours)
    assert adjusted == pytest.approx(multipletests(p, method=theirs)[1])
    assert adjusted == pytest.approx(pingouin.multicomp(p, method=theirs)[1])


def test_undefined_probabilities_do_not_count_as_comparisons():
    adjusted = adjust_p(np.array([0.01, np.nan, 0.04]))
    assert adjusted[[0, 2]] == pytest.approx([0.02, 0.04])
    assert np.isnan(adjusted[1])
    assert adjust_p(np.array([0.01, 0.5]), "none").tolist() == [0.01, 0.5]
    with pytest.raises(ConfigError, match="holm"):
        adjust_p(np.array([0.5]), "bonferroni")


def test_an_analysis_of_variance_of_group_means_gives_nearly_the_same_probability():
    """With two conditions and one mean per group, repeated-measures anova is the paired t test."""
    groups = np.arange(9)
    first = RNG.normal(0.41, 0.07, 9)
    second = first + RNG.normal(0.05, 0.06, 9)
    table = pandas.DataFrame(
        {
            "gsi": np.concatenate([first, second]),
            "group": np.concatenate([groups, groups]),
            "method": np.repeat(["a", "b"], 9),
        }
    )
    anova = AnovaRM(table, "gsi", "group", within=["method"]).fit().anova_table["Pr > F"].iloc[0]
    assert sign_flip_p(second - first, RNG)[0] == pytest.approx(anova, abs=0.03)
