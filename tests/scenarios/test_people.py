"""People who are late, who stop, who dance among themselves."""

import pytest

from sjasim.config import DanceConfig

from .conftest import dance, heard_of


@pytest.fixture(scope="module")
def by_themselves():
    """Two iterations (the rehearsal is one) without a robot; the first dancer is always half a second late."""
    return dance(method="none", humans="one-late", dance=DanceConfig(rehearsal=True))


@pytest.fixture(scope="module")
def stopped():
    return dance(("dancer_stops", "dancer_2", 0.0))


def test_a_dancer_who_is_always_late_is_never_the_most_synchronous(by_themselves):
    late = [event.t_s for event in heard_of(by_themselves, "dancer_1")]
    others = [event.t_s for event in heard_of(by_themselves, "dancer_3")]
    assert late[0] - others[0] > 0.25
    assert [row.msp for row in by_themselves.measures.iterations].count("dancer_1") == 0


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
