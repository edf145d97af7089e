"""Physics ticks, periodic tasks, device clocks, and named random streams."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass

import numpy as np

from .errors import ConfigError


@dataclass(frozen=True, slots=True)
class Ticks:
    """Conversion between physics ticks and session time.

    A time is computed as tick / rate. It is never accumulated, so that rounding errors do not add up.

    Attributes:
        rate_hz: physics steps per second.
    """

    rate_hz: int

    def time_s(self, tick: int) -> float:
        """Session time of a tick [s]."""
        return tick / self.rate_hz

    def at_or_after(self, time_s: float) -> int:
        """Return the first tick whose time is not before ``time_s``, with a tolerance of 1 ns for rounding."""
        return math.ceil(time_s * self.rate_hz - 1e-9 * self.rate_hz)

    def first_s(self, time_s: float) -> float:
        """Return the session time of the first tick that is not before ``time_s``, without a tolerance [s]."""
        tick = math.ceil(time_s * self.rate_hz - 1e-9 * self.rate_hz)
        at_s = tick / self.rate_hz
        return at_s if at_s >= time_s else (tick + 1) / self.rate_hz

    def firing(self, count: int, task_hz: int) -> int:
        """Return the tick of the ``count``-th run of a task, counted from 0: ceil(count * rate_hz / task_hz).

        If the physics rate is not a multiple of the task rate, the intervals differ by one tick: a task at 50 Hz on
        ticks at 240 Hz runs every 4 or 5 ticks. Compute velocities from the times of the two samples, therefore, and
        not from the nominal rate.

        Raises:
            ConfigError: the task is faster than the physics.
        """
        if task_hz > self.rate_hz:
            raise ConfigError("rate_hz", task_hz, f"at most the physics rate {self.rate_hz}")
        return -(-count * self.rate_hz // task_hz)


class Task:
    """Schedule of a task that runs periodically on physics ticks. ``due`` is the tick of its next run.

    Args:
        ticks: ticks of the physics.
        rate_hz: runs per second, at most the rate of the physics.

    Raises:
        ConfigError: the task is faster than the physics.
    """

    __slots__ = ("_count", "_hz", "_rate_hz", "due")

    def __init__(self, ticks: Ticks, rate_hz: int) -> None:
        self._rate_hz = ticks.rate_hz
        self._hz = rate_hz
        self._count = 0
        self.due = ticks.firing(0, rate_hz)

    def advance(self) -> None:
        """Set ``due`` to the tick of the following run."""
        self._count += 1
        self.due = -(-self._count * self._rate_hz // self._hz)


@dataclass(frozen=True, slots=True)
class DeviceClock:
    """Clock of a device, with an offset and a drift relative to session time, and at most one jump.

    Attributes:
        offset_s: reading of the clock at session time 0.
        drift: relative error of the rate; a clock with 20e-6 gains 20 us per second.
        jump_at_s: session time of the jump; infinity for none.
        jump_s: size of the jump.
    """

    offset_s: float = 0.0
    drift: float = 0.0
    jump_at_s: float = float("inf")
    jump_s: float = 0.0

    def reading(self, t_s: float) -> float:
        """Return the reading of the clock at session time ``t_s`` [s]."""
        jumped = self.jump_s if t_s >= self.jump_at_s else 0.0
        return t_s + self.offset_s + self.drift * t_s + jumped


def stream(seed: int, *path: str | int) -> np.random.Generator:
    """Create a random generator that depends only on the session's seed and on the stream's name.

    Each part of the system draws from its own streams, so that adding a part does not change the random numbers of the
    others. Persons and performances have separate streams, so that all methods are tested with the same persons.

    Args:
        seed: the session's seed, not negative.
        path: parts of the stream's name, such as ``"humans", "person", 0``.

    Returns:
        a new generator. The same arguments give the same numbers in every process.
    """
    # Python salts hash() of strings differently in each process, so a CRC is used instead.
    key = zlib.crc32("/".join(str(part) for part in path).encode())
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, key])))
