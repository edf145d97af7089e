"""Tests of scores and timetables."""

import math

import pytest

from sjasim.choreography.paper import paper
from sjasim.choreography.timetable import timetable
from sjasim.config import DanceConfig, SessionConfig
from sjasim.core.errors import ConfigError, PluginError, UnknownNameError

BEAT_S = 60 / 118


def test_the_papers_dance_has_nine_events_in_order():
    steps = paper().steps()

    kinds = ["start_forward", "stop_forward", "start_backward", "stop_backward"] * 2 + ["clap"]
    assert [step.kind for step in steps] == kinds
    assert [step.ordinal for step in steps] == list(range(9))
    assert [step.occurrence for step in steps] == [0] * 4 + [1] * 4 + [0]
    assert [step.beat for step in steps] == [0, 4, 8, 12, 16, 20, 24, 28, 32]


def test_a_turn_shares_the_ordinal_of_its_clap():
    dance = paper()
    assert [dance.first_ordinal(index) for index in range(6)] == [0, 2, 4, 6, 8, 8]


def test_the_default_timetable_is_the_papers_with_a_rehearsal(paper_timetable):
    assert paper_timetable.choreography == paper()
    assert (paper_timetable.first, paper_timetable.last) == (0, 4)
    assert paper_timetable.lead_in_s == 4.0


def test_iterations_follow_each_other_and_windows_divide_time(paper_timetable):
    table = paper_timetable

    for iteration in range(5):
        assert table.start_s(iteration) == pytest.approx(4.0 + 40 * iteration * BEAT_S)
        assert table.close_s(iteration) == pytest.approx(table.start_s(iteration) + 36 * BEAT_S)
        assert table.iteration_at(table.time_s(iteration, 32.0)) == iteration
        assert table.iteration_at(table.close_s(iteration) + 0.01) == min(iteration + 1, 4)

    assert table.iteration_at(0.0) == 0
    assert table.end_s() == pytest.approx(4.0 + 200 * BEAT_S)


def test_headings_advance_counter_clockwise_from_north(paper_timetable):
    headings = [paper_timetable.heading_rad(iteration) for iteration in range(5)]
    assert headings == pytest.approx([0.0, math.pi / 2, math.pi, 3 * math.pi / 2, 2 * math.pi])


def test_without_a_rehearsal_the_song_begins_with_iteration_one():
    table = timetable(SessionConfig(dance=DanceConfig(rehearsal=False)))
    assert (table.first, table.last) == (1, 4)
    assert table.start_s(1) == pytest.approx(4.0)


def test_an_unknown_dance_and_a_plug_in_that_is_not_a_dance_are_refused():
    with pytest.raises(UnknownNameError, match="paper"):
        timetable(SessionConfig(dance=DanceConfig(name="tango")))
    with pytest.raises(PluginError, match="not a Choreography"):
        timetable(SessionConfig(dance=DanceConfig(name="builtins:dict")))


def test_a_changing_tempo_and_a_pause_bend_the_timetable():
    music = DanceConfig(tempo=((80.0, 1.0), (120.0, 1.25)), pauses=((48.0, 2.0),))
    table = timetable(SessionConfig(dance=music))

    assert table.time_s(1, 4.0) - table.start_s(1) == pytest.approx(4 * BEAT_S)
    assert table.time_s(1, 8.0) - table.time_s(1, 4.0) == pytest.approx(4 * BEAT_S + 2.0)
    assert table.start_s(4) - table.start_s(3) == pytest.approx(40 * BEAT_S / 1.25)
    assert 40 * BEAT_S / 1.25 < table.start_s(3) - table.start_s(2) < 40 * BEAT_S


@pytest.mark.parametrize(
    ("field", "value", "allowed"),
    [
        ("tempo", ((0.0, 3.0),), "0.5 to 2"),
        ("tempo", ((-1.0, 1.0),), "0 to"),
        ("tempo", ((8.0, 1.0), (4.0, 1.2)), "beats rise"),
        ("pauses", ((8.0, -1.0),), "0 to 60"),
        ("pauses", ((8.0, 1.0), (8.0, 1.0)), "beats rise"),
    ],
)
def test_an_impossible_tempo_is_refused(field, value, allowed):
    with pytest.raises(ConfigError, match=rf"dance\.{field}.*{allowed}"):
        DanceConfig(**{field: value})
