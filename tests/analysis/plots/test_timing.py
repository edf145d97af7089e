"""Timing appropriateness in the bins of the paper, with sessions laid over one another."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from sjasim.analysis.plots.timing import histogram_shares, timing_figure


def test_bins_have_a_tenth_of_a_second_and_what_is_beyond_them_is_counted():
    shares = histogram_shares([0.0, 0.05, 0.1, 0.95, 2.49, 2.5, 2.6, 7.0, 0.35, 0.3])
    assert len(shares) == 26
    expected = {0: 20.0, 1: 10.0, 3: 20.0, 9: 10.0, 24: 10.0, 25: 30.0}
    assert {int(bin_): shares[bin_] for bin_ in np.flatnonzero(shares)} == pytest.approx(expected)
    assert shares.sum() == pytest.approx(100.0)


def test_sessions_are_laid_over_one_another_with_their_figures():
    values = {"sia-0": [0.1, 0.3, 0.9, 3.0], "eca-0": [0.7, 1.1]}
    histogram, cumulative = timing_figure(values).axes
    legend = [text.get_text() for text in histogram.get_legend().get_texts()]
    assert legend == ["sia-0: n = 4, mean 1.07 s", "eca-0: n = 2, mean 0.90 s"]

    # Shares within .8, 1.2 and 1.6 s stand beside the guide lines, first those of the first session.
    assert [text.get_text() for text in cumulative.texts] == ["50 %", "75 %", "75 %", "50 %", "100 %", "100 %"]
    curves = [line for line in cumulative.lines if len(line.get_xdata()) > 2]
    assert [line.get_ydata()[-1] for line in curves] == [100.0, 100.0]
    assert len({line.get_color() for line in curves}) == 2


def test_values_beyond_the_axis_keep_the_curve_below_100_percent():
    _, cumulative = timing_figure({"sia-0": [0.1, 3.0]}).axes
    curve = next(line for line in cumulative.lines if len(line.get_xdata()) > 2)
    inside = np.asarray(curve.get_ydata())[np.asarray(curve.get_xdata()) <= 2.5]
    assert inside.max() == 50.0
