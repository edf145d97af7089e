"""Lanes: no label is wider than its bar, and an iteration says whom the robot followed."""

import dataclasses

import numpy as np
import pytest

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.config import SessionConfig
from sjasim.config.toml_file import from_plain

pytest.importorskip("rerun")

from sjasim.record.rerun import timeline
from sjasim.record.rerun.entity_stream import Span
from sjasim.record.rerun.timeline import BRIEF, NO_STATE


class SentLanes:
    """Stands in for a stream, and keeps the states of every lane."""

    def __init__(self):
        self.states = {}
        self.styles = {}

    def send_columns(self, entity, t_s, columns):
        states = [state for column in columns for row in column.as_arrow_array().to_pylist() for state in row]
        self.states[entity] = list(zip(t_s, states, strict=True))

    def log_static(self, entity, style):
        self.styles[entity] = style


def sent(marks):
    """States that are sent for the marks of one lane."""
    stream = SentLanes()
    timeline._send_lane(stream, "x", marks, Span())
    return stream.states["lanes/x"]


@pytest.mark.parametrize(("state", "shortest_s"), [("stop", 0.621), ("late", 0.621), ("backward", 1.104)])
def test_a_bar_that_is_too_short_for_its_label_has_none(state, shortest_s):
    assert sent([(1.0, 1.0 + shortest_s + 0.01, state)])[0] == (1.0, state)
    assert sent([(1.0, 1.0 + shortest_s - 0.01, state)])[0] == (1.0, f"{state}{BRIEF}")


def test_a_mark_that_the_next_one_cuts_off_counts_with_its_visible_length():
    states = sent([(1.0, np.inf, "forward"), (1.3, 1.95, "stop")])
    assert states == [(1.0, f"forward{BRIEF}"), (1.3, "stop"), (1.95, NO_STATE)]


def test_moments_have_space_for_their_words():
    assert all(timeline._has_space(word, timeline.MOMENT_S) for word in ("stop", "clap", "turn"))


def test_brief_states_have_the_colour_of_their_state_and_no_label():
    stream = SentLanes()
    timeline.log_static_lanes(stream, SessionConfig())
    style = stream.styles["lanes/robot/timing"]
    values, labels = (column.as_arrow_array().to_pylist() for column in (style.values, style.labels))
    colours = style.colors.as_arrow_array().to_pylist()
    assert len(values) == len(labels) == len(colours)
    late, brief = values.index("late"), values.index(f"late{BRIEF}")
    assert (labels[late], labels[brief].strip()) == ("late", "")
    assert colours[late] == colours[brief]


@pytest.mark.parametrize(("method", "words"), [("sia", ["nobody", "dancer_1"]), ("eca", ["everyone", "everyone"])])
def test_the_lane_says_whom_the_robot_followed(make_session_log, method, words):
    log = make_session_log(method=method, iterations=2, joints=False)
    stream = SentLanes()
    timeline.send_report_lanes(stream, delay_report(log), from_plain(log.config))
    states = [state for _, state in stream.states["lanes/robot/follows"] if state != NO_STATE]
    assert states == words


def test_without_a_robot_nobody_follows(make_session_log):
    log = make_session_log(method="none", robot=False, iterations=1, joints=False)
    report = delay_report(dataclasses.replace(log, followed=()))
    assert [graph.followed for graph in report.graphs] == [""]
