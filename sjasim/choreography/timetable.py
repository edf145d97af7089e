"""The timetable: session times of a dance's beats, iterations and windows."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ..config import DanceConfig, SessionConfig
from ..core.errors import PluginError
from ..core.registry import resolve
from ..core.tempo import TempoMap
from .score import Choreography


@dataclass(frozen=True)
class Timetable:
    """Nominal session times of a whole dance, without the dancers' deviations.

    Attributes:
        choreography: the dance.
        tempo: times of the song's beats; beat 0 is that of the first iteration.
        lead_in_s: session time of the song's beat 0.
        first: index of the first iteration: 0 with a rehearsal, 1 without.
        last: index of the last iteration.
    """

    choreography: Choreography
    tempo: TempoMap
    lead_in_s: float
    first: int
    last: int

    def time_s(self, iteration: int, beat: float) -> float:
        """Session time of a beat of an iteration [s]."""
        known_s = self._known_s.get((iteration, beat))
        if known_s is not None:
            return known_s

        # Tempo changes and pauses are given in beats of the song, which counts on through the iterations.
        song_beat = (iteration - self.first) * self.choreography.iteration_beats + beat
        time_s = self.lead_in_s + self.tempo.time_s(song_beat)
        self._known_s[iteration, beat] = time_s
        return time_s

    @cached_property
    def _known_s(self) -> dict[tuple[int, float], float]:
        """(iteration, beat) -> session time, for the beats that have been asked for [s]."""
        return {}

    def start_s(self, iteration: int) -> float:
        """Session time of an iteration's beat 0 [s]."""
        return self.time_s(iteration, 0.0)

    def close_s(self, iteration: int) -> float:
        """Session time at which an iteration's window closes [s]."""
        return self.time_s(iteration, self.choreography.close_beat)

    @cached_property
    def _closings_s(self) -> list[float]:
        """Closing times of all windows but the last, which takes every later event [s]."""
        return [self.close_s(iteration) for iteration in range(self.first, self.last)]

    def iteration_at(self, t_s: float) -> int:
        """The iteration whose window holds a session time: the first one before its window, the last one after it."""
        return self.first + bisect_left(self._closings_s, t_s)

    def end_s(self) -> float:
        """Session time at which the last iteration is over [s]."""
        return self.time_s(self.last, self.choreography.iteration_beats)

    def heading_rad(self, iteration: int) -> float:
        """Heading of dancers and robot before the turn of an iteration; in iteration 1 they face north (world +y)."""
        return np.pi / 2 + (iteration - 1) * self.choreography.turn_rad


def timetable(config: SessionConfig) -> Timetable:
    """The timetable that a configuration asks for.

    Raises:
        UnknownNameError: no choreography has the name.
        PluginError: what the name stands for does not return a `Choreography`.
    """
    options = config.dance
    # A plug-in of the user's may change while Python runs, so its timetable is made anew each time.
    make = _make_timetable if ":" in options.name else _shared_timetable
    return make(options, config.iterations)


def _make_timetable(options: DanceConfig, iterations: int) -> Timetable:
    """The timetable of a dance."""
    dance = resolve("choreography", options.name).factory()
    if not isinstance(dance, Choreography):
        raise PluginError(f"choreography {options.name!r} made {type(dance).__name__}, not a Choreography")

    tempo = TempoMap.changing(options.bpm, options.tempo, options.pauses)
    first = 0 if options.rehearsal else 1
    return Timetable(dance, tempo, options.lead_in_s, first, iterations)


_shared_timetable = lru_cache(maxsize=64)(_make_timetable)
"""The timetable of a registered dance; sessions with the same dance share it."""
