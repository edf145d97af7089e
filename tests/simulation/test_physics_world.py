"""The physics world: bounded steps, messages to its devices, faults, and moves that are planned when they are due."""

from __future__ import annotations

import pytest

from sjasim.config import FaultConfig
from sjasim.core import ClientStatus, SyncRequest
from sjasim.humans.motion.planner import PREVIEW_S, Planner
from sjasim.simulation.physics_world import PhysicsWorld


def advance(world: PhysicsWorld, until_s: float) -> None:
    while world.time_s < until_s:
        world.advance(until_s)


def move_times_s(world: PhysicsWorld, dancer: str) -> list[float]:
    """Times of a dancer's cues [s]."""
    return [cue.t_s for cue in world.cues if cue.dancer == dancer]


def test_advance_stops_at_the_next_update_and_never_beyond_the_requested_time(make_world):
    world = make_world()
    tick_s = 1 / world.physics.ticks.rate_hz
    assert world.time_s == 0.0
    while world.time_s < 0.3:
        before_s = world.time_s
        world.advance(0.3)
        assert before_s < world.time_s <= min(before_s + 3.5 * tick_s, 0.3 + tick_s)
    assert world.advance(world.time_s) == []


def test_a_clock_exchange_is_answered_with_times_of_the_device_clock(make_world):
    world = make_world()
    advance(world, 0.1)
    reply = world.deliver(world.time_s, world.time_s - 0.001, SyncRequest("west", 0.05))
    assert (reply.sensor, reply.t_server_send_s) == ("west", 0.05)
    assert reply.t_device_send_s - reply.t_device_receive_s == pytest.approx(0.001, rel=1e-3)
    assert abs(reply.t_device_send_s - world.time_s) > 1e-3


def test_a_dead_sensor_sends_nothing_and_the_others_go_on(make_world):
    world = make_world(FaultConfig("dead_sensor", "south", 0.0))
    senders = set()
    while world.time_s < 0.5:
        senders |= {message.sensor for message in world.advance(0.5) if isinstance(message, ClientStatus)}
    assert senders == {"north", "west", "east"}


def test_late_and_stopping_dancers_have_other_cues_than_without_faults(make_world):
    clean = make_world()
    faulty = make_world(FaultConfig("dancer_late", "dancer_1", 5.0, 0.5), FaultConfig("dancer_stops", "dancer_2", 9.0))
    expected_s = [t_s + 0.5 if t_s >= 5.0 else t_s for t_s in move_times_s(clean, "dancer_1")]
    assert move_times_s(faulty, "dancer_1") == pytest.approx(expected_s)
    assert move_times_s(faulty, "dancer_2") == [t_s for t_s in move_times_s(clean, "dancer_2") if t_s < 9.0]
    assert move_times_s(faulty, "dancer_3") == move_times_s(clean, "dancer_3")


def test_without_a_robot_there_is_no_odometry(make_world):
    world = make_world(robot=False)
    advance(world, 0.2)
    assert world.recorder.odometry() == {}
    assert world.recorder.truth()["t_s"].size > 0


def test_every_move_is_planned_within_the_preview_and_not_earlier(make_world, short_config, monkeypatch):
    planned = []
    extend = Planner.extend

    def recording_extend(planner, cues, now_s):
        planned.extend((now_s, cue) for cue in cues)
        extend(planner, cues, now_s)

    monkeypatch.setattr(Planner, "extend", recording_extend)
    world = make_world()
    advance(world, 14.0)
    assert len(planned) >= 3 * 3
    assert {cue.t_s for _, cue in planned} == {cue.t_s for cue in world.cues if cue.t_s <= 14.0 + PREVIEW_S}
    for now_s, cue in planned:
        due_s = max(0.0, cue.t_s - PREVIEW_S)
        assert due_s - 1e-9 <= now_s < due_s + 1.5 / short_config.physics.control_hz
