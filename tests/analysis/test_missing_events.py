"""Steps left out, events that were not logged, and logged events that did not happen."""

import dataclasses

import pytest

from sjasim.analysis.missing_events import missing_events
from sjasim.choreography.timetable import timetable
from sjasim.config.toml_file import from_plain
from sjasim.core import Kind


@pytest.fixture(scope="module")
def log(make_session_log):
    return make_session_log(iterations=2, spread_s=0.0, joints=False)


def keys(events):
    return {(event.iteration, event.agent, event.kind) for event in events}


def test_nothing_is_missing_in_a_perfect_session(log):
    found = missing_events(log)
    assert found.not_performed == found.not_logged == found.false == ()


def test_an_event_that_was_not_logged_stands_at_its_true_time(log):
    index, lost = next((k, e) for k, e in enumerate(log.events) if (e.iteration, e.person) == (2, "dancer_3"))
    found = missing_events(dataclasses.replace(log, events=log.events[:index] + log.events[index + 1 :]))
    assert keys(found.not_logged) == {(2, "dancer_3", lost.kind)}
    assert found.not_logged[0].t_s == pytest.approx(lost.t_s - 0.12, abs=0.02)
    assert found.not_performed == found.false == ()


def test_a_logged_event_far_from_every_true_one_is_false(log):
    false = dataclasses.replace(log.events[-1], t_s=log.events[-1].t_s - 1.0)
    found = missing_events(dataclasses.replace(log, events=(*log.events, false)))
    assert [event.t_s for event in found.false] == [false.t_s]
    assert found.not_logged == ()


def test_a_move_that_a_dancer_left_out_stands_at_the_others_mean(log):
    """In the event-level world the plans are the truth: without a cue nobody moves."""
    cues = tuple(c for c in log.cues if (c.dancer, c.iteration, c.ordinal) != ("dancer_1", 1, 2))
    events = tuple(
        e for e in log.events
        if (e.person, e.iteration) != ("dancer_1", 1) or e.kind not in (Kind.START_BACKWARD, Kind.STOP_BACKWARD)
    )  # fmt: skip
    found = missing_events(dataclasses.replace(log, cues=cues, events=events, truth={}))
    left_out = {event.kind: event for event in found.not_performed}
    assert keys(found.not_performed) == {(1, "dancer_1", Kind.START_BACKWARD), (1, "dancer_1", Kind.STOP_BACKWARD)}

    table = timetable(from_plain(log.config))
    beat = table.choreography.steps()[2].beat
    assert left_out[Kind.START_BACKWARD].t_s == pytest.approx(table.time_s(1, beat))
    # The second move back was performed, but its events are among those that were taken out.
    assert keys(found.not_logged) == keys(found.not_performed)


def test_a_turn_that_the_robot_left_out_is_a_turn(log):
    robot = tuple(e for e in log.robot_events if (e.iteration, e.kind) != (2, Kind.TURN))
    found = missing_events(dataclasses.replace(log, robot_events=robot, odometry={}))
    assert keys(found.not_performed) == {(2, "robot", Kind.TURN)}
    # With its odometry the true turn is known: it happened and was not logged.
    found = missing_events(dataclasses.replace(log, robot_events=robot))
    assert keys(found.not_logged) == {(2, "robot", Kind.TURN)}


def test_a_step_that_nobody_performed_stands_at_its_beat(log):
    cues = tuple(c for c in log.cues if (c.iteration, c.ordinal) != (1, 8))
    found = missing_events(dataclasses.replace(log, cues=cues, truth={}))
    table = timetable(from_plain(log.config))
    claps = [event for event in found.not_performed if event.kind is Kind.CLAP]
    assert [event.agent for event in claps] == ["dancer_1", "dancer_2", "dancer_3"]
    assert {event.t_s for event in claps} == {table.time_s(1, table.choreography.steps()[8].beat)}
