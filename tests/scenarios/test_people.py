"""Sessions with dancers who are late, who stop, who dance without a robot, or who follow it."""

import pytest

from sjasim.choreography.timetable import timetable
from sjasim.config import DanceConfig
from sjasim.config.toml_file import from_plain
from sjasim.core import Move

from .conftest import regular_events, run_short_session


@pytest.fixture(scope="module")
def humans_only():
    """A whole dance with a rehearsal and without a robot; the first dancer is always half a second late."""
    return run_short_session(method="none", humans="one-late", iterations=4, dance=DanceConfig(rehearsal=True))


@pytest.fixture(scope="module")
def stopped():
    return run_short_session(("dancer_stops", "dancer_2", 0.0))


def test_a_dancer_who_is_always_late_is_never_the_most_synchronous(humans_only):
    late = [event.t_s for event in regular_events(humans_only, "dancer_1")]
    others = [event.t_s for event in regular_events(humans_only, "dancer_3")]
    assert late[0] - others[0] > 0.25
    assert len(humans_only.measures.iterations) == 4
    assert "dancer_1" not in {row.msp for row in humans_only.measures.iterations}


def test_method_none_is_humans_only(humans_only):
    log, figures = humans_only.log, humans_only.measures
    assert log.commands == log.decisions == log.robot_events == ()
    assert log.odometry == {}
    assert figures.ta_s == ()
    assert figures.robot.commands == figures.robot_missed == 0
    assert figures.iterations[0].gsi > 0.2
    assert humans_only.notices == []
    assert figures.as_dict()["ta_mean_s"] is None


def test_a_dancer_who_stops_is_reported_and_the_others_continue(stopped, clean):
    assert stopped.notices == [("dancer_2", "no event seen in iteration 1")]
    assert regular_events(stopped, "dancer_2") == []
    assert len(regular_events(stopped, "dancer_1")) == len(regular_events(clean, "dancer_1")) == 9
    assert stopped.measures.gsi_full_edges < clean.measures.gsi_full_edges
    assert stopped.log.cost["sim_s"] == clean.log.cost["sim_s"]
    assert stopped.measures.robot_missed == 0


def test_a_dancer_who_stops_within_an_iteration_is_reported():
    session = run_short_session(("dancer_stops", "dancer_2", 10.0))
    assert session.notices == [("dancer_2", "no event seen in iteration 1 after 4 of 9")]
    assert len(regular_events(session, "dancer_1")) == 9


def test_dancers_coupled_to_a_late_robot_become_late(tmp_path):
    """They decide move by move: the first move is on the beat, and each later one is nearer to the robot's."""
    coupled = tmp_path / "coupled.toml"
    coupled.write_text("robot_coupling = 0.5\n")
    late = run_short_session(method="metronome", humans=str(coupled), method_options={"lead_s": -0.3})

    table = timetable(from_plain(late.log.config))
    lateness = {}
    for cue in late.log.cues:
        lateness.setdefault(cue.ordinal, []).append(cue.t_s - table.time_s(1, cue.beat))
    robot = [event.t_s for event in late.log.robot_events]
    assert len(robot) == 9
    robot_s = robot[2] - table.time_s(1, 8.0)
    assert robot_s > 0.2
    assert lateness[0] == pytest.approx([0.0] * 3)
    assert 0.3 * robot_s < lateness[2][0] < 0.8 * robot_s
    assert lateness[2][0] < lateness[6][0] < 1.1 * robot_s
    assert late.measures.robot_missed == 0


def test_dancers_and_robot_follow_an_accelerando_with_a_pause():
    """A robot that keeps to the beat is as well timed as in steady music."""
    music = DanceConfig(rehearsal=False, tempo=((0.0, 1.0), (30.0, 1.25)), pauses=((16.0, 2.0),))
    bent = run_short_session(method="metronome", dance=music)
    table = timetable(from_plain(bent.log.config))
    moves = [cue for cue in bent.log.cues if cue.move is not Move.TURN]
    assert len(moves) == 15
    assert [cue.t_s for cue in moves] == pytest.approx([table.time_s(1, cue.beat) for cue in moves])

    assert table.time_s(1, 16.0) - table.time_s(1, 12.0) > 3.5
    assert bent.measures.robot_missed == 0
    assert bent.measures.ta_mean_s < 0.25
    assert bent.measures.as_dict()["falls"] == 0
