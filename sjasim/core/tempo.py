"""Music in time: when each beat falls, and which beat it is."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from .errors import ConfigError

PAUSE_BEATS = 0.01
"""A pause lies in the last hundredth of the beat before it: whatever stands on a beat stays on one side of it."""

Points = Sequence[tuple[float, float]]


@dataclass(frozen=True, slots=True)
class TempoMap:
    """When each beat of the music falls: straight lines through (beat, time) points.

    Attributes:
        beats: (N,) rising beats, N >= 2.
        times_s: (N,) rising times [s]; beyond both ends the outermost tempo goes on.
    """

    beats: tuple[float, ...]
    times_s: tuple[float, ...]

    @classmethod
    def steady(cls, bpm: float) -> TempoMap:
        """A constant tempo, beat 0 at time 0."""
        return cls((0.0, 1.0), (0.0, 60.0 / bpm))

    @classmethod
    def changing(cls, bpm: float, tempo: Points, pauses: Points) -> TempoMap:
        """A tempo that changes, beat 0 at time 0.

        Args:
            bpm: beats per minute where the factor is 1.
            tempo: rising (beat, factor of the tempo); between two of them the tempo changes evenly from beat to beat.
            pauses: (beat, seconds of silence before it).
        """
        if not tempo and not pauses:
            return cls.steady(bpm)
        marks = {beat for beat, _ in pauses} | {beat - PAUSE_BEATS for beat, _ in pauses} | {0.0}
        ends = [beat for beat, _ in tempo]
        if ends:
            marks |= {*ends, *map(float, range(math.ceil(ends[0]), math.floor(ends[-1]) + 1))}
        knots = _apart(sorted(marks))
        knots = [knots[0] - 1.0, *knots, knots[-1] + 1.0]
        times = [0.0]
        for before, beat in itertools.pairwise(knots):
            passed = (beat - before) * 60.0 / bpm / _mean_factor(_factor(tempo, before), _factor(tempo, beat))
            times.append(times[-1] + passed + sum(pause for at, pause in pauses if before < at <= beat))
        zero = times[knots.index(0.0)]
        return cls(tuple(knots), tuple(time - zero for time in times))

    def __post_init__(self) -> None:
        count = len(self.beats)
        if count != len(self.times_s) or count < 2 or not (_rises(self.beats) and _rises(self.times_s)):
            raise ConfigError("tempo", (self.beats, self.times_s), "two or more points, rising in beat and time")

    def shifted(self, by_s: float) -> TempoMap:
        """The same music, later."""
        return TempoMap(self.beats, tuple(time + by_s for time in self.times_s))

    def time_s(self, beat: float) -> float:
        """Time of a beat [s]."""
        return _through(self.beats, self.times_s, beat)

    def beat(self, time_s: float) -> float:
        """The beat, and fraction of one, at a time [s]."""
        return _through(self.times_s, self.beats, time_s)

    def line(self, time_s: float) -> tuple[float, float, float]:
        """The straight line that `beat` follows at a time.

        Returns:
            the beat at time 0 if the line went on until there, beats per second, and the time at which it ends [s].
        """
        k = _segment(self.times_s, time_s)
        rate = (self.beats[k + 1] - self.beats[k]) / (self.times_s[k + 1] - self.times_s[k])
        ends_s = self.times_s[k + 1] if k + 2 < len(self.times_s) else math.inf
        return self.beats[k] - self.times_s[k] * rate, rate, ends_s


def _through(xs: tuple[float, ...], ys: tuple[float, ...], x: float) -> float:
    """The value at ``x`` of the straight lines through the points, prolonged beyond both ends."""
    k = _segment(xs, x)
    return ys[k] + (x - xs[k]) * (ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k])


def _segment(xs: tuple[float, ...], x: float) -> int:
    """Which of the lines between the points holds at ``x``."""
    return min(max(bisect_right(xs, x) - 1, 0), len(xs) - 2)


def _apart(marks: list[float]) -> list[float]:
    """Marks without those that rounding can hardly tell from a neighbour; beat 0 stays."""
    return [beat for k, beat in enumerate(marks) if beat == 0.0 or not _near(beat, [*marks[k - 1 : k], 0.0])]


def _near(beat: float, others: list[float]) -> bool:
    return any(abs(beat - other) < 1e-6 for other in others)


def _rises(values: tuple[float, ...]) -> bool:
    return all(after > before for before, after in itertools.pairwise(values))


def _factor(tempo: Points, beat: float) -> float:
    """Factor of the tempo at a beat; that of the outermost point beyond it."""
    if not tempo:
        return 1.0
    first, last = tempo[0], tempo[-1]
    if not first[0] < beat < last[0]:
        return first[1] if beat <= first[0] else last[1]
    return _through(tuple(at for at, _ in tempo), tuple(factor for _, factor in tempo), beat)


def _mean_factor(before: float, after: float) -> float:
    """The constant tempo that takes as long as an even change between two (their logarithmic mean)."""
    return before if math.isclose(before, after, rel_tol=1e-9) else (after - before) / math.log(after / before)
