"""Cost of the environments: CPU time compared with the bare physics, and the speed of several worker processes."""

from __future__ import annotations

import time
from statistics import median
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AsyncVectorEnv

from sjasim.simulation.physics_world import physics_of
from sjasim.simulation.profiling import CpuProfiler, PhysicsReplay, instrument_session

OPTIONS: dict[str, Any] = {"iterations": 1, "dance": {"rehearsal": False}, "sensing": "joints"}
"""Options of every measured environment."""

STEP_HZ = 30
"""Default rate of the environments' steps [Hz]."""

WORKER_STEPS = 300
"""Steps of each worker."""

SLICE_STEPS = 30
"""Number of steps after which the measurement switches between the environment and the bare physics."""

REPETITIONS = 3
"""Number of times that the environment and the bare physics run the same episode."""


def profile_env() -> dict[str, Any]:
    """Measure the CPU time of an environment from ``gymnasium.make``, in alternation with the bare physics.

    An episode is one iteration. Its actions are recorded beforehand from the method ``metronome``, so that neither the
    choice of actions nor the reset is measured. The episode is divided into slices, and the median over the repetitions
    is used for each, which reduces the influence of temporary load on the machine.

    Returns:
        ``env_steps``, ``env_cpu_s`` and ``env_raw_cpu_s``.
    """
    env: Any = _reset_env()
    session = env.unwrapped.session
    steps = int(session.end_s * STEP_HZ)
    data = physics_of(session).physics.data
    start = (data.qpos.copy(), data.qvel.copy())
    controls = instrument_session(CpuProfiler(), session)
    actions = _run_method(env, steps)

    model = physics_of(session).physics.model
    slices_s = [
        _measure_slices(_reset_env(), PhysicsReplay(model, start, controls), actions) for _ in range(REPETITIONS)
    ]
    cpu_s, raw_cpu_s = np.median(slices_s, axis=0).sum(axis=0).tolist()
    return {"env_steps": steps, "env_cpu_s": cpu_s, "env_raw_cpu_s": raw_cpu_s}


def _reset_env() -> gym.Env[Any, Any]:
    """A new environment at the beginning of an episode."""
    env: gym.Env[Any, Any] = gym.make("sjasim/Dance-v0", method="metronome", **OPTIONS)
    env.reset(seed=0)
    return env


def _run_method(env: Any, steps: int) -> list[int]:
    """Run an episode in which the environment's method decides; returns the actions that repeat its moves."""
    actions = [0]
    for _ in range(steps):
        observation = env.step(actions[-1])[0]
        actions.append(int(observation["command"][:4].argmax()))
    return actions[:steps]


def _measure_slices(env: Any, replay: PhysicsReplay, actions: list[int]) -> list[tuple[float, float]]:
    """CPU times of the environment and of the bare physics, for each slice of an episode [s].

    Raises:
        AssertionError: the replayed physics differs from the environment's, so that the comparison would be wrong.
    """
    physics = physics_of(env.unwrapped.session).physics
    spent_s = []
    for first in range(0, len(actions), SLICE_STEPS):
        start_s = time.process_time()
        for action in actions[first : first + SLICE_STEPS]:
            env.step(action)
        middle_s = time.process_time()
        replay.advance(physics.tick)
        spent_s.append((middle_s - start_s, time.process_time() - middle_s))

    if not np.array_equal(replay.data.qpos, physics.data.qpos):
        raise AssertionError("the replayed physics differs from the environment's")
    return spent_s


def profile_workers() -> dict[str, Any]:
    """Measure the wall time of one worker process and of two, in alternation.

    Returns:
        ``async_steps_per_s``: environment steps per second of one worker, and of two together; medians over slices.
    """
    vector_envs = [AsyncVectorEnv([_make_worker_env] * count, context="spawn") for count in (1, 2)]
    wall_s: list[list[float]] = [[] for _ in vector_envs]
    try:
        for vector_env in vector_envs:
            vector_env.reset(seed=0)
            _step(vector_env, SLICE_STEPS)
        for _ in range(0, WORKER_STEPS, SLICE_STEPS):
            for vector_env, spent_s in zip(vector_envs, wall_s, strict=True):
                spent_s.append(_step(vector_env, SLICE_STEPS))
    finally:
        for vector_env in vector_envs:
            vector_env.close()

    rates = [
        vector_env.num_envs * SLICE_STEPS / median(spent_s)
        for vector_env, spent_s in zip(vector_envs, wall_s, strict=True)
    ]
    return {"async_steps_per_s": rates}


def _make_worker_env() -> gym.Env[Any, Any]:
    """The environment of a worker; the prefix of the id makes its process register the ids."""
    return gym.make("sjasim_envs:sjasim/Dance-v0", **OPTIONS)


def _step(vector_env: AsyncVectorEnv, steps: int) -> float:
    """Make some steps in which the robots stand; returns the wall time [s]."""
    start_s = time.perf_counter()
    for _ in range(steps):
        vector_env.step([0] * vector_env.num_envs)
    return time.perf_counter() - start_s
