"""Figures are drawn for every kind of session, and existing ones are not overwritten unasked."""

import pytest

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.core.errors import RecordError

pytest.importorskip("matplotlib")

from sjasim.analysis.plots.delays import delays_figure
from sjasim.analysis.plots.files import FILES, check_plots, save_plots
from sjasim.analysis.plots.graphs import graphs_figure
from sjasim.analysis.plots.timing import timing_figure


@pytest.fixture(scope="module")
def log(make_session_log):
    return make_session_log(iterations=2, joints=False)


def test_every_figure_is_written_and_protected(log, tmp_path):
    folder = tmp_path / "plots"
    paths = save_plots({"sia-0": (log, delay_report(log))}, folder)
    assert {path.name for path in paths} == set(FILES)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)
    with pytest.raises(RecordError, match="--overwrite"):
        check_plots(folder, overwrite=False)
    check_plots(folder, overwrite=True)


def test_two_sessions_share_the_figure_of_timing_and_have_their_own_others(log, tmp_path):
    session = (log, delay_report(log))
    paths = save_plots({"sia-0": session, "eca-0": session}, tmp_path)
    own = {f"{label}-{name}" for label in ("sia-0", "eca-0") for name in ("raster.png", "graph.png", "delays.png")}
    assert {path.name for path in paths} == own | {"timing.png"}
    with pytest.raises(RecordError, match=r"eca-0-delays.png exists"):
        check_plots(tmp_path, overwrite=False)


def test_a_humans_only_session_has_no_figures_of_the_robot(make_session_log, tmp_path):
    log = make_session_log(method="none", robot=False, iterations=1, joints=False)
    paths = save_plots({"none-0": (log, delay_report(log))}, tmp_path)
    assert {path.name for path in paths} == {"raster.png", "graph.png"}


def test_axes_have_units_and_titles(log):
    found = delay_report(log)
    for figure in (timing_figure({"sia": [value for _, value in found.ta]}), delays_figure(found)):
        for axes in figure.axes:
            assert axes.get_title()
            assert "[s]" in axes.get_xlabel()


def test_every_iteration_has_a_graph(log):
    titles = [axes.get_title() for axes in graphs_figure(delay_report(log).graphs).axes]
    assert [title.partition(":")[0] for title in titles] == ["iteration 1", "iteration 2"]
