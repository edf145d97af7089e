"""A dance as a `dm_env` environment, for dm_control's viewer and for agents written against `dm_env`.

    from dm_control import viewer
    from sjasim.interop.dm import DanceEnvironment
    viewer.launch(lambda: DanceEnvironment(iterations=1))

dm-control has no packages for Python 3.13 and newer; there this module cannot be imported, and says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from ..core.errors import SjasimError
from ..simulation.physics_world import physics_of
from .guard import explained

try:
    import dm_env
    from dm_control.mujoco import Physics
    from dm_control.mujoco.wrapper import MjData
    from dm_env import specs
except ImportError as missing:
    raise explained(missing) from missing


class DanceEnvironment(dm_env.Environment):  # type: ignore[misc]
    """The Gymnasium environment of continuous actions behind `dm_env`'s interface.

    ``physics`` is dm_control's view of a copy of the stage, brought up to date after every step, so that a viewer
    which touches it does not change the dance. A dance that is over is not cut short, so its last discount is 0.

    Args:
        seed: of the first episode; later ones are drawn from it.
        options: as for ``sjasim/DanceContinuous-v0``.

    Raises:
        SjasimError: dm_control does not understand the model that this MuJoCo made: their versions do not fit.
    """

    def __init__(self, seed: int | None = None, **options: Any) -> None:
        from sjasim_envs.dance import DanceContinuousEnv

        self._env = DanceContinuousEnv(**options)
        self._seed = seed
        self._over = True
        self._physics: Physics | None = None

    @property
    def physics(self) -> Physics:
        """dm_control's physics of the dance that is going on; begins one if there is none."""
        if self._physics is None:
            self.reset()
        return self._physics

    def reset(self) -> dm_env.TimeStep:
        """Begin a dance."""
        observation, _ = self._env.reset(seed=self._seed)
        self._seed = None
        self._over = False
        self._physics = self._shown()
        return dm_env.restart(observation)

    def step(self, action: Any) -> dm_env.TimeStep:
        """Drive for one decision's time; after the end of a dance this begins another, whatever the action."""
        if self._over:
            return self.reset()
        observation, reward, self._over, _, _ = self._env.step(action)
        physics = physics_of(self._env.session).physics
        mujoco.mj_copyData(self.physics.data.ptr, physics.model, physics.data)
        return dm_env.termination(reward, observation) if self._over else dm_env.transition(reward, observation)

    def action_spec(self) -> specs.BoundedArray:
        """Speed [m/s] and yaw rate [rad/s] within the base's limits."""
        return _spec(self._env.action_space, "v, omega")

    def observation_spec(self) -> Mapping[str, specs.BoundedArray]:
        """The named parts of the observation."""
        named: Any = self._env.observation_space
        return {name: _spec(space, name) for name, space in named.items()}

    def close(self) -> None:
        """Let go of everything."""
        self._env.close()

    def _shown(self) -> Physics:
        physics = physics_of(self._env.session).physics
        copy = mujoco.MjData(physics.model)
        mujoco.mj_copyData(copy, physics.model, physics.data)
        try:
            return Physics(MjData(copy))
        except (AttributeError, TypeError) as problem:
            raise SjasimError(
                f"dm_control does not fit this MuJoCo {mujoco.__version__} ({problem}): install mujoco>=3.17,<4"
            ) from problem


def _spec(space: Any, name: str) -> specs.BoundedArray:
    low, high = (np.asarray(bound, dtype=space.dtype) for bound in (space.low, space.high))
    return specs.BoundedArray(space.shape, space.dtype, low, high, name)
