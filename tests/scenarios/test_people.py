"""People who are late, who stop, who dance among themselves."""

import pytest

from sjasim.choreography.timetable import timetable
from sjasim.config import DanceConfig
from sjasim.config.toml_file import from_plain
from sjasim.core import Move

from .conftest import dance, heard_of


@pytest.fixture(scope="module")
def by_themselves():
    """A whole dance, rehearsal included, without a robot; the first dancer is always half a second late."""
    return dance(method="none", humans="one-late", iterations=4, dance=DanceConfig(rehearsal=True))


@pytest.fixture(scope="module")
def stopped():
    return dance(("dancer_stops", "dancer_2", 0.0))


def test_a_dancer_who_is_always_late_is_never_the_most_synchronous(by_themselves):
    late = [event.t_s for event in heard_of(by_themselves, "dancer_1")]
    others = [event.t_s for event in heard_of(by_themselves, "dancer_3")]
    assert late[0] - others[0] > 0.25
    assert len(by_themselves.measures.iterations) == 4
    assert "dancer_1" not in {row.msp for row in by_themselves.measures.iterations}


def test_method_none_is_humans_only(by_themselves):
    log, figures = by_themselves.log, by_themselves.measures
    assert log.commands == log.decisions == log.robot_events == ()
    assert log.odometry == {}
    assert figures.ta_s == ()
    assert figures.robot.commands == figures.robot_missed == 0
    assert figures.iterations[0].gsi > 0.2
    assert by_themselves.notices == []
    assert figures.as_dict()["ta_mean_s"] is None


def test_a_dancer_who_stops_is_named_and_the_others_dance_on(stopped, clean):
    assert stopped.notices == [("dancer_2", "no event seen in iteration 1")]
    assert heard_of(stopped, "dancer_2") == []
    assert len(heard_of(stopped, "dancer_1")) == len(heard_of(clean, "dancer_1")) == 9
    assert stopped.measures.gsi_full_edges < clean.measures.gsi_full_edges
    assert stopped.log.cost["sim_s"] == clean.log.cost["sim_s"]
    assert stopped.measures.robot_missed == 0


def test_a_dancer_who_stops_in_mid_dance_is_named_as_well():
    session = dance(("dancer_stops", "dancer_2", 10.0))
    assert session.notices == [("dancer_2", "no event seen in iteration 1 after 4 of 9")]
    assert len(heard_of(session, "dancer_1")) == 9


def test_people_who_heed_a_late_robot_wait_for_it(tmp_path):
    """They decide move by move: the first move is on the beat, and each later one is nearer to the robot's."""
    heed = tmp_path / "heed.toml"
    heed.write_text("robot_coupling = 0.5\n")
    late = dance(method="metronome", humans=str(heed), method_options={"lead_s": -0.3})
    table = timetable(from_plain(late.log.config))
    behind = {}
    for cue in late.log.cues:
        behind.setdefault(cue.ordinal, []).append(cue.t_s - table.time_s(1, cue.beat))
    robot = [event.t_s for event in late.log.robot_events]
    assert len(robot) == 9
    own = robot[2] - table.time_s(1, 8.0)
    assert behind[0] == pytest.approx([0.0] * 3)
    assert own > 0.2
    assert 0.3 * own < behind[2][0] < 0.8 * own
    assert behind[2][0] < behind[6][0] < 1.1 * own
    assert late.measures.robot_missed == 0


def test_people_and_robot_dance_to_music_that_changes_its_tempo():
    """A robot that keeps to the beat is as well timed in an accelerando with a pause as in steady music."""
    music = DanceConfig(rehearsal=False, tempo=((0.0, 1.0), (30.0, 1.25)), pauses=((16.0, 2.0),))
    bent = dance(method="metronome", dance=music)
    table = timetable(from_plain(bent.log.config))
    for cue in bent.log.cues:
        if cue.move is not Move.TURN:
            assert cue.t_s == pytest.approx(table.time_s(1, cue.beat))
    assert table.time_s(1, 16.0) - table.time_s(1, 12.0) > 3.5
    assert bent.measures.robot_missed == 0
    assert bent.measures.ta_mean_s < 0.25
    assert bent.measures.as_dict()["falls"] == 0
