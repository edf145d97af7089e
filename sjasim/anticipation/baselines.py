"""Methods that bracket the others: what can be had without perceiving anyone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..answers import Answer, Brief, Intention
from ..errors import ConfigError
from ..registry import register
from ..types import (
    Event,
)
from .eca import LEAD_S
from .history import nominal_times


@dataclass(frozen=True, slots=True)
class MetronomeConfig:
    """Options of the metronome.

    Attributes:
        lead_s: how long before its beat a command is sent; larger makes the robot earlier.
    """

    lead_s: float = LEAD_S

    def __post_init__(self) -> None:
        if not -2.0 <= self.lead_s <= 10.0:
            raise ConfigError("metronome.lead_s", self.lead_s, "seconds from -2 to 10")


@register("anticipation", "metronome", config=MetronomeConfig)
class Metronome:
    """The robot dances the score to the music and perceives nobody.

    Args:
        config: its options.
    """

    def __init__(self, config: MetronomeConfig = MetronomeConfig()) -> None:
        self._config = config

    def reset(self, brief: Brief, rng: np.random.Generator) -> None:
        """Begin a dance."""
        self._brief = brief
        self._after = nominal_times(brief) - self._config.lead_s
        self._scheduled = 0

    def on_event(self, event: Event) -> Sequence[Answer]:
        """Deaf."""
        return ()

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[Answer]:
        """Schedule an iteration that has nothing before it."""
        return () if iteration <= self._scheduled else self._schedule(iteration)

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[Answer]:
        """Schedule the next iteration."""
        return self._schedule(iteration + 1)

    def on_wake(self, t_s: float) -> Sequence[Answer]:
        """No timers."""
        return ()

    def _schedule(self, iteration: int) -> Sequence[Answer]:
        if not 1 <= iteration <= self._brief.iterations:
            return ()
        self._scheduled = iteration
        start = self._brief.iteration_start_s[iteration]
        return tuple(
            Intention(iteration, step.ordinal, start + float(after), f"beat {step.beat:g}")
            for step, after in zip(self._brief.steps, self._after, strict=True)
        )
