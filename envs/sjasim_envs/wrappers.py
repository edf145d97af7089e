"""Wrappers that belong to these environments."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import error, spaces

from sjasim.anticipation.observation import Row
from sjasim.anticipation.step_selection import StepSelector
from sjasim.session.session import Session

PARTS = ("beat", "command", "event_age", "iteration", "last_iteration")


class MethodPolicy(gym.ObservationWrapper[Row, Any, dict[str, Row]]):
    """What an anticipation method is told and nothing else: no skeletons, no odometry.

    The numbers and their order are those of `sjasim.anticipation.observation.EventFeatures.row`, so that a policy
    trained with them can dance as a method (``learned``).

    Args:
        env: an environment with the named observation.

    Raises:
        error.Error: the environment's observation lacks a part.
    """

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        named = env.observation_space
        if not isinstance(named, spaces.Dict) or not set(PARTS) <= set(named):
            raise error.Error(f"MethodPolicy needs an observation with the parts {', '.join(PARTS)}, not {named}")
        low, high = (
            self.observation({name: getattr(named[name], bound) for name in PARTS}) for bound in ("low", "high")
        )
        self.observation_space = spaces.Box(low, high, dtype=np.float32)

    def observation(self, observation: dict[str, Row]) -> Row:
        """One row of the parts; of the command only the move and its age."""
        parts = (observation[name].ravel() for name in PARTS[2:])
        return np.concatenate([observation["beat"], observation["command"][:5], *parts])


class InOrder(gym.Wrapper[Any, Any, Any, Any]):
    """Lets an agent send each of the score's steps once and in order, near its beat; the rest of its actions hold.

    This is how the method ``learned`` hears a policy, so that one who was trained so dances as it was trained. It also
    makes learning quicker: what is left to learn is when.

    Args:
        env: an environment with the four moves as actions.

    Raises:
        error.Error: the environment has other actions.
    """

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        if not isinstance(env.action_space, spaces.Discrete):
            raise error.Error(f"InOrder needs the four moves as actions, not {env.action_space}")

    @property
    def _session(self) -> Session:
        """The present session. It is not kept, so that the wrapper can be copied with its environment."""
        session: Session = self.get_wrapper_attr("session")
        return session

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode."""
        answer = self.env.reset(seed=seed, options=options)
        self._steps = StepSelector(self._session.context)
        return answer

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Send a step of the score, or hold the move in force."""
        if self.action_space.contains(action):
            self._steps.select(self._session.time_s, int(action))
            action = self._steps.move
        return self.env.step(action)
