"""An anticipation method in one file: the robot does whatever one dancer does, as soon as it is seen.

python3 scripts/launch.py run --method follow_first:FollowFirst
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sjasim.core import Event
from sjasim.core.method_io import MethodAction, MethodContext, ScheduleCommand


@dataclass(frozen=True)
class FollowFirstConfig:
    """Options; users set them with ``--method-options dancer dancer_2``."""

    dancer: str = "dancer_1"


class FollowFirst:
    """Copies one dancer, early events included; nobody is anticipated and nothing is scheduled."""

    config_type = FollowFirstConfig

    def __init__(self, config: FollowFirstConfig = FollowFirstConfig()) -> None:
        self._config = config

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Begin a dance: remember when each step falls on the music."""
        self._steps = context.steps
        self._context = context

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Send the command of the nearest step of this kind at once."""
        if event.person != self._config.dancer or event.iteration == 0:
            return ()
        beat = self._context.beat(event.iteration, event.t_s)
        steps = [step for step in self._steps if step.kind == event.kind]
        if not steps:
            return ()
        nearest = min(steps, key=lambda step: abs(step.beat - beat))
        why = f"{event.kind} of {event.person}{', early' if event.early else ''}"
        return (ScheduleCommand(event.iteration, nearest.ordinal, event.t_arrival_s, why, event.person),)

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Nothing to prepare."""
        return ()

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Nothing to learn."""
        return ()

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """No timers."""
        return ()
