"""Physics ticks, periodic tasks, device clocks, and random streams by name."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass

import numpy as np

from .errors import ConfigError


@dataclass(frozen=True, slots=True)
class Ticks:
    """Conversion between physics ticks and session time.

    A time is computed as tick / rate and never accumulated, so that it has no drift.

    Attributes:
        rate_hz: physics steps per second.
    """

    rate_hz: int

    def time_s(self, tick: int) -> float:
        """Session time of a tick [s]."""
        return tick / self.rate_hz

    def at_or_after(self, time_s: float) -> int:
        """First tick whose time is not before ``time_s``, with a tolerance of 1 ns for rounding."""
        return math.ceil(time_s * self.rate_hz - 1e-9 * self.rate_hz)

    def first_s(self, time_s: float) -> float:
        """Session time of the first tick that is not before ``time_s``, without a tolerance [s]."""
        tick = math.ceil(time_s * self.rate_hz - 1e-9 * self.rate_hz)
        at_s = tick / self.rate_hz
        return at_s if at_s >= time_s else (tick + 1) / self.rate_hz

    def firing(self, count: int, task_hz: int) -> int:
        """Tick at which a task runs for the ``count``-th time, counted from 0: ceil(count rate_hz / task_hz).

        The intervals differ by a tick where the rates do not divide: 50 Hz on 240 Hz runs after 4 or 5 ticks. So a
        velocity must be computed from the times of its two samples.

        Raises:
            ConfigError: the task is faster than the physics.
        """
        if task_hz > self.rate_hz:
            raise ConfigError("rate_hz", task_hz, f"at most the physics rate {self.rate_hz}")
        return -(-count * self.rate_hz // task_hz)


class Task:
    """A task that runs periodically on physics ticks. ``due`` is the tick of its next run.

    Args:
        ticks: the physics' ticks.
        rate_hz: runs per second, at most the physics' rate.

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
        """Set ``due`` to the tick of the run after this one."""
        self._count += 1
        self.due = -(-self._count * self._rate_hz // self._hz)


@dataclass(frozen=True, slots=True)
class DeviceClock:
    """The clock of a device: an offset and a drift relative to session time, and at most one jump.

    Attributes:
        offset_s: reading at session time 0.
        drift: relative rate error; 20e-6 gains 20 us per second.
        jump_at_s: session time of a jump; infinite for none.
        jump_s: size of the jump.
    """

    offset_s: float = 0.0
    drift: float = 0.0
    jump_at_s: float = float("inf")
    jump_s: float = 0.0

    def reading(self, t_s: float) -> float:
        """Reading of the clock at session time ``t_s`` [s]."""
        jumped = self.jump_s if t_s >= self.jump_at_s else 0.0
        return t_s + self.offset_s + self.drift * t_s + jumped


def stream(seed: int, *path: str | int) -> np.random.Generator:
    """A new random generator that depends only on the session's seed and on the stream's name.

    Each part of the system draws from streams of its own, so that a new part does not change the numbers of another
    one. A *person* and a *performance* have separate streams, so that the same people meet every method.

    Args:
        seed: the session's seed, not negative.
        path: name of the stream, such as ``"humans", "person", 0``.

    Returns:
        the generator; the same arguments give the same numbers in every process.
    """
    # Python's hash() differs from process to process; a CRC does not.
    key = zlib.crc32("/".join(str(part) for part in path).encode())
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, key])))
