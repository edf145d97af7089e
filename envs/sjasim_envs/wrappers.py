"""Wrappers that belong to these environments."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import error, spaces

from .observation import Row

PARTS = ("beat", "command", "event_age", "iteration", "last_iteration")


class Told(gym.ObservationWrapper[Row, Any, dict[str, Row]]):
    """What an anticipation method is told and nothing else: no skeletons, no odometry.

    The numbers and their order are those of `sjasim.anticipation.features.Features.row`, so that a policy trained
    with them can dance as a method (``learned``).

    Args:
        env: an environment with the named observation.

    Raises:
        error.Error: the environment's observation lacks a part.
    """

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        named = env.observation_space
        if not isinstance(named, spaces.Dict) or not set(PARTS) <= set(named):
            raise error.Error(f"Told needs an observation with the parts {', '.join(PARTS)}, not {named}")
        low, high = (
            self.observation({name: getattr(named[name], bound) for name in PARTS}) for bound in ("low", "high")
        )
        self.observation_space = spaces.Box(low, high, dtype=np.float32)

    def observation(self, observation: dict[str, Row]) -> Row:
        """One row of the parts; of the command only the move and its age."""
        parts = (observation[name].ravel() for name in PARTS[2:])
        return np.concatenate([observation["beat"], observation["command"][:5], *parts])
