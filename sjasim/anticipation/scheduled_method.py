"""Base class of methods that schedule a whole iteration at the end of the one before it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from ..core import Event
from ..core.method_io import MethodAction, MethodContext

LEAD_S = 0.15
"""Time between the sending of a command and the time of its step, which compensates the robot's latency [s].

Assumed: in the pilot studies of iqbal2016 the latency of the robot was measured, but the paper gives no figure.
"""


class ScheduledMethod(ABC):
    """Schedules each danced iteration once: at the end of the iteration before it, or else at its own beat 0.

    A subclass implements `_schedule_iteration`, and overrides the hooks that it needs besides.
    """

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Prepare for a dance: forget the last one."""
        self._context = context
        self._scheduled_iteration = 0
        """The last iteration that has been scheduled; 0 for none."""

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Ignore events; subclasses may override this."""
        return ()

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Schedule the iteration if no iteration came before it (a dance without rehearsal)."""
        if iteration <= self._scheduled_iteration:
            return ()
        return self._schedule_once(iteration)

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Schedule the next iteration."""
        return self._schedule_once(iteration + 1)

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """Do nothing; subclasses that set timers override this."""
        return ()

    def _schedule_once(self, iteration: int) -> Sequence[MethodAction]:
        """Actions for an iteration; none for the rehearsal and after the last iteration."""
        if not 1 <= iteration <= self._context.iterations:
            return ()
        self._scheduled_iteration = iteration
        return self._schedule_iteration(iteration)

    @abstractmethod
    def _schedule_iteration(self, iteration: int) -> Sequence[MethodAction]:
        """Actions that schedule an iteration; called once for each danced iteration, in order."""
