"""What the environments cost: beside the bare physics of the same steps, and in processes of their own."""

from __future__ import annotations

import time
from typing import Any

from gymnasium.vector import AsyncVectorEnv

from sjasim.profiling import Bare, Meter, instrument

from .dance import DanceEnv

WORKER_STEPS = 300
"""Steps that each worker makes."""

TURN_STEPS = 30
"""Steps of each turn."""


def profile_env() -> dict[str, Any]:
    """Measure the named environment at 30 Hz, in turn with the bare physics under the same controls.

    The metronome dances one iteration; building the session is not counted, for a reset is not a step.

    Returns:
        ``env_steps``, ``env_cpu_s`` and ``env_raw_cpu_s``.
    """

    def begun() -> tuple[DanceEnv, Any, int]:
        env = DanceEnv(iterations=1, dance={"rehearsal": False}, method="metronome")
        env.reset(seed=0)
        return env, env.session.world.stage, int(env.session.end_s * 30)

    env, stage, count = begun()
    start = (stage.data.qpos.copy(), stage.data.qvel.copy())
    controls = instrument(Meter(), env.session)
    _steps(env, count)
    bare = Bare(stage.model, start, controls)
    env, stage, _ = begun()
    cpu_s = raw_cpu_s = 0.0
    for done in range(0, count, TURN_STEPS):
        begin = time.process_time()
        _steps(env, min(TURN_STEPS, count - done))
        middle = time.process_time()
        bare.advance(stage.tick)
        cpu_s, raw_cpu_s = cpu_s + middle - begin, raw_cpu_s + time.process_time() - middle
    return {"env_steps": count, "env_cpu_s": cpu_s, "env_raw_cpu_s": raw_cpu_s}


def _steps(env: Any, count: int) -> None:
    """Repeat the move in force, so that the environment's method decides."""
    action = 0
    for _ in range(count):
        action = int(env.step(action)[0]["command"][:4].argmax())


def profile_workers() -> dict[str, Any]:
    """Measure one worker and two, each in a process of its own, in turns by the clock on the wall.

    Returns:
        ``async_steps_per_s``: environment steps per second of one worker and of two together.
    """
    crews = [AsyncVectorEnv([_env] * count, context="spawn") for count in (1, 2)]
    wall_s = [0.0, 0.0]
    try:
        for crew in crews:
            crew.reset(seed=0)
            _wait(crew, TURN_STEPS)
        for _ in range(0, WORKER_STEPS, TURN_STEPS):
            for index, crew in enumerate(crews):
                wall_s[index] += _wait(crew, TURN_STEPS)
    finally:
        for crew in crews:
            crew.close()
    return {
        "async_steps_per_s": [crew.num_envs * WORKER_STEPS / spent for crew, spent in zip(crews, wall_s, strict=True)]
    }


def _env() -> DanceEnv:
    return DanceEnv(iterations=1, dance={"rehearsal": False})


def _wait(crew: AsyncVectorEnv, steps: int) -> float:
    """Wall time of some steps [s]; the robot stands."""
    begin = time.perf_counter()
    for _ in range(steps):
        crew.step([0] * crew.num_envs)
    return time.perf_counter() - begin
