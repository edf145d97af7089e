"""Learned method: a policy that was trained in the Gymnasium environment decides when the robot moves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..core import Event
from ..core.errors import ConfigError
from ..core.method_io import MethodAction, MethodContext, ScheduleCommand, SetTimer
from ..core.registry import register
from .observation import MOVES, EventFeatures
from .policy_network import PolicyNetwork
from .step_selection import StepSelector


@dataclass(frozen=True, slots=True)
class LearnedConfig:
    """Options of a learned method.

    Attributes:
        policy: npz file that ``scripts/train_policy.py`` has written.
    """

    policy: str = ""

    def __post_init__(self) -> None:
        if not self.policy:
            raise ConfigError("learned.policy", self.policy, "the npz file of a trained policy (--policy FILE.npz)")


@register("anticipation", "learned", config=LearnedConfig)
class Learned:
    """Evaluates a trained policy at a fixed rate and sends the step that its choice of move stands for.

    The policy chooses one of four moves, as in the environment; `StepSelector` maps it to a step of the dance.

    Args:
        config: options.

    Raises:
        ConfigError: the file holds no usable policy.
    """

    def __init__(self, config: LearnedConfig) -> None:
        self._network = PolicyNetwork.read(config.policy)

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Prepare for a dance: forget the last one.

        Raises:
            ConfigError: the policy was trained with another number of dancers or another dance.
        """
        self._context = context
        self._features = EventFeatures(context)
        self._selector = StepSelector(context)
        self._sent_s = -math.inf
        """Session time of the last command [s]."""
        self._has_started = False

        width = len(self._features.row(0.0, 0, 0.0))
        if width != len(self._network.mean):
            raise ConfigError("learned.policy", len(self._network.mean), f"a policy of {width} features")

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Add the event to the policy's features."""
        self._features.add(event)
        return ()

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Evaluate the policy for the first time when the first iteration begins; timers do the rest."""
        if self._has_started:
            return ()
        self._has_started = True
        return self.on_timer(t_s)

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Do nothing; the features of the last iteration update themselves."""
        return ()

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """Evaluate the policy, and set the timer of the next evaluation."""
        if t_s > self._context.window_end_s[-1]:
            return ()
        next_timer = SetTimer(t_s + 1.0 / self._network.step_hz)

        features = self._features.row(t_s, self._selector.move, self._sent_s).astype(np.float64)
        move = int(np.argmax(self._network.scores(features)))
        selected = self._selector.select(t_s, move)
        if selected is None:
            return (next_timer,)

        self._sent_s = t_s
        return ScheduleCommand(*selected, t_s, f"the policy wants {MOVES[move].value}"), next_timer
