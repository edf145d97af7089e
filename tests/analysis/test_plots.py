"""Figures are drawn for every kind of session, and existing ones are not overwritten unasked."""

import pytest

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.core.errors import RecordError

pytest.importorskip("matplotlib")

from sjasim.analysis import plots


@pytest.fixture(scope="module")
def log(make_session_log):
    return make_session_log(iterations=2, joints=False)


def test_every_figure_is_written_and_protected(log, tmp_path):
    found = delay_report(log)
    paths = plots.save_plots(log, found, tmp_path / "plots")
    assert {path.name for path in paths} == set(plots.FILES)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)
    with pytest.raises(RecordError, match="--overwrite"):
        plots.check_plots(tmp_path / "plots", overwrite=False)
    plots.check_plots(tmp_path / "plots", overwrite=True)


def test_a_humans_only_session_has_no_figures_of_the_robot(make_session_log, tmp_path):
    log = make_session_log(method="none", robot=False, iterations=1, joints=False)
    paths = plots.save_plots(log, delay_report(log), tmp_path)
    assert {path.name for path in paths} == {"raster.png", "graph.png"}


def test_axes_have_units_and_titles(log):
    found = delay_report(log)
    for figure in (plots.timing([value for _, value in found.ta]), plots.delays(found)):
        for axes in figure.axes:
            assert axes.get_title()
            assert "[s]" in axes.get_xlabel()
