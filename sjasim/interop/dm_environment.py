"""The environment of continuous actions as a `dm_env` environment, for dm_control's viewer and `dm_env` agents.

    from dm_control import viewer
    from sjasim.interop.dm_environment import DanceEnvironment
    viewer.launch(lambda: DanceEnvironment(iterations=1))

dm-control has no packages for Python 3.13 and newer; importing this module there raises an error that says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from ..core.errors import SjasimError
from ..simulation.physics_world import physics_of
from .missing_dm_control import missing_dm_control

try:
    import dm_env
    from dm_control.mujoco import Physics
    from dm_control.mujoco.wrapper import MjData
    from dm_env import specs
except ImportError as error:
    raise missing_dm_control(error) from error


class DanceEnvironment(dm_env.Environment):  # type: ignore[misc]
    """``sjasim/DanceContinuous-v0`` with the interface of `dm_env`.

    ``physics`` is dm_control's view of a copy of the state, which is updated after every step, so that a viewer that
    changes it does not change the session. An episode ends with the dance and not by truncation, so its last discount
    is 0.

    Args:
        seed: seed of the first episode; those of later ones are drawn from it.
        options: as for ``sjasim/DanceContinuous-v0``.

    Raises:
        SjasimError: the versions of dm_control and MuJoCo do not fit; raised by `reset`.
    """

    def __init__(self, seed: int | None = None, **options: Any) -> None:
        from sjasim_envs.dance import DanceContinuousEnv

        self._env = DanceContinuousEnv(**options)
        self._seed = seed
        self._over = True
        self._physics: Physics | None = None

    @property
    def physics(self) -> Physics:
        """dm_control's physics of the present episode; starts an episode if there is none."""
        if self._physics is None:
            self.reset()
        return self._physics

    def reset(self) -> dm_env.TimeStep:
        """Start an episode."""
        observation, _ = self._env.reset(seed=self._seed)
        # Gymnasium draws the seeds of later episodes from the first one.
        self._seed = None
        self._over = False
        self._physics = self._copy_of_physics()
        return dm_env.restart(observation)

    def step(self, action: Any) -> dm_env.TimeStep:
        """Take a step; after the end of an episode this starts the next one and ignores the action."""
        if self._over:
            return self.reset()
        observation, reward, self._over, _, _ = self._env.step(action)
        source = physics_of(self._env.session).physics
        mujoco.mj_copyData(self.physics.data.ptr, source.model, source.data)
        return dm_env.termination(reward, observation) if self._over else dm_env.transition(reward, observation)

    def action_spec(self) -> specs.BoundedArray:
        """Speed [m/s] and yaw rate [rad/s] within the limits of the robot."""
        return _bounded_array(self._env.action_space, "v, omega")

    def observation_spec(self) -> Mapping[str, specs.BoundedArray]:
        """The parts of the observation by name."""
        parts: Any = self._env.observation_space
        return {name: _bounded_array(space, name) for name, space in parts.items()}

    def close(self) -> None:
        """Close the environment."""
        self._env.close()

    def _copy_of_physics(self) -> Physics:
        """dm_control's physics with a copy of the session's state."""
        source = physics_of(self._env.session).physics
        data = mujoco.MjData(source.model)
        mujoco.mj_copyData(data, source.model, source.data)
        try:
            return Physics(MjData(data))
        except (AttributeError, TypeError) as problem:
            raise SjasimError(
                f"dm_control does not fit this MuJoCo {mujoco.__version__} ({problem}): install mujoco>=3.17,<4"
            ) from problem


def _bounded_array(space: Any, name: str) -> specs.BoundedArray:
    """The specification of a Gymnasium box."""
    low = np.asarray(space.low, dtype=space.dtype)
    high = np.asarray(space.high, dtype=space.dtype)
    return specs.BoundedArray(space.shape, space.dtype, low, high, name)
