"""Gymnasium wrappers for policies that dance as an anticipation method."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import error, spaces

from sjasim.anticipation.observation import Row
from sjasim.anticipation.step_selection import StepSelector
from sjasim.session.session import Session

PARTS = ("beat", "command", "event_age", "iteration", "last_iteration")
"""Parts of the observation that an anticipation method knows, in the order of `EventFeatures.row`."""

COMMAND_FEATURES = 5
"""Leading numbers of the part ``command`` that a method knows: one of four moves, and its age."""


class MethodPolicy(gym.ObservationWrapper[Row, Any, dict[str, Row]]):
    """Reduces the observation to what an anticipation method knows, without skeletons and odometry.

    The observation equals `sjasim.anticipation.observation.EventFeatures.row`, so that a trained policy can dance as
    the method ``learned``.

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

        boxes: dict[str, Any] = {name: named[name] for name in PARTS}
        low = self.observation({name: box.low for name, box in boxes.items()})
        high = self.observation({name: box.high for name, box in boxes.items()})
        self.observation_space = spaces.Box(low, high, dtype=np.float32)

    def observation(self, observation: dict[str, Row]) -> Row:
        """Concatenate the parts to a row (N,); of the command only the move and its age."""
        parts = (observation[name].ravel() for name in PARTS[2:])
        return np.concatenate([observation["beat"], observation["command"][:COMMAND_FEATURES], *parts])


class InOrder(gym.Wrapper[Any, Any, Any, Any]):
    """Sends each step of the score at most once, in order and near its beat; other actions repeat the move in force.

    The method ``learned`` interprets a policy's actions in the same way, so that a policy dances as it was trained.
    It also simplifies learning: only the timing remains to be learned.

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
        """The present session. It is not stored, so that the wrapper can be copied with its environment."""
        session: Session = self.get_wrapper_attr("session")
        return session

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; see the environment."""
        result = self.env.reset(seed=seed, options=options)
        self._selector = StepSelector(self._session.context)
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Take a step of the environment with the action of the selected step of the score."""
        # An action that is not allowed goes to the environment, which names it in its error.
        if self.action_space.contains(action):
            self._selector.select(self._session.time_s, int(action))
            action = self._selector.move
        return self.env.step(action)
