"""Choreography and music."""

from __future__ import annotations

from dataclasses import dataclass

from ..core.errors import ConfigError
from .checks import within


@dataclass(frozen=True, slots=True)
class DanceConfig:
    """Choreography and music.

    Attributes:
        name: a registered choreography or module:function.
        bpm: tempo of the music [beats/min] (iqbal2016: 118).
        step_m: nominal length of a forward or backward move [m].
        tempo: tempo changes, as pairs of a beat of the music and a factor of ``bpm``. The factor is interpolated
            linearly between the beats; an increasing factor is an accelerando. Beat 0 is the first beat of the music,
            in the rehearsal if there is one.
        pauses: pauses of the music, as pairs of a beat and the duration of the pause before it [s].
        lead_in_s: time before the music starts [s], in which the clocks are synchronised.
        tail_s: duration of the session after the last beat [s].
        rehearsal: start with one iteration without the robot, from which the methods predict the next one;
            ``--dance.no-rehearsal`` omits it.
    """

    name: str = "paper"
    bpm: float = 118.0
    step_m: float = 0.50
    tempo: tuple[tuple[float, float], ...] = ()
    pauses: tuple[tuple[float, float], ...] = ()
    lead_in_s: float = 4.0
    tail_s: float = 1.0
    rehearsal: bool = True

    def __post_init__(self) -> None:
        within("dance.bpm", self.bpm, 40.0, 220.0)
        within("dance.step_m", self.step_m, 0.1, 1.0)

        for name, points, low, high in (("tempo", self.tempo, 0.5, 2.0), ("pauses", self.pauses, 0.0, 60.0)):
            for beat, value in points:
                within(f"dance.{name}", beat, 0.0, 1e4)
                within(f"dance.{name}", value, low, high)
            beats = [beat for beat, _ in points]
            if sorted(set(beats)) != beats:
                raise ConfigError(f"dance.{name}", points, "pairs whose beats rise")

        within("dance.lead_in_s", self.lead_in_s, 1.0, 60.0)
        within("dance.tail_s", self.tail_s, 0.0, 60.0)
