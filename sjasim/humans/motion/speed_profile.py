"""The speed of a dancer's pelvis during one move: two ramps that cross the onset speed exactly at start and stop.

All values are assumed but the onset speed, which defines when a move truly starts and stops.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core import Array
from ...core.errors import ConfigError

ONSET_M_S = 0.10
"""Speed whose crossing is the true start or stop of a move [m/s]."""

RAMP_S = 0.50
"""Length of a ramp from rest to cruising speed [s]; from .05 to .25 m/s it takes a quarter of a second."""

MIN_CRUISE_M_S = 0.27
"""Slowest cruising speed [m/s]; in a longer move the dancer covers more distance instead."""

MAX_CRUISE_M_S = 0.45
"""Fastest cruising speed [m/s]; in a shorter move the dancer covers less distance instead."""

MIN_DURATION_S = 0.50
"""Shortest move [s]: two steps and both crossings of the onset speed do not fit into less."""


def minimum_jerk(u: Array) -> Array:
    """Minimum-jerk step: rises from 0 to 1 for u from 0 to 1, and is constant outside."""
    x = np.clip(u, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 + x * (6.0 * x - 15.0)))


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """Speed as a function of the time since the start event.

    Attributes:
        cruise_m_s: speed between the ramps.
        ramp_s: length of each ramp.
        rise_s: time for which the speed is above zero before the start event, and after the stop event.
        duration_s: from start event to stop event.
    """

    cruise_m_s: float
    ramp_s: float
    rise_s: float
    duration_s: float

    @property
    def distance_m(self) -> float:
        """Distance of the whole move [m]."""
        return self.cruise_m_s * (self.duration_s + 2 * self.rise_s - self.ramp_s)

    def speed_at(self, since_s: Array) -> Array:
        """Speed at times since the start event [m/s]."""
        up, down = self._progress(since_s)
        return self.cruise_m_s * _ramp(np.minimum(up, down))

    def distance_at(self, since_s: Array) -> Array:
        """Distance covered by times since the start event [m]."""
        up, down = self._progress(since_s)
        rising = self.cruise_m_s * self.ramp_s * _ramp_integral(up)
        falling = self.cruise_m_s * self.ramp_s * _ramp_integral(down)
        return np.where(up < down, rising, self.distance_m - falling)

    def _progress(self, since_s: Array) -> tuple[Array, Array]:
        """Progress in the first ramp, and what is left of the last one, in lengths of a ramp."""
        up = (since_s + self.rise_s) / self.ramp_s
        down = (self.duration_s + self.rise_s - since_s) / self.ramp_s
        return up, down


def _ramp(u: Array) -> Array:
    """Smooth step 3 u^2 - 2 u^3, constant outside 0 to 1."""
    x = np.clip(u, 0.0, 1.0)
    return np.asarray(x * x * (3.0 - 2.0 * x))


def _ramp_integral(u: Array) -> Array:
    """Integral of `_ramp` from 0 to u."""
    x = np.clip(u, 0.0, 1.0)
    return np.asarray(x**3 * (1.0 - 0.5 * x) + np.maximum(u - 1.0, 0.0))


def _crossing(level: float) -> float:
    """Where `_ramp` reaches a level between 0 and 1, by the closed form of the cubic's root."""
    return float(0.5 - np.sin(np.arcsin(1.0 - 2.0 * level) / 3.0))


def _fit_ramp(cruise_m_s: float, duration_s: float) -> tuple[float, float]:
    """Share of a ramp below the onset speed, and the length of a ramp, shortened where two would not fit [s]."""
    share = _crossing(ONSET_M_S / cruise_m_s)
    return share, min(RAMP_S, duration_s / (2.0 * (1.0 - share)))


def speed_profile(distance_m: float, duration_s: float) -> SpeedProfile:
    """The profile of a move of given duration, and of given distance as far as walking speeds allow.

    Args:
        distance_m: wanted distance. It is not kept where it needs a speed below `MIN_CRUISE_M_S` or above
            `MAX_CRUISE_M_S`.
        duration_s: time between the two crossings of the onset speed.

    Raises:
        ConfigError: the move is shorter than `MIN_DURATION_S`.
    """
    if not MIN_DURATION_S <= duration_s < np.inf:
        raise ConfigError("duration_s", duration_s, f"{MIN_DURATION_S:g} s or longer")

    # The ramp depends on the speed and the speed on the ramp; eight iterations reach the fixed point.
    cruise = distance_m / duration_s
    for _ in range(8):
        cruise = min(max(cruise, MIN_CRUISE_M_S), MAX_CRUISE_M_S)
        share, ramp = _fit_ramp(cruise, duration_s)
        cruise = distance_m / (duration_s + 2.0 * share * ramp - ramp)

    cruise = min(max(cruise, MIN_CRUISE_M_S), MAX_CRUISE_M_S)
    share, ramp = _fit_ramp(cruise, duration_s)
    return SpeedProfile(cruise, ramp, share * ramp, duration_s)
