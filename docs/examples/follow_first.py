"""An anticipation method in one file: the robot does what one dancer does, as soon as it is detected.

Use it as a template for a method of your own: copy it to a folder on Python's path (``PYTHONPATH``), then

    python -m sjasim.run --method follow_first:FollowFirst
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sjasim.core import Event
from sjasim.core.method_io import MethodAction, MethodContext, ScheduleCommand


@dataclass(frozen=True)
class FollowFirstConfig:
    """Options of the method. Users set them with ``--method-options.dancer dancer_2``.

    Attributes:
        dancer: name of the dancer to follow.
    """

    dancer: str = "dancer_1"


class FollowFirst:
    """Copies one dancer, early events included; it predicts nothing and schedules nothing.

    Args:
        config: options.
    """

    config_type = FollowFirstConfig

    def __init__(self, config: FollowFirstConfig = FollowFirstConfig()) -> None:
        self._config = config

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Prepare for a dance: keep its context, which says when each step falls on the music."""
        self._context = context

    def follows(self, iteration: int) -> tuple[str, ...]:
        """Say whom the robot follows; the group's synchrony and the net latency are computed from it."""
        return (self._config.dancer,)

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Send the command of the nearest step of the event's kind at once."""
        # In iteration 0, the rehearsal, the robot does not dance.
        if event.person != self._config.dancer or event.iteration == 0:
            return ()
        steps = [step for step in self._context.steps if step.kind == event.kind]
        if not steps:
            return ()

        # A kind occurs several times in an iteration: the music tells which step the dancer means.
        beat = self._context.beat(event.iteration, event.t_s)
        nearest = min(steps, key=lambda step: abs(step.beat - beat))
        why = f"{event.kind} of {event.person}{', early' if event.early else ''}"
        return (ScheduleCommand(event.iteration, nearest.ordinal, event.t_arrival_s, why, event.person),)

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Do nothing: there is nothing to prepare."""
        return ()

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Do nothing: there is nothing to learn from the iteration."""
        return ()

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """Do nothing: the method sets no timers."""
        return ()
