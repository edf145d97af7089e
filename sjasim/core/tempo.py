"""Conversion between beats of the music and time, for a tempo that may change and pause."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from .errors import ConfigError

PAUSE_BEATS = 0.01
"""Length of the interval before a beat over which a pause is stretched [beats].

The map must increase strictly, so a pause cannot have zero length in beats. The interval is so short that no move of a
score begins in it.
"""

Points = Sequence[tuple[float, float]]
"""(beat, value) pairs with strictly increasing beats."""


@dataclass(frozen=True, slots=True)
class TempoMap:
    """Time of each beat, as a piecewise linear function through (beat, time) points.

    Attributes:
        beats: (N,) strictly increasing beats, N >= 2.
        times_s: (N,) strictly increasing times [s]. Outside the points the map is extrapolated linearly.
    """

    beats: tuple[float, ...]
    times_s: tuple[float, ...]

    @classmethod
    def steady(cls, bpm: float) -> TempoMap:
        """Return the map of a constant tempo, with beat 0 at time 0."""
        return cls((0.0, 1.0), (0.0, 60.0 / bpm))

    @classmethod
    def changing(cls, bpm: float, tempo: Points, pauses: Points) -> TempoMap:
        """Return the map of a changing tempo, with beat 0 at time 0.

        Args:
            bpm: beats per minute where the factor is 1.
            tempo: (beat, factor of ``bpm``) points, between which the factor is interpolated linearly in the beat.
            pauses: (beat, duration of the pause before it [s]).
        """
        if not tempo and not pauses:
            return cls.steady(bpm)

        # Replace a changing tempo by its mean between successive whole beats, so that the map is piecewise linear.
        marks = {beat for beat, _ in pauses} | {beat - PAUSE_BEATS for beat, _ in pauses} | {0.0}
        ends = [beat for beat, _ in tempo]
        if ends:
            marks |= {*ends, *map(float, range(math.ceil(ends[0]), math.floor(ends[-1]) + 1))}
        knots = _without_near_duplicates(sorted(marks))

        # Add one knot beyond each end, so that extrapolation continues with the outermost tempo.
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
        """Return a copy of the map whose times are ``by_s`` later."""
        return TempoMap(self.beats, tuple(time + by_s for time in self.times_s))

    def time_s(self, beat: float) -> float:
        """Return the time of a beat [s]."""
        return _interpolate(self.beats, self.times_s, beat)

    def beat(self, time_s: float) -> float:
        """Return the fractional beat at a time."""
        return _interpolate(self.times_s, self.beats, time_s)

    def line(self, time_s: float) -> tuple[float, float, float]:
        """Return the linear segment of the function `beat` that contains a time.

        Compiled code evaluates this line instead of calling `beat`.

        Returns:
            the value of the segment extrapolated to time 0 [beats], its slope [beats/s], and the time at which the
            segment ends [s].
        """
        k = _segment(self.times_s, time_s)
        rate = (self.beats[k + 1] - self.beats[k]) / (self.times_s[k + 1] - self.times_s[k])
        ends_s = self.times_s[k + 1] if k + 2 < len(self.times_s) else math.inf
        return self.beats[k] - self.times_s[k] * rate, rate, ends_s


def _interpolate(xs: tuple[float, ...], ys: tuple[float, ...], x: float) -> float:
    """Linear interpolation between points, with linear extrapolation beyond both ends."""
    k = _segment(xs, x)
    return ys[k] + (x - xs[k]) * (ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k])


def _segment(xs: tuple[float, ...], x: float) -> int:
    """Index of the first point of the segment that contains ``x``, or of the outermost segment."""
    return min(max(bisect_right(xs, x) - 1, 0), len(xs) - 2)


def _without_near_duplicates(marks: list[float]) -> list[float]:
    """Remove beats that differ from their predecessor, or from beat 0, by rounding only; beat 0 is kept."""
    return [beat for k, beat in enumerate(marks) if beat == 0.0 or not _near(beat, [*marks[k - 1 : k], 0.0])]


def _near(beat: float, others: list[float]) -> bool:
    """Whether a beat is within a millionth of a beat of another one."""
    return any(abs(beat - other) < 1e-6 for other in others)


def _rises(values: tuple[float, ...]) -> bool:
    return all(after > before for before, after in itertools.pairwise(values))


def _factor(tempo: Points, beat: float) -> float:
    """Factor of the tempo at a beat; constant outside the points."""
    if not tempo:
        return 1.0
    first = tempo[0]
    last = tempo[-1]
    if not first[0] < beat < last[0]:
        return first[1] if beat <= first[0] else last[1]
    return _interpolate(tuple(at for at, _ in tempo), tuple(factor for _, factor in tempo), beat)


def _mean_factor(before: float, after: float) -> float:
    """Constant tempo with the same duration as a linear change between two tempi: their logarithmic mean."""
    return before if math.isclose(before, after, rel_tol=1e-9) else (after - before) / math.log(after / before)
