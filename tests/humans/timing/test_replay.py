"""Tests of the replay timing model: event tables are performed as they stand, or refused with the line at fault."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.choreography.timetable import Timetable
from sjasim.core import Kind, Move
from sjasim.core.errors import ConfigError, RecordError
from sjasim.core.session_log import TableEvent
from sjasim.core.tempo import TempoMap
from sjasim.humans.timing.ensemble import EnsembleTiming
from sjasim.humans.timing.parameters import preset
from sjasim.humans.timing.replay import Replay

from ..dancing import dance

TABLE = Timetable(dance(), TempoMap.steady(118), 4.0, 0, 2)
BEAT_S = 60 / 118


def score(agents=("dancer_1",), iterations=(0, 1, 2), late_s=0.0) -> list[TableEvent]:
    """Rows of a table whose dancers keep to the score, with a constant lateness."""
    rows = []
    for iteration in iterations:
        for step in TABLE.choreography.steps():
            t_s = TABLE.time_s(iteration, step.beat) + late_s
            rows += [
                TableEvent("s", iteration, agent, step.kind, t_s, False, 2 + len(rows) + k)
                for k, agent in enumerate(agents)
            ]
    return rows


def replayed(rows, dancers=1) -> list[tuple]:
    """Cues of all dancers in iterations 0 to 2."""
    model = Replay(rows, "events.csv", TABLE, dancers)

    out = []
    for iteration in range(3):
        model.begin(iteration, None, np.zeros(dancers))
        assert model.next_due_s < 0
        out.append(model.decide(0.0, ()))
        assert model.next_due_s == math.inf
    return out


def without(rows, *places):
    """The rows but for those at some places."""
    return [row for k, row in enumerate(rows) if k not in places]


def at(rows, place, t_s, kind=None):
    """The rows with another time, and perhaps another kind, at one place."""
    row = rows[place]
    changed = TableEvent(row.session, row.iteration, row.agent, kind or row.kind, t_s, False, row.line)
    return [*rows[:place], changed, *rows[place + 1 :]]


def test_times_are_performed_as_they_stand():
    cues = replayed(score(late_s=0.1))[1][0]
    assert [cue.move for cue in cues] == [Move.FORWARD, Move.BACKWARD] * 2 + [Move.CLAP, Move.TURN]
    nominal = [TABLE.time_s(1, step.beat) + 0.1 for step in TABLE.choreography.steps()]
    assert [t_s for cue in cues for _, t_s in cue.events()] == pytest.approx(nominal)
    assert [cue.ordinal for cue in cues] == [0, 2, 4, 6, 8, 8]
    assert cues[-1].t_s == pytest.approx(nominal[-1] + 0.25)


def test_a_replay_of_a_models_events_gives_the_models_cues():
    model = EnsembleTiming(preset("paper-entrainment"), TABLE, 3, np.random.default_rng(1), np.random.default_rng(2))
    drawn, rows, free = [], [], np.full(3, 0.5)
    for iteration in range(3):
        model.begin(iteration, None, free)
        drawn.append(model.decide(0.0, ()))
        free = np.array([own[-1].t_s + own[-1].duration_s + 0.7 for own in drawn[-1]])
        for own in drawn[-1]:
            rows += [
                TableEvent("s", iteration, cue.dancer, kind, t_s, False, 1)
                for cue in own
                for kind, t_s in (cue.events() or ((Kind.TURN, cue.t_s),))
            ]
    for before, after in zip(drawn, replayed(rows, 3), strict=True):
        for own, again in zip(before, after, strict=True):
            assert [(c.move, c.ordinal) for c in own] == [(c.move, c.ordinal) for c in again]
            assert [c.t_s for c in own] == pytest.approx([c.t_s for c in again])
            assert [c.duration_s for c in own] == pytest.approx([c.duration_s for c in again])


def test_other_names_are_taken_in_natural_order_and_the_robot_is_ignored():
    rows = score(agents=("p10", "p2", "robot"))
    first, second = replayed(rows, 2)[0]
    assert {cue.dancer for cue in first} == {"dancer_1"}
    assert len(first) == len(second) == 6


def test_early_events_are_ignored():
    early = [TableEvent("s", 1, "dancer_1", Kind.CLAP, 1.0, True, 99)]
    assert replayed(score() + early) == replayed(score())


def test_a_missing_stop_or_start_is_completed_with_a_notice():
    rows = without(score(), 10, 13)
    model = Replay(rows, "events.csv", TABLE, 1)
    model.begin(1, None, np.zeros(1))
    cues = model.decide(0.0, ())[0]

    assert cues[0].duration_s == pytest.approx(4 * BEAT_S)
    assert cues[2].t_s + cues[2].duration_s == pytest.approx(TABLE.time_s(1, 20))
    assert cues[2].duration_s == pytest.approx(4 * BEAT_S)
    assert [notice.source for notice in model.notices] == ["dancer_1", "dancer_1"]
    assert all(
        "events.csv, line" in notice.what and "the score's length is used" in notice.what for notice in model.notices
    )


def test_moves_and_holds_too_short_by_a_frame_are_lengthened():
    start = TABLE.time_s(1, 0)
    cues = replayed(at(score(), 10, start + 0.79))[1][0]
    assert cues[0].duration_s == 0.8
    cues = replayed(at(score(), 11, TABLE.time_s(1, 4) + 0.14))[1][0]
    assert cues[1].t_s == pytest.approx(TABLE.time_s(1, 4) + 0.15)


def test_a_phrase_without_events_is_left_out():
    cues = replayed(without(score(), 9, 10, 11, 12))[1][0]
    assert [cue.ordinal for cue in cues] == [4, 6, 8, 8]


def test_in_an_iteration_without_events_dancers_turn_with_the_music():
    cues = replayed(score(iterations=(0, 2)))[1][0]
    assert [cue.move for cue in cues] == [Move.TURN]
    assert cues[0].t_s == pytest.approx(TABLE.time_s(1, 32.5))


def test_a_recorded_turn_keeps_its_time():
    rows = score()
    turn = TableEvent("s", 1, "dancer_1", Kind.TURN, TABLE.time_s(1, 32) + 0.6, False, 50)
    assert replayed([*rows, turn])[1][0][-1].t_s == turn.t_s


S = TABLE.time_s(1, 0)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (at(score(), 10, S + 0.7), r"line 12: .*stop_forward.*a move takes from 0.8 to 6 s, not 0.70 s"),
        (at(score(), 10, S + 7.0), r"line 12: .*not 7.00 s"),
        (at(score(), 11, S + 4 * BEAT_S + 0.1), r"line 13: .*start_backward.*at the earliest, 0.15 s after"),
        (at(score(), 9, S - 3.0), r"line 11: .*events of this iteration lie from"),
        (score(iterations=(0, 1, 2, 3)), r"line 29: .*the dance has iterations 0 to 2"),
        (at(score(), 17, S + 11 * BEAT_S + 3, Kind.START_BACKWARD), r"line 19: .*that of line"),
    ],
)
def test_an_impossible_event_is_refused_with_its_line(rows, says):
    with pytest.raises(RecordError, match=says) as caught:
        Replay(rows, "events.csv", TABLE, 1)
    assert str(caught.value).startswith("events.csv")


def test_a_group_of_another_size_is_refused():
    with pytest.raises(ConfigError, match=r"dancers = 3 .*as many as dance in events.csv: 2 \(p1, p2\)"):
        Replay(score(agents=("p1", "p2")), "events.csv", TABLE, 3)
    with pytest.raises(ConfigError, match="nobody"):
        Replay([], "events.csv", TABLE, 3)


def test_a_turn_without_enough_time_is_refused():
    rows = score()
    clap = 9 + 8
    late = at(rows, clap, TABLE.time_s(2, 0) - 1.0)
    with pytest.raises(RecordError, match=r"line 20: .*start_forward.*no time for a turn of 1 s"):
        Replay(late, "events.csv", TABLE, 1)
    early = TableEvent("s", 1, "dancer_1", Kind.TURN, TABLE.time_s(1, 27), False, 77)
    with pytest.raises(RecordError, match=r"line 77: .*turn.*no time"):
        Replay([*rows, early], "events.csv", TABLE, 1)
