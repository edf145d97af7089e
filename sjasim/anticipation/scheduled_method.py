"""Methods that schedule an iteration as a whole when the one before it closes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from ..core import Event
from ..core.method_io import MethodAction, MethodContext

LEAD_S = 0.15
"""How long before a scheduled time the command is sent [s]; assumed: the pilots of iqbal2016 measured the robot's
latency, so its builders knew it, but the paper gives no figure."""


class ScheduledMethod(ABC):
    """Schedules each danced iteration once: at the close of the one before it, else at its own beat 0."""

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Begin a dance."""
        self._context = context
        self._scheduled = 0

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Deaf, unless a method says otherwise."""
        return ()

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Schedule an iteration that has nothing before it (no rehearsal)."""
        return () if iteration <= self._scheduled else self._next_schedule(iteration)

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Schedule the next iteration."""
        return self._next_schedule(iteration + 1)

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """No timers."""
        return ()

    def _next_schedule(self, iteration: int) -> Sequence[MethodAction]:
        if not 1 <= iteration <= self._context.iterations:
            return ()
        self._scheduled = iteration
        return self._schedule(iteration)

    @abstractmethod
    def _schedule(self, iteration: int) -> Sequence[MethodAction]:
        """Answers for an iteration that is danced; called once for each, in order."""
