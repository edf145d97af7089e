"""Where a session's CPU time goes, room by room, and what the bare physics of the same scene costs."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np

from ..config import SessionConfig
from ..core import Array
from ..session.session import Session
from .physics_world import physics_of


@dataclass(slots=True)
class CpuProfiler:
    """CPU seconds and calls by room; a call inside another room's call counts for the inner one only."""

    spent_s: dict[str, float] = field(default_factory=dict)
    calls: dict[str, int] = field(default_factory=dict)
    _inner_s: list[float] = field(default_factory=lambda: [0.0])

    def wrap(self, owner: Any, name: str, room: str) -> None:
        """Count every call of one object's method for a room."""
        original: Callable[..., Any] = getattr(owner, name)

        def timed(*args: Any, **kwargs: Any) -> Any:
            begin = time.process_time()
            self._inner_s.append(0.0)
            try:
                return original(*args, **kwargs)
            finally:
                whole = time.process_time() - begin
                inner = self._inner_s.pop()
                self._inner_s[-1] += whole
                self.spent_s[room] = self.spent_s.get(room, 0.0) + whole - inner
                self.calls[room] = self.calls.get(room, 0) + 1

        setattr(owner, name, timed)


def profile(config: SessionConfig) -> dict[str, Any]:
    """Measure a session by room, then plain, in turn with the bare physics under the same controls.

    A short session comes first, so that nothing is measured that a process does once, such as compiling. Plain
    session and bare physics take turns of a few simulated seconds: a machine that slows down slows both.

    Returns:
        ``sim_s``, ``cpu_s`` of the plain session, ``raw_cpu_s`` of its controls replayed, ``room_cpu_s`` by room,
        ``stabiliser_ticks``, ``decisions`` and ``peak_mb``.
    """
    warm = Session(config)
    warm.advance(WARM_S)
    warm.log()
    meter, metered = CpuProfiler(), Session(config)
    start = (physics_of(metered).physics.data.qpos.copy(), physics_of(metered).physics.data.qvel.copy())
    controls = instrument_session(meter, metered)
    metered.advance(metered.end_s)
    metered.log()
    bare = PhysicsReplay(physics_of(metered).physics.model, start, controls)
    begin = time.process_time()
    plain = Session(config)
    cpu_s, raw_cpu_s = time.process_time() - begin, 0.0
    while plain.time_s < plain.end_s - 1e-9:
        begin = time.process_time()
        plain.advance(min(plain.time_s + TURN_S, plain.end_s))
        middle = time.process_time()
        bare.advance(physics_of(plain).physics.tick)
        cpu_s, raw_cpu_s = cpu_s + middle - begin, raw_cpu_s + time.process_time() - middle
    begin = time.process_time()
    plain.log()
    cpu_s += time.process_time() - begin
    if not np.array_equal(bare.data.qpos, physics_of(plain).physics.data.qpos):
        raise AssertionError("the replayed physics went another way than the session's")
    return {
        "sim_s": plain.end_s,
        "cpu_s": cpu_s,
        "raw_cpu_s": raw_cpu_s,
        "room_cpu_s": meter.spent_s,
        "stabiliser_ticks": meter.calls["stabiliser"],
        "decisions": meter.calls.get("decision"),
        "peak_mb": peak_mb(),
    }


WARM_S = 10.0
"""How much of a session is danced before anything is measured."""

TURN_S = 4.0
"""Simulated seconds of each turn."""


class PhysicsReplay:
    """The same physics with nothing around it.

    Args:
        model: of the session.
        start: its first positions and velocities.
        controls: what `instrument_session` recorded.
    """

    def __init__(self, model: Any, start: tuple[Array, Array], controls: list[tuple[int, Array]]) -> None:
        self._model = model
        self.data = mujoco.MjData(model)
        self.data.qpos[:], self.data.qvel[:] = start
        mujoco.mj_forward(model, self.data)
        self._controls = iter(controls)
        self._tick = 0

    def advance(self, goal: int) -> None:
        """Go on to a tick."""
        ctrl = self.data.ctrl
        while self._tick < goal:
            until, control = next(self._controls)
            ctrl[:] = control
            mujoco.mj_step(self._model, self.data, until - self._tick)
            self._tick = until


def instrument_session(meter: CpuProfiler, session: Session) -> list[tuple[int, Array]]:
    """Watch every room of a session; returns the list that its controls will be recorded in.

    The turns of dancers and robot write their rows of the log themselves, so these count for stabiliser and robot.
    """
    world = physics_of(session)
    physics = world.physics
    controls: list[tuple[int, Array]] = []
    step = physics.step_to

    def recording(tick: int) -> None:
        controls.append((tick, physics.data.ctrl.copy()))
        step(tick)

    physics.step_to = recording  # type: ignore[method-assign]
    watched = [
        (physics, "step_to", "physics"), (world.dancers, "step", "stabiliser"),
        (world.scheduler, "decide", "planning"), (world.scheduler, "plan", "planning"),
        (world, "update_sensors", "sensing"),
        (world, "update_robot", "robot"),
        (session.server, "receive", "server"), (session.server, "due", "server"), (session.dispatcher, "due", "server"),
    ]  # fmt: skip
    watched += [
        (session, "log", "logging"),
        *((world.recorder, name, "logging") for name in ("add_frame", "add_skeletons")),
    ]
    if session.method is not None:
        hooks = ("on_event", "on_iteration_start", "on_iteration_end", "on_timer")
        watched += [(session.method, name, "decision") for name in hooks]
    for owner, name, room in watched:
        meter.wrap(owner, name, room)
    return controls


def profile_depth(config: SessionConfig) -> dict[str, Any]:
    """Measure a whole session with depth sensing, hand-overs included, and a frame of it.

    Image, noise and skeletons of the first active sensor are watched in a second session, so that the first one is
    measured without anybody looking.

    Returns:
        ``depth_sim_s`` and ``depth_cpu_s`` of the session; ``depth_frames`` and ``depth_frame_cpu_s`` of the frames.
    """
    config = replace(config, sensing="depth")
    Session(config).advance(WARM_S)
    begin = time.process_time()
    session = Session(config)
    session.advance(session.end_s)
    session.log()
    cpu_s = time.process_time() - begin
    meter, watched = CpuProfiler(), Session(config)
    meter.wrap(physics_of(watched).sensing[watched.server.active], "sample", "depth")
    watched.advance(WARM_S)
    return {
        "depth_sim_s": session.end_s,
        "depth_cpu_s": cpu_s,
        "depth_frames": meter.calls["depth"],
        "depth_frame_cpu_s": meter.spent_s["depth"],
    }


def peak_mb() -> float | None:
    """Peak memory of this process [MB]; None where the system does not tell."""
    try:
        import resource
    except ImportError:
        return None
    import sys

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)
