"""The speed of a dancer's pelvis during one move: crisp ramps that cross the onset speed exactly at start and stop.

All values are assumed but for the onset speed, which defines when a move truly starts (.10 m/s).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core import Array
from ...core.errors import ConfigError

ONSET_M_S = 0.10
"""Speed whose crossing is the true start or stop of a move [m/s]."""
RAMP_S = 0.50
"""Length of a ramp from rest to cruising speed [s]; .05 to .25 m/s then takes a quarter of a second."""
SLOWEST_M_S = 0.27
"""People who take longer walk farther rather than creep [m/s]."""
FASTEST_M_S = 0.45
"""Where a move is too short for its distance the distance gives way [m/s]."""

SHORTEST_S = 0.50
"""A move cannot take less: two steps and both crossings of the onset speed would not fit [s]."""


def smooth(u: Array) -> Array:
    """Minimum-jerk step from 0 to 1 for u from 0 to 1, flat outside."""
    x = np.clip(u, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 + x * (6.0 * x - 15.0)))


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """Speed over time since the start event.

    Attributes:
        cruise_m_s: speed between the ramps.
        ramp_s: length of each ramp.
        rise_s: how long before the start event the speed leaves zero, and after the stop event it is zero again.
        duration_s: from start event to stop event.
    """

    cruise_m_s: float
    ramp_s: float
    rise_s: float
    duration_s: float

    @property
    def distance_m(self) -> float:
        """Whole way [m]."""
        return self.cruise_m_s * (self.duration_s + 2 * self.rise_s - self.ramp_s)

    def speed(self, since_s: Array) -> Array:
        """Speed at times since the start event [m/s]."""
        up = (since_s + self.rise_s) / self.ramp_s
        down = (self.duration_s + self.rise_s - since_s) / self.ramp_s
        return self.cruise_m_s * _ramp(np.minimum(up, down))

    def travelled(self, since_s: Array) -> Array:
        """Way at times since the start event [m]."""
        up = (since_s + self.rise_s) / self.ramp_s
        down = (self.duration_s + self.rise_s - since_s) / self.ramp_s
        rising = self.cruise_m_s * self.ramp_s * _ramp_integral(up)
        falling = self.cruise_m_s * self.ramp_s * _ramp_integral(down)
        return np.where(up < down, rising, self.distance_m - falling)


def _ramp(u: Array) -> Array:
    x = np.clip(u, 0.0, 1.0)
    return np.asarray(x * x * (3.0 - 2.0 * x))


def _ramp_integral(u: Array) -> Array:
    """Integral of the ramp from 0, going on at full speed beyond 1."""
    x = np.clip(u, 0.0, 1.0)
    return np.asarray(x**3 * (1.0 - 0.5 * x) + np.maximum(u - 1.0, 0.0))


def _crossing(level: float) -> float:
    """Where the ramp 3u^2 - 2u^3 passes a level between 0 and 1 (closed form of the cubic)."""
    return float(0.5 - np.sin(np.arcsin(1.0 - 2.0 * level) / 3.0))


def speed_profile(distance_m: float, duration_s: float) -> SpeedProfile:
    """Profile for a move of given duration, and of given distance as far as walking speeds allow.

    Args:
        distance_m: wanted way; gives way where it would need less than the slowest or more than the fastest speed.
        duration_s: time between the crossings of the onset speed.

    Raises:
        ConfigError: the move is shorter than `SHORTEST_S`.
    """
    if not SHORTEST_S <= duration_s < np.inf:
        raise ConfigError("duration_s", duration_s, f"{SHORTEST_S:g} s or longer")
    ramp = RAMP_S
    cruise = distance_m / duration_s
    for _ in range(8):
        cruise = min(max(cruise, SLOWEST_M_S), FASTEST_M_S)
        share = _crossing(ONSET_M_S / cruise)
        ramp = min(RAMP_S, duration_s / (2.0 * (1.0 - share)))
        cruise = distance_m / (duration_s + 2.0 * share * ramp - ramp)
    cruise = min(max(cruise, SLOWEST_M_S), FASTEST_M_S)
    share = _crossing(ONSET_M_S / cruise)
    ramp = min(RAMP_S, duration_s / (2.0 * (1.0 - share)))
    return SpeedProfile(cruise, ramp, share * ramp, duration_s)
