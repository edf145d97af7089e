"""Event cluster-based anticipation (ECA): the robot repeats the dancers' mean times of the last iteration.

Source: iqbal2016, section III-B.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..core import Event
from ..core.errors import ConfigError
from ..core.method_io import MethodAction, MethodContext, ScheduleCommand
from ..core.registry import register
from .event_history import EventHistory
from .scheduled_method import LEAD_S, ScheduledMethod
from .timing_appropriateness import EPSILON_S


@dataclass(frozen=True, slots=True)
class EcaConfig:
    """Options of ECA.

    Attributes:
        epsilon_s: largest gap between neighbouring times of one cluster [s]. With a larger value, dancers who are far
            from the others in time are included in the mean.
        lead_s: time between the sending of a command and the predicted time of its step [s]; a larger value makes the
            robot earlier.
    """

    epsilon_s: float = EPSILON_S
    lead_s: float = LEAD_S

    def __post_init__(self) -> None:
        for name, value, low in (("epsilon_s", self.epsilon_s, 0.0), ("lead_s", self.lead_s, -2.0)):
            if not low <= value <= 10.0:
                raise ConfigError(f"eca.{name}", value, f"seconds from {low:g} to 10")


@register("anticipation", "eca", config=EcaConfig)
class Eca(ScheduledMethod):
    """Schedules each step of an iteration at the mean time of the dancers' events of that step in the last iteration.

    The mean is that of the largest cluster of events. A step without a cluster of at least two dancers keeps the time
    of the last schedule; the first schedule contains the beats of the music. An iteration without events therefore
    leaves the schedule unchanged. Iteration 1 is scheduled from the rehearsal.

    Args:
        config: options.
    """

    def __init__(self, config: EcaConfig = EcaConfig()) -> None:
        self._config = config

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Prepare for a dance, and discard the state of the last one."""
        super().reset(context, rng)
        self._history = EventHistory(context, self._config.epsilon_s)

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Add the event to the history, and return no action: ECA schedules only at the end of an iteration."""
        self._history.add(event)
        return ()

    def _schedule_iteration(self, iteration: int) -> Sequence[MethodAction]:
        """Return one command for each step, from the events of the iteration before."""
        return schedule_from_history(self._context, self._history, iteration, self._config.lead_s)


def schedule_from_history(
    context: MethodContext, history: EventHistory, iteration: int, lead_s: float
) -> tuple[ScheduleCommand, ...]:
    """Return one command for each step of an iteration, ``lead_s`` before the time that ECA predicts.

    Args:
        context: context of the dance.
        history: events so far. Its schedule is updated in place with the events of ``iteration - 1``.
        iteration: the iteration to schedule, from 1.
        lead_s: time between the sending of a command and the predicted time of its step [s].

    Returns:
        K commands in the order of ``context.steps``.

    Source: iqbal2016, section III-B.
    """
    updated = history.update_schedule(iteration - 1)
    start_s = context.iteration_start_s[iteration]
    return tuple(
        ScheduleCommand(
            iteration,
            step.ordinal,
            start_s + float(history.schedule[index]) - lead_s,
            f"mean of iteration {iteration - 1}" if updated[index] else "kept: too few dancers together",
        )
        for index, step in enumerate(context.steps)
    )
