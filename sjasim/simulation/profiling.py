"""CPU time of a session by component, and that of the bare physics of the same scene."""

from __future__ import annotations

import sys
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

WARM_UP_S = 10.0
"""Simulated time of the session that runs before the measurement [s]."""

SLICE_S = 4.0
"""Simulated time after which the measurement switches between the session and the bare physics [s]."""

CONTROLLER = "stabiliser"
"""Component of the dancers' control steps, by the name that the benchmark's figures use."""

METHOD_HOOKS = ("on_event", "on_iteration_start", "on_iteration_end", "on_timer")
"""Methods of an anticipation method that a session calls."""

Control = tuple[int, Array]
"""A tick, and the actuator targets until it."""


@dataclass(slots=True)
class CpuProfiler:
    """CPU time and number of calls by component.

    The time of a call inside another component's call counts for the inner one only.

    Attributes:
        spent_s: component -> CPU time [s].
        calls: component -> number of calls.
    """

    spent_s: dict[str, float] = field(default_factory=dict)
    calls: dict[str, int] = field(default_factory=dict)
    _inner_s: list[float] = field(default_factory=lambda: [0.0])

    def wrap(self, owner: Any, name: str, component: str) -> None:
        """Replace a method of one object by one that counts its calls and time for a component."""
        original: Callable[..., Any] = getattr(owner, name)

        def timed(*args: Any, **kwargs: Any) -> Any:
            start_s = time.process_time()
            self._inner_s.append(0.0)
            try:
                return original(*args, **kwargs)
            finally:
                duration_s = time.process_time() - start_s
                inner_s = self._inner_s.pop()
                self._inner_s[-1] += duration_s
                self.spent_s[component] = self.spent_s.get(component, 0.0) + duration_s - inner_s
                self.calls[component] = self.calls.get(component, 0) + 1

        setattr(owner, name, timed)


class PhysicsReplay:
    """The physics of a session alone, with the recorded actuator targets of that session.

    Args:
        model: MuJoCo's model of the session.
        start: initial positions and velocities.
        controls: the recorded targets, see `instrument_session`.

    Attributes:
        data: MuJoCo's state.
    """

    def __init__(self, model: Any, start: tuple[Array, Array], controls: list[Control]) -> None:
        self._model = model
        self.data = mujoco.MjData(model)
        self.data.qpos[:], self.data.qvel[:] = start
        mujoco.mj_forward(model, self.data)
        self._controls = iter(controls)
        self._tick = 0

    def advance(self, tick: int) -> None:
        """Advance the physics to a tick.

        Raises:
            StopIteration: the recorded targets end before it.
        """
        ctrl = self.data.ctrl
        while self._tick < tick:
            until, control = next(self._controls)
            ctrl[:] = control
            mujoco.mj_step(self._model, self.data, until - self._tick)
            self._tick = until


def instrument_session(profiler: CpuProfiler, session: Session) -> list[Control]:
    """Measure every component of a session, and record its actuator targets.

    The control steps of dancers and robot write their rows of the log themselves, which counts for these components.

    Returns:
        the list to which the targets are appended while the session runs.
    """
    world = physics_of(session)
    physics = world.physics
    controls: list[Control] = []
    step_to = physics.step_to

    def record_and_step(tick: int) -> None:
        controls.append((tick, physics.data.ctrl.copy()))
        step_to(tick)

    physics.step_to = record_and_step  # type: ignore[method-assign]
    methods: list[tuple[Any, str, str]] = [
        (physics, "step_to", "physics"),
        (world.dancers, "step", CONTROLLER),
        (world.scheduler, "decide", "planning"),
        (world.scheduler, "plan", "planning"),
        (world, "update_sensors", "sensing"),
        (world, "update_robot", "robot"),
        (session.server, "receive", "server"),
        (session.server, "due_messages", "server"),
        (session.dispatcher, "due_timers", "server"),
        (session.dispatcher, "due_commands", "server"),
        (session, "log", "logging"),
        (world.recorder, "add_frame", "logging"),
        (world.recorder, "add_skeletons", "logging"),
    ]
    if session.method is not None:
        methods += [(session.method, name, "decision") for name in METHOD_HOOKS]
    for owner, name, component in methods:
        profiler.wrap(owner, name, component)
    return controls


def profile(config: SessionConfig) -> dict[str, Any]:
    """Measure a session by component, then measure it again without a profiler, beside the bare physics.

    A short session runs first, so that costs of the process, such as compiling, are not measured. The second session
    and the bare physics alternate every few simulated seconds, so that a machine that slows down slows both.

    Returns:
        ``sim_s``; ``cpu_s`` of the session without profiler; ``raw_cpu_s`` of the bare physics under the session's
        actuator targets; ``room_cpu_s`` by component; ``stabiliser_ticks``; ``decisions``, the number of calls of the
        method, None without one; and ``peak_mb``.

    Raises:
        AssertionError: the replayed physics differs from the session's, so that the comparison would be wrong.
    """
    _warm_up(config)
    profiler = CpuProfiler()
    profiled = Session(config)
    data = physics_of(profiled).physics.data
    start = (data.qpos.copy(), data.qvel.copy())
    controls = instrument_session(profiler, profiled)
    profiled.advance(profiled.end_s)
    profiled.log()

    replay = PhysicsReplay(physics_of(profiled).physics.model, start, controls)
    session, cpu_s, raw_cpu_s = _alternate(config, replay)
    if not np.array_equal(replay.data.qpos, physics_of(session).physics.data.qpos):
        raise AssertionError("the replayed physics differs from the session's")
    return {
        "sim_s": session.end_s,
        "cpu_s": cpu_s,
        "raw_cpu_s": raw_cpu_s,
        "room_cpu_s": profiler.spent_s,
        "stabiliser_ticks": profiler.calls[CONTROLLER],
        "decisions": profiler.calls.get("decision"),
        "peak_mb": peak_mb(),
    }


def _warm_up(config: SessionConfig) -> None:
    """Run the beginning of a session, and its log."""
    session = Session(config)
    session.advance(WARM_UP_S)
    session.log()


def _alternate(config: SessionConfig, replay: PhysicsReplay) -> tuple[Session, float, float]:
    """Run a session and its replay in turns.

    Returns:
        the session, and the CPU times of session and replay [s].
    """
    start_s = time.process_time()
    session = Session(config)
    cpu_s = time.process_time() - start_s
    raw_cpu_s = 0.0

    while session.time_s < session.end_s - 1e-9:
        start_s = time.process_time()
        session.advance(min(session.time_s + SLICE_S, session.end_s))
        middle_s = time.process_time()
        replay.advance(physics_of(session).physics.tick)
        cpu_s += middle_s - start_s
        raw_cpu_s += time.process_time() - middle_s

    start_s = time.process_time()
    session.log()
    cpu_s += time.process_time() - start_s
    return session, cpu_s, raw_cpu_s


def profile_depth(config: SessionConfig) -> dict[str, Any]:
    """Measure a whole session with depth sensing, and the frames of its first active sensor.

    The frames are measured in a second session, so that the first one runs without a profiler.

    Returns:
        ``depth_sim_s`` and ``depth_cpu_s`` of the session; ``depth_frames``, and ``depth_frame_cpu_s`` of all of them
        together.
    """
    config = replace(config, sensing="depth")
    Session(config).advance(WARM_UP_S)
    start_s = time.process_time()
    session = Session(config)
    session.advance(session.end_s)
    session.log()
    cpu_s = time.process_time() - start_s

    profiler = CpuProfiler()
    profiled = Session(config)
    profiler.wrap(physics_of(profiled).sensing[profiled.server.active], "sample", "depth")
    profiled.advance(WARM_UP_S)
    return {
        "depth_sim_s": session.end_s,
        "depth_cpu_s": cpu_s,
        "depth_frames": profiler.calls["depth"],
        "depth_frame_cpu_s": profiler.spent_s["depth"],
    }


def peak_mb() -> float | None:
    """Peak memory of this process [MB]; None on Windows, which lacks ``getrusage``."""
    try:
        import resource
    except ImportError:
        return None

    # Bytes on macOS, kilobytes elsewhere.
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)
