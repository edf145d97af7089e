"""Who acts in the environments' tests."""

from __future__ import annotations

import numpy as np

from sjasim.anticipation.observation import MOVES
from sjasim.core.method_io import ROBOT_MOVES

FAST = {"iterations": 1, "dance": {"rehearsal": False}}
"""The shortest dance there is: 25 s."""

LEAD_S = {"start": 0.17, "stop": 0.20, "clap": 0.20}
"""How long before the dancers' true mean the order is given, so that the robot's event meets their logged mean."""


def leave_be(env, observation):
    """Repeat the move in force: whatever answers beside the agent decides."""
    return int(observation["command"][:4].argmax())


def idle(env, observation):
    """Stand still."""
    return 0


class Oracle:
    """Knows when everybody is going to move."""

    def __init__(self, env):
        self._session = env.unwrapped.session
        self._next = (1, 0)
        self._action = 0

    def __call__(self, env, observation):
        iteration, ordinal = self._next
        steps = self._session.context.steps
        times = [t_s for cue in self._session.world.cues if cue.iteration == iteration
                 for k, (_, t_s) in enumerate(cue.events()) if cue.ordinal + k == ordinal]  # fmt: skip
        kind = steps[ordinal].kind
        if times and self._session.time_s + 1 / 60 >= np.mean(times) - LEAD_S[kind.value.partition("_")[0]]:
            self._action = MOVES.index(ROBOT_MOVES[kind])
            self._next = (iteration, ordinal + 1) if ordinal + 1 < len(steps) else (iteration + 1, 0)
        return self._action


def dance(env, policy, **reset):
    """A whole episode: its return, and the infos of the iterations' ends."""
    observation, info = env.reset(**reset)
    act = policy(env) if isinstance(policy, type) else policy
    total, rows, over = 0.0, [], False
    while not over:
        observation, reward, over, _, info = env.step(act(env, observation))
        total += reward
        if "gsi" in info:
            rows.append(info)
    return total, rows
