"""The replay of a session's actuator targets is the session's own physics."""

from __future__ import annotations

import dataclasses

import numpy as np

from sjasim.session.session import Session
from sjasim.simulation.physics_world import physics_of
from sjasim.simulation.profiling import CpuProfiler, PhysicsReplay, instrument_session


def test_an_instrumented_session_can_be_replayed_exactly(short_config):
    session = Session(dataclasses.replace(short_config, method="eca"))
    physics = physics_of(session).physics
    start = (physics.data.qpos.copy(), physics.data.qvel.copy())
    profiler = CpuProfiler()
    controls = instrument_session(profiler, session)
    session.advance(8.0)
    session.log()

    replay = PhysicsReplay(physics.model, start, controls)
    replay.advance(physics.tick)
    assert physics.tick > 0
    assert np.array_equal(replay.data.qpos, physics.data.qpos)

    components = {"physics", "stabiliser", "planning", "sensing", "robot", "server", "decision", "logging"}
    assert set(profiler.spent_s) == components
    assert profiler.calls["physics"] == len(controls)
