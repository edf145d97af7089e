"""Policies that act in the tests of the environments."""

from __future__ import annotations

import numpy as np

from sjasim.anticipation.observation import MOVES
from sjasim.core.method_io import ROBOT_MOVES

FAST = {"iterations": 1, "dance": {"rehearsal": False}}
"""Options of the shortest episode, which takes 25 s of simulated time."""

LEAD_S = {"start": 0.17, "stop": 0.20, "clap": 0.20}
"""Time from the oracle's command to the robot's event, less the delay of the dancers' logged events [s]."""


def repeat_move(env, observation):
    """Repeat the move in force, so that a method beside the agent decides."""
    return int(observation["command"][:4].argmax())


def stand_still(env, observation):
    """Choose the move stop."""
    return 0


class Oracle:
    """Knows the dancers' cues, and moves the robot at their mean time."""

    def __init__(self, env):
        self._session = env.unwrapped.session
        self._iteration = 1
        self._ordinal = 0
        self._action = 0

    def __call__(self, env, observation):
        steps = self._session.context.steps
        kind = steps[self._ordinal].kind
        times_s = self._planned_times_s()
        lead_s = LEAD_S[kind.value.partition("_")[0]]
        if times_s and self._session.time_s + 1 / 60 >= np.mean(times_s) - lead_s:
            self._action = MOVES.index(ROBOT_MOVES[kind])
            self._ordinal += 1
            if self._ordinal == len(steps):
                self._ordinal = 0
                self._iteration += 1
        return self._action

    def _planned_times_s(self):
        """Times at which the dancers plan the next step [s]; a cue has the events of one step or two."""
        return [
            t_s
            for cue in self._session.world.cues
            if cue.iteration == self._iteration
            for offset, (_, t_s) in enumerate(cue.events())
            if cue.ordinal + offset == self._ordinal
        ]


def run_episode(env, policy, **reset):
    """Run an episode.

    Returns:
        its return, and the infos at the ends of its iterations.
    """
    observation, info = env.reset(**reset)
    act = policy(env) if isinstance(policy, type) else policy
    total = 0.0
    rows = []
    over = False
    while not over:
        observation, reward, over, _, info = env.step(act(env, observation))
        total += reward
        if "gsi" in info:
            rows.append(info)
    return total, rows
