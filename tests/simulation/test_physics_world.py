"""The world: faults in the plan, what dancers feel of the robot, and that advancing is bounded."""

import dataclasses

import pytest

from sjasim.choreography.layout import layout
from sjasim.choreography.timetable import timetable
from sjasim.config import DanceConfig, FaultConfig, SessionConfig
from sjasim.core import ROBOT, ClientStatus, Cue, Kind, Move, SyncRequest
from sjasim.core.session_log import AgentEvent
from sjasim.humans.motion.planner import PREVIEW_S, Planner
from sjasim.simulation.cast import perceived_timing_error_s
from sjasim.simulation.physics_world import PhysicsWorld

CONFIG = SessionConfig(
    humans="metronomic", sensing="joints", iterations=1, dance=DanceConfig(rehearsal=False, lead_in_s=1.0)
)


def world(*faults, robot=True):
    config = dataclasses.replace(CONFIG, faults=faults)
    place = layout(config)
    return PhysicsWorld(config, timetable(config), place, robot=robot)


def advance(physics, until_s):
    while physics.time_s < until_s:
        physics.advance(until_s)


def starts(physics, dancer):
    return [cue.t_s for cue in physics.cues if cue.dancer == dancer]


def test_advance_goes_from_turn_to_turn_and_never_beyond_the_time_asked():
    physics = world()
    tick_s = 1 / physics.physics.ticks.rate_hz
    assert physics.time_s == 0.0
    while physics.time_s < 0.3:
        before = physics.time_s
        physics.advance(0.3)
        assert before < physics.time_s <= min(before + 3.5 * tick_s, 0.3 + tick_s)
    assert physics.advance(physics.time_s) == []


def test_a_clock_exchange_is_answered_on_the_devices_clock():
    physics = world()
    advance(physics, 0.1)
    reply = physics.deliver(physics.time_s, physics.time_s - 0.001, SyncRequest("west", 0.05))
    assert (reply.sensor, reply.t_server_send_s) == ("west", 0.05)
    assert reply.t_device_send_s - reply.t_device_receive_s == pytest.approx(0.001, rel=1e-3)
    assert abs(reply.t_device_send_s - physics.time_s) > 1e-3


def test_a_dead_sensor_says_nothing_and_the_others_go_on():
    physics = world(FaultConfig("dead_sensor", "south", 0.0))
    heard = set()
    while physics.time_s < 0.5:
        heard |= {m.sensor for m in physics.advance(0.5) if isinstance(m, ClientStatus)}
    assert heard == {"north", "west", "east"}


def test_late_and_stopping_dancers_perform_other_cues_than_they_were_given():
    clean, odd = (
        world(),
        world(FaultConfig("dancer_late", "dancer_1", 5.0, 0.5), FaultConfig("dancer_stops", "dancer_2", 9.0)),
    )
    for given, done in zip(starts(clean, "dancer_1"), starts(odd, "dancer_1"), strict=True):
        assert done - given == pytest.approx(0.5 if given >= 5.0 else 0.0)
    assert starts(odd, "dancer_2") == [t_s for t_s in starts(clean, "dancer_2") if t_s < 9.0]
    assert starts(odd, "dancer_3") == starts(clean, "dancer_3")


def test_without_a_robot_there_is_no_odometry():
    physics = world(robot=False)
    advance(physics, 0.2)
    assert physics.recorder.odometry() == {}
    assert physics.recorder.truth()["t_s"].size > 0


def test_what_dancers_feel_of_the_robot_is_its_distance_from_their_mean():
    cues = [Cue(f"dancer_{k}", Move.FORWARD, 1, 0, 0.0, 10.0 + 0.2 * k, 2.0) for k in range(3)]
    clap = Cue("dancer_1", Move.CLAP, 1, 8, 32.0, 26.0, 0.0)
    robot = [AgentEvent(1, ROBOT, Kind.START_FORWARD, 10.5), AgentEvent(1, ROBOT, Kind.TURN, 26.5)]
    assert perceived_timing_error_s([*cues, clap], robot) == pytest.approx((0.3 + 0.5) / 2)
    assert perceived_timing_error_s(cues, []) is None
    assert perceived_timing_error_s([], robot) is None


def test_every_move_is_planned_when_it_is_due_and_not_before(monkeypatch):
    told = []
    extend = Planner.extend

    def watched(planner, cues, now_s):
        told.extend((now_s, cue) for cue in cues)
        extend(planner, cues, now_s)

    monkeypatch.setattr(Planner, "extend", watched)
    physics = world()
    advance(physics, 14.0)
    assert len(told) >= 3 * 3
    assert {cue.t_s for _, cue in told} == {cue.t_s for cue in physics.cues if cue.t_s <= 14.0 + PREVIEW_S}
    for now_s, cue in told:
        due_s = max(0.0, cue.t_s - PREVIEW_S)
        assert due_s - 1e-9 <= now_s < due_s + 1.5 / CONFIG.physics.control_hz
