"""What the environments cost: beside the bare physics of the same steps, and in processes of their own."""

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
"""Of every environment that is measured."""

WORKER_STEPS = 300
"""Steps that each worker makes."""

TURN_STEPS = 30
"""Steps of each turn."""

DANCES = 3
"""How often the environment and the bare physics dance the same."""


def profile_env() -> dict[str, Any]:
    """Measure the named environment at 30 Hz as ``gymnasium.make`` gives it, in turn with the bare physics.

    The metronome dances one iteration; building the session is not counted, for a reset is not a step. Of each turn,
    of the environment and of the physics under the same controls, the middle one of `DANCES` dances counts: a machine
    that is slow for a while slows down some of them only, and no part of the dance is left out. What an agent takes to
    choose its actions is not counted: they are those of a dance before.

    Returns:
        ``env_steps``, ``env_cpu_s`` and ``env_raw_cpu_s``.
    """
    env: Any = _begun()
    session = env.unwrapped.session
    physics, count = physics_of(session).physics, int(session.end_s * 30)
    start = (physics.data.qpos.copy(), physics.data.qvel.copy())
    controls = instrument_session(CpuProfiler(), session)
    actions = _danced(env, count)
    dances = [_turns(_begun(), PhysicsReplay(physics.model, start, controls), actions) for _ in range(DANCES)]
    cpu_s, raw_cpu_s = np.median(dances, axis=0).sum(axis=0).tolist()
    return {"env_steps": count, "env_cpu_s": cpu_s, "env_raw_cpu_s": raw_cpu_s}


def _begun() -> gym.Env[Any, Any]:
    """An environment whose dance begins."""
    env: gym.Env[Any, Any] = gym.make("sjasim/Dance-v0", method="metronome", **OPTIONS)
    env.reset(seed=0)
    return env


def _turns(env: Any, bare: PhysicsReplay, actions: list[int]) -> list[tuple[float, float]]:
    """CPU time of environment and bare physics, turn by turn [s]."""
    physics, spent_s = physics_of(env.unwrapped.session).physics, []
    for done in range(0, len(actions), TURN_STEPS):
        begin = time.process_time()
        for action in actions[done : done + TURN_STEPS]:
            env.step(action)
        middle = time.process_time()
        bare.advance(physics.tick)
        spent_s.append((middle - begin, time.process_time() - middle))
    if not np.array_equal(bare.data.qpos, physics.data.qpos):
        raise AssertionError("the replayed physics went another way than the environment's")
    return spent_s


def _danced(env: Any, count: int) -> list[int]:
    """Repeat the move in force, so that the environment's method decides; the actions that this takes."""
    actions = [0]
    for _ in range(count):
        actions.append(int(env.step(actions[-1])[0]["command"][:4].argmax()))
    return actions[:count]


def profile_workers() -> dict[str, Any]:
    """Measure one worker and two, each in a process of its own, in turns by the clock on the wall.

    Returns:
        ``async_steps_per_s``: environment steps per second of one worker and of two together, in the middle one of
        their turns.
    """
    crews = [AsyncVectorEnv([_made] * count, context="spawn") for count in (1, 2)]
    wall_s: list[list[float]] = [[] for _ in crews]
    try:
        for crew in crews:
            crew.reset(seed=0)
            _wait(crew, TURN_STEPS)
        for _ in range(0, WORKER_STEPS, TURN_STEPS):
            for crew, spent in zip(crews, wall_s, strict=True):
                spent.append(_wait(crew, TURN_STEPS))
    finally:
        for crew in crews:
            crew.close()
    return {
        "async_steps_per_s": [
            crew.num_envs * TURN_STEPS / median(spent) for crew, spent in zip(crews, wall_s, strict=True)
        ]
    }


def _made() -> gym.Env[Any, Any]:
    """What a worker steps; in its own process, so it registers the ids itself."""
    return gym.make("sjasim_envs:sjasim/Dance-v0", **OPTIONS)


def _wait(crew: AsyncVectorEnv, steps: int) -> float:
    """Wall time of some steps [s]; the robot stands."""
    begin = time.perf_counter()
    for _ in range(steps):
        crew.step([0] * crew.num_envs)
    return time.perf_counter() - begin
