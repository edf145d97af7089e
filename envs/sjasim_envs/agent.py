"""The method of a session whose robot an agent commands through an environment."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sjasim.core import Event
from sjasim.core.method_io import MethodAction, MethodContext


class Agent:
    """Anticipation method that returns no actions, for sessions whose robot is commanded by an agent."""

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Nothing to prepare."""

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Do nothing."""
        return ()

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Do nothing."""
        return ()

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Do nothing."""
        return ()

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """Do nothing."""
        return ()
