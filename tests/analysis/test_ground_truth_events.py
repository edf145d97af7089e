"""True events: exact crossings, no events from ripple or sway, and one clap per approach of the palms."""

import numpy as np
import pytest

from sjasim.analysis.ground_truth_events import (
    dancer_events,
    debounced_intervals,
    detect_claps,
    detect_moves,
    robot_events,
)
from sjasim.choreography.timetable import timetable
from sjasim.config.toml_file import from_plain
from sjasim.core import Kind

T = np.arange(0, 10, 1 / 60)


def walk(speed, heading=0.7):
    """Moves of an agent with this speed along a constant heading."""
    distance = np.concatenate([[0.0], np.cumsum(speed[:-1]) / 60])
    return detect_moves(T, distance * np.cos(heading), distance * np.sin(heading), np.full(len(T), heading))


def test_true_events_are_the_planned_crossings(make_session_log):
    log = make_session_log(iterations=2, joints=False)
    table = timetable(from_plain(log.config))
    found = dancer_events(log.truth, log.cues, table)
    assert len(found) == 3 * 3 * 9
    planned = {(cue.dancer, cue.iteration, cue.ordinal): cue.t_s for cue in log.cues if cue.move.value != "turn"}
    steps = table.choreography.steps()
    for (dancer, iteration, ordinal), t_s in planned.items():
        times = [e.t_s for e in found if (e.agent, e.iteration, e.kind) == (dancer, iteration, steps[ordinal].kind)]
        assert min(abs(np.array(times) - t_s)) < 0.009


def test_crossings_shorter_than_the_debounce_time_give_no_event():
    speed = 0.25 * ((T > 2) & (T < 4))
    speed[(T > 3.0) & (T < 3.1)] = 0.0
    speed[(T > 7.0) & (T < 7.1)] = 0.25
    assert [kind for _, kind in walk(speed)] == [Kind.START_FORWARD, Kind.STOP_FORWARD]


def test_a_backward_move_that_outlasts_the_data_has_no_stop():
    assert [kind for _, kind in walk(-0.25 * (T > 5))] == [Kind.START_BACKWARD]


def test_a_change_just_before_the_end_of_the_data_does_not_count():
    assert debounced_intervals(T, np.where(T > 9.95, 1.0, -1.0)) == []
    assert debounced_intervals(T[:2], np.array([1.0, 1.0])) == []


def test_one_clap_per_approach():
    hands = np.minimum(0.6, 0.03 + np.minimum(abs(T - 3), abs(T - 7)))
    hands[abs(T - 3.1) < 0.01] = 0.2
    assert detect_claps(T, hands) == pytest.approx([3.0, 7.0], abs=1 / 60)
    assert detect_claps(T, np.full(len(T), 0.13)) == []


def test_unseen_joints_make_events_invisible(make_session_log):
    log = make_session_log(iterations=1, joints=False)
    truth = dict(log.truth)
    truth["spine_seen"] = np.full(len(truth["t_s"]), np.nan)
    found = dancer_events(truth, log.cues, timetable(from_plain(log.config)))
    assert {event.visible for event in found if event.kind is Kind.CLAP} == {True}
    assert {event.visible for event in found if event.kind is not Kind.CLAP} == {False}


def test_sway_inside_a_turn_is_not_a_move(make_session_log):
    log = make_session_log(iterations=1, joints=False)
    table = timetable(from_plain(log.config))
    turn = next(cue for cue in log.cues if cue.move.value == "turn" and cue.iteration == 1 and cue.dancer == "dancer_1")
    truth = {name: column.copy() for name, column in log.truth.items()}
    turning = (truth["dancer"] == 0) & (truth["t_s"] > turn.t_s + 0.3)
    truth["x_m"][turning] += 0.3 * np.clip((truth["t_s"][turning] - turn.t_s - 0.3) / 0.5, 0, 1)
    assert len(dancer_events(truth, log.cues, table)) == len(dancer_events(log.truth, log.cues, table))
    assert len(dancer_events(truth, (), table)) > len(dancer_events(log.truth, (), table))


def test_the_robots_true_events_are_its_logged_ones(make_session_log):
    log = make_session_log(iterations=2, joints=False)
    found = robot_events(log.odometry, timetable(from_plain(log.config)))
    assert [event.kind for event in found] == [event.kind for event in log.robot_events]
    gaps = [a.t_s - b.t_s for a, b in zip(found, log.robot_events, strict=True)]
    assert np.max(np.abs(gaps)) < 0.02
    assert robot_events({}, timetable(from_plain(log.config))) == []
