"""When hands have met: the one rule behind claps seen from the front and from the side."""

from __future__ import annotations

import math

from ..config import DetectorConfig

APART_RATIO = 0.8
"""Above this ratio hands are apart; arms that hang or open for a clap have 1.1 to 1.4."""

NEAR_RATIO = 1.0
"""Hands nearer than this may clap: early starts are disarmed until ``clap_rest_s`` after it, also when the clap
itself stayed hidden; and tracked hands that come so near have been seen to close (assumed)."""

TOUCHING_RATIO, STILL_RATIO = 0.3, 0.03
"""Hands nearer than the first may touch; from frame to frame their ratio is uncertain by less than the second: some
half a centimetre per hand (assumed)."""


class ClapDetector:
    """Claps of one person: local minima of a ratio, which is small where hands meet, below ``clap_ratio``.

    Hands that touch stay together for a while; which of the small numbers of that while is the least is chance. Below
    `TOUCHING_RATIO` the minimum is where the ratio falls by less than `STILL_RATIO` between frames.

    The event comes with the frame after the minimum. Hands must have been apart (above `APART_RATIO`) since the last
    clap, which must be ``clap_rest_s`` ago: hands held together clap once. Touching hands hide each other, so they
    may be inferred as they meet, if they were last tracked nearer than `NEAR_RATIO`. A time longer than ``memory_s``
    without tracked hands forgets everything, so that hands that jump into sight cannot clap.

    Args:
        config: ratio and rest.
        memory_s: how long hands may be inferred.
    """

    __slots__ = ("_apart", "_before", "_c", "_last", "_memory_s", "_near", "_t_clap_s", "_t_last_s",
                 "_t_near_s", "_t_seen_s")  # fmt: skip

    def __init__(self, config: DetectorConfig, memory_s: float) -> None:
        self._c = config
        self._memory_s = memory_s
        self._t_clap_s = self._t_near_s = self._t_seen_s = -math.inf
        self._forget()

    def _forget(self) -> None:
        self._last = self._before = self._t_last_s = math.nan
        self._apart = self._near = False

    def update(self, t_s: float, ratio: float, tracked: bool) -> float | None:
        """Judge one frame.

        Args:
            t_s: the sensor's time of the frame.
            ratio: of the hands; NaN where it says nothing.
            tracked: whether the hands that it rests on are tracked.

        Returns:
            the time at which the hands met, or None.
        """
        if tracked and not math.isnan(ratio):
            self._t_seen_s = t_s
            self._near = ratio < NEAR_RATIO
            if self._near:
                self._t_near_s = t_s
        elif t_s - self._t_seen_s > self._memory_s:
            self._forget()
            return None
        least, t_least_s = self._last, self._t_last_s
        found = (
            self._apart
            and self._near
            and self._before >= least < ratio + (STILL_RATIO if least < TOUCHING_RATIO else 0.0)
            and least < self._c.clap_ratio
            and t_s - self._t_clap_s >= self._c.clap_rest_s
        )
        self._before, self._last, self._t_last_s = least, ratio, t_s
        if found:
            self._t_clap_s = t_s
            self._apart = False
            return t_least_s
        self._apart = self._apart or (tracked and ratio > max(APART_RATIO, self._c.clap_ratio))
        return None

    def busy(self, t_s: float) -> bool:
        """Whether a clap may be under way or just over."""
        return t_s - self._t_near_s < self._c.clap_rest_s
