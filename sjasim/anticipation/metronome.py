"""Metronome: the robot dances the score to the music and ignores the dancers, a baseline for the other methods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..core.errors import ConfigError
from ..core.method_io import MethodAction, ScheduleCommand
from ..core.registry import register
from .scheduled_method import LEAD_S, ScheduledMethod


@dataclass(frozen=True, slots=True)
class MetronomeConfig:
    """Options of the metronome.

    Attributes:
        lead_s: how long before its beat a command is sent [s]; a larger value makes the robot earlier.
    """

    lead_s: float = LEAD_S

    def __post_init__(self) -> None:
        if not -2.0 <= self.lead_s <= 10.0:
            raise ConfigError("metronome.lead_s", self.lead_s, "seconds from -2 to 10")


@register("anticipation", "metronome", config=MetronomeConfig)
class Metronome(ScheduledMethod):
    """Schedules every step at its beat in the music, whatever the dancers do.

    Args:
        config: options.
    """

    def __init__(self, config: MetronomeConfig = MetronomeConfig()) -> None:
        self._config = config

    def _schedule_iteration(self, iteration: int) -> Sequence[MethodAction]:
        """One command for each step, ``lead_s`` before its beat."""
        return tuple(
            ScheduleCommand(
                iteration,
                step.ordinal,
                self._context.time_s(iteration, step.beat) - self._config.lead_s,
                f"beat {step.beat:g}",
            )
            for step in self._context.steps
        )
