"""The published table agrees with what the article says of it."""

import numpy as np
import pytest

from sjasim.assets import published_study as paper


@pytest.mark.parametrize("method", ["eca", "sia"])
def test_the_printed_means_are_those_of_the_cells_up_to_rounding(method):
    cells = np.array(paper.GSI[method])
    assert cells.shape == (9, 4)
    # A group's printed mean is that of four cells, each rounded to two decimals.
    assert np.abs(cells.mean(axis=1) - paper.GSI_GROUP_MEANS[method]).max() <= 0.0101


def test_sia_wins_as_often_as_the_article_counts():
    differences = np.array(paper.GSI["sia"]) - np.array(paper.GSI["eca"])
    assert (int((differences > 0).sum()), differences.size) == paper.ITERATIONS_WON
    # The group with equal printed means counts for SIA, which the table prints in bold.
    means = np.array(paper.GSI_GROUP_MEANS["sia"]) - np.array(paper.GSI_GROUP_MEANS["eca"])
    assert (int((means >= 0).sum()), means.size) == paper.GROUPS_WON


def test_the_means_over_36_iterations():
    assert np.mean(paper.GSI["eca"]) == pytest.approx(0.4108, abs=5e-5)
    assert np.mean(paper.GSI["sia"]) == pytest.approx(0.4556, abs=5e-5)
    assert np.mean(paper.GSI["sia"], axis=0) == pytest.approx([0.361, 0.392, 0.534, 0.534], abs=5e-4)
