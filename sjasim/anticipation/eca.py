"""Event cluster-based anticipation: the robot repeats the dancers' mean times of the last iteration.

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
        epsilon_s: largest gap between neighbours of one cluster; wider forgives stragglers, and averages them in.
        lead_s: how long before the predicted time a command is sent; larger makes the robot earlier.
    """

    epsilon_s: float = EPSILON_S
    lead_s: float = LEAD_S

    def __post_init__(self) -> None:
        for name, value, low in (("epsilon_s", self.epsilon_s, 0.0), ("lead_s", self.lead_s, -2.0)):
            if not low <= value <= 10.0:
                raise ConfigError(f"eca.{name}", value, f"seconds from {low:g} to 10")


@register("anticipation", "eca", config=EcaConfig)
class Eca(ScheduledMethod):
    """ECA: when an iteration closes, schedules the next one at the mean of each event's cluster.

    A step that fewer than two dancers did together keeps its last time, first the nominal beat; so does a whole
    iteration without events. The rehearsal is the history of iteration 1.

    Args:
        config: its options.
    """

    def __init__(self, config: EcaConfig = EcaConfig()) -> None:
        self._config = config

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Begin a dance."""
        super().reset(context, rng)
        self._history = EventHistory(context, self._config.epsilon_s)

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Remember; never answer."""
        self._history.add(event)
        return ()

    def _schedule(self, iteration: int) -> Sequence[MethodAction]:
        return scheduled(self._context, self._history, iteration, self._config.lead_s)


def scheduled(
    context: MethodContext, history: EventHistory, iteration: int, lead_s: float
) -> tuple[ScheduleCommand, ...]:
    """Learn from the iteration before, and answer with one intention for each step.

    Args:
        context: the dance.
        history: events so far; its schedule moves on.
        iteration: which to schedule, from 1.
        lead_s: how long before its time a command is sent [s].
    """
    fresh = history.learn(iteration - 1)
    start = context.iteration_start_s[iteration]
    return tuple(
        ScheduleCommand(
            iteration,
            step.ordinal,
            start + float(history.schedule[index]) - lead_s,
            f"mean of iteration {iteration - 1}" if fresh[index] else "kept: too few dancers together",
        )
        for index, step in enumerate(context.steps)
    )
