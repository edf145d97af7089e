"""Beats, steps, windows."""

import math

import numpy as np
import pytest

from sjasim.choreography.paper import paper
from sjasim.choreography.score import TempoMap, Timetable
from sjasim.choreography.timetable import timetable
from sjasim.config import DanceConfig, SessionConfig
from sjasim.errors import ConfigError, PluginError, UnknownNameError

BEAT_S = 60 / 118


@pytest.fixture
def table():
    return Timetable(paper(), TempoMap.steady(118), 4.0, 0, 4)


def test_the_papers_dance_has_nine_events_in_order():
    kinds = ["start_forward", "stop_forward", "start_backward", "stop_backward"] * 2 + ["clap"]
    steps = paper().steps()
    assert [step.kind for step in steps] == kinds
    assert [step.ordinal for step in steps] == list(range(9))
    assert [step.occurrence for step in steps] == [0] * 4 + [1] * 4 + [0]
    assert [step.beat for step in steps] == [0, 4, 8, 12, 16, 20, 24, 28, 32]


def test_a_turn_shares_its_claps_ordinal():
    dance = paper()
    assert [dance.first_ordinal(k) for k in range(6)] == [0, 2, 4, 6, 8, 8]


def test_a_steady_tempo():
    assert TempoMap.steady(118).time_s(4.0) == pytest.approx(4 * BEAT_S)
    assert np.allclose(TempoMap.steady(60).time_s(np.array([-1.0, 0.5, 100.0])), [-1.0, 0.5, 100.0])


def test_a_bent_tempo_goes_through_its_points_and_on():
    bent = TempoMap((0.0, 4.0, 8.0), (0.0, 2.0, 6.0))
    assert [float(bent.time_s(beat)) for beat in (-2, 0, 2, 4, 6, 8, 10)] == [-1, 0, 1, 2, 4, 6, 8]


@pytest.mark.parametrize(
    "points", [((0.0,), (0.0,)), ((0.0, 0.0), (0.0, 1.0)), ((0.0, 1.0), (1.0, 0.5)), ((0.0, 1.0), (0.0,))]
)
def test_a_tempo_must_rise(points):
    with pytest.raises(ConfigError, match="tempo"):
        TempoMap(*points)


def test_iterations_follow_each_other_and_windows_divide_time(table):
    for k in range(5):
        assert table.start_s(k) == pytest.approx(4.0 + 40 * k * BEAT_S)
        assert table.close_s(k) == pytest.approx(table.start_s(k) + 36 * BEAT_S)
        assert table.iteration_at(table.time_s(k, 32.0)) == k
        assert table.iteration_at(table.close_s(k) + 0.01) == min(k + 1, 4)
    assert table.iteration_at(0.0) == 0
    assert table.end_s() == pytest.approx(4.0 + 200 * BEAT_S)


def test_headings_go_round_counter_clockwise_from_north(table):
    headings = [table.heading_rad(k) for k in range(1, 5)]
    assert headings == pytest.approx([math.pi / 2, math.pi, 3 * math.pi / 2, 2 * math.pi])
    assert table.heading_rad(0) == pytest.approx(0.0)


def test_without_a_rehearsal_the_song_begins_with_iteration_one():
    table = timetable(SessionConfig(dance=DanceConfig(rehearsal=False)))
    assert (table.first, table.last) == (1, 4)
    assert table.start_s(1) == pytest.approx(4.0)


def test_dances_are_plug_ins():
    with pytest.raises(UnknownNameError, match="paper"):
        timetable(SessionConfig(dance=DanceConfig(name="tango")))
    with pytest.raises(PluginError, match="not a Choreography"):
        timetable(SessionConfig(dance=DanceConfig(name="builtins:dict")))
