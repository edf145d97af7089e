"""Faults: each one has a cost, is reported in the log, and lets the session end."""

import pytest

from sjasim.config import NetworkConfig
from sjasim.core import ROBOT

from .conftest import regular_events, run_short_session

FAULT_S = 10.0
"""Session time of the faults, between the second and the third move [s]."""


@pytest.fixture(scope="module")
def lossy():
    return run_short_session(network=NetworkConfig(packet_loss=0.2))


def test_without_faults_there_is_no_notice(clean):
    assert clean.notices == []
    assert clean.measures.robot.executed == 1.0
    assert clean.measures.robot_missed == 0
    assert clean.measures.detector.precision == 1.0


def test_a_dead_sensor_that_nobody_faces_is_reported_and_costs_nothing(clean):
    session = run_short_session(("dead_sensor", "east", FAULT_S))
    assert session.notices == [("east", "client is dead: silent for more than 1 s")]
    assert [e.kind for e in session.log.events] == [e.kind for e in clean.log.events]


def test_when_the_active_sensor_dies_another_takes_over_and_detects_less(clean):
    session = run_short_session(("dead_sensor", "north", FAULT_S))
    assert ("north", "client is dead: silent for more than 1 s") in session.notices
    assert any("takes over from north" in what for _, what in session.notices)
    late = [event for event in session.log.events if event.t_s > FAULT_S + 1.5]
    assert late
    assert "north" not in {event.sensor for event in late}
    assert session.measures.detector.logged < clean.measures.detector.logged
    seen = session.measures.detector
    assert seen.logged - 3 <= seen.visible < seen.true  # by whichever sensor is the active one
    assert session.measures.clocks["south"].p95_s < 0.002
    assert session.log.cost["sim_s"] == clean.log.cost["sim_s"]


def test_twenty_per_cent_packet_loss_is_reported_and_costs_events(lossy, clean):
    assert {source for source, what in lossy.notices if what.startswith("link loses packets")} == {
        "north", "west", "south", "east",
    }  # fmt: skip
    assert lossy.measures.detector.logged < clean.measures.detector.logged
    assert lossy.log.cost["sim_s"] == clean.log.cost["sim_s"]


def test_the_robot_dances_through_packet_loss_on_repeated_commands(lossy):
    assert len(lossy.log.commands) == 9
    assert lossy.measures.robot.executed == 1.0


def test_a_clock_jump_is_reported_and_soon_corrected(clean):
    session = run_short_session(("clock_jump", "north", FAULT_S, 2.5))
    ((source, what),) = session.notices
    assert source == "north"
    assert what.startswith("clock jumped by +2.5")
    assert len(regular_events(session, "dancer_1")) == len(regular_events(clean, "dancer_1"))
    for after, before in zip(session.log.events, clean.log.events, strict=True):
        assert after.t_s == pytest.approx(before.t_s, abs=0.05)


def test_a_blocked_robot_is_reported_and_its_steps_are_missed(clean):
    session = run_short_session(("robot_blocked", ROBOT, FAULT_S))
    assert session.notices
    assert {source for source, _ in session.notices} == {ROBOT}
    assert all(what.startswith("blocked") for _, what in session.notices)
    assert session.measures.robot_missed >= 3
    assert session.measures.robot.executed < 0.7
    assert session.measures.gsi_full_edges < clean.measures.gsi_full_edges


def test_a_dead_robot_is_reported_and_its_steps_are_missed(clean):
    session = run_short_session(("dead_robot", ROBOT, FAULT_S))
    assert session.notices == [(ROBOT, "robot is dead: silent for more than 1 s")]
    assert session.log.odometry["t_s"][-1] < FAULT_S
    assert session.measures.robot_missed >= 3
    assert len(session.log.commands) == 9
    assert len(regular_events(session, "dancer_1")) == 9
    assert session.log.cost["sim_s"] == clean.log.cost["sim_s"]
