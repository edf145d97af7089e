"""Which dance, and how fast."""

from __future__ import annotations

from dataclasses import dataclass

from ..core.errors import ConfigError
from .checks import within


@dataclass(frozen=True, slots=True)
class DanceConfig:
    """Which dance, how fast, and what precedes it.

    Attributes:
        name: a registered choreography or module:function.
        bpm: tempo of the music (iqbal2016: 118).
        step_m: nominal length of a forward or backward move.
        tempo: how the tempo changes: beat of the song and factor of ``bpm`` from there on, changing evenly from each
            to the next; a factor that rises is an accelerando, one that falls a ritardando. Beat 0 is the song's
            first, the rehearsal's if there is one.
        pauses: beat of the song and seconds of silence before it.
        lead_in_s: silence before the music; clocks synchronise meanwhile.
        tail_s: how long the session goes on after the last beat.
        rehearsal: whether one humans-only iteration precedes the dance, as the methods' history.
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
