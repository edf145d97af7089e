"""The raster shows every iteration, and marks what is missing."""

import dataclasses

import pytest

from sjasim.core import Kind

pytest.importorskip("matplotlib")

from sjasim.analysis.plots.raster import MISSING_STYLES, raster_figure


@pytest.fixture(scope="module")
def log(make_session_log):
    return make_session_log(iterations=2, joints=False)


def frames(axes, name):
    """Number of marks of one kind of missing event in a panel."""
    marker, colour, _, _ = MISSING_STYLES[name]
    lines = [line for line in axes.lines if len(line.get_xdata()) == 1]
    return sum(line.get_marker() == marker and line.get_color() == colour for line in lines)


def test_every_iteration_has_a_panel_without_marks_if_nothing_is_missing(log):
    figure = raster_figure(log)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["iteration 1", "iteration 2"]
    assert all(frames(axes, name) == 0 for axes in figure.axes for name in MISSING_STYLES)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[-3:] == ["step left out", "event missed by the sensors", "false event"]
    names = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert names == ["dancer_1", "dancer_2", "dancer_3", "robot"]


def test_a_missed_and_a_false_event_are_marked_in_their_iteration(log):
    missed = next(e for e in log.events if (e.iteration, e.kind) == (2, Kind.CLAP))
    false = dataclasses.replace(missed, t_s=missed.t_s - 3.0)
    events = (*(event for event in log.events if event is not missed), false)
    first, second = raster_figure(dataclasses.replace(log, events=events)).axes
    assert [frames(first, name) for name in MISSING_STYLES] == [0, 0, 0]
    assert [frames(second, name) for name in ("not_performed", "not_logged", "false")] == [0, 1, 1]


def test_a_step_that_the_robot_left_out_is_marked(log):
    robot = tuple(e for e in log.robot_events if (e.iteration, e.kind) != (1, Kind.TURN))
    # Without odometry, the robot's logged events are the truth.
    first, second = raster_figure(dataclasses.replace(log, robot_events=robot, odometry={})).axes
    assert (frames(first, "not_performed"), frames(second, "not_performed")) == (1, 0)


def test_a_humans_only_session_has_no_row_of_the_robot(make_session_log):
    (axes,) = raster_figure(make_session_log(method="none", robot=False, iterations=1, joints=False)).axes
    assert len(axes.get_yticks()) == 3
