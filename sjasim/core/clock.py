"""Integer ticks, rates, device clocks, and random streams by name."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass

import numpy as np

from .errors import ConfigError


@dataclass(frozen=True, slots=True)
class Ticks:
    """Physics time as whole ticks: time = tick / rate, never accumulated.

    Attributes:
        rate_hz: physics steps per second.
    """

    rate_hz: int

    def time_s(self, tick: int) -> float:
        """Session time of a tick [s]."""
        return tick / self.rate_hz

    def at_or_after(self, time_s: float) -> int:
        """First tick whose time is not before ``time_s``; rounding noise of 1 ns is forgiven."""
        return math.ceil(time_s * self.rate_hz - 1e-9 * self.rate_hz)

    def first_s(self, time_s: float) -> float:
        """Session time of the first tick that is not before ``time_s``; no rounding noise is forgiven [s]."""
        tick = math.ceil(time_s * self.rate_hz - 1e-9 * self.rate_hz)
        at_s = tick / self.rate_hz
        return at_s if at_s >= time_s else (tick + 1) / self.rate_hz

    def firing(self, count: int, task_hz: int) -> int:
        """Tick of the ``count``-th firing of a task, ceil(count P / f).

        Velocities must use the stamped interval: 50 Hz on 240 Hz fires after 4 or 5 ticks.

        Raises:
            ConfigError: the task is faster than the physics.
        """
        if task_hz > self.rate_hz:
            raise ConfigError("rate_hz", task_hz, f"at most the physics rate {self.rate_hz}")
        return -(-count * self.rate_hz // task_hz)


class Task:
    """A periodic duty on the physics' ticks; `due` tells when it fires next."""

    __slots__ = ("_count", "_hz", "_rate_hz", "due")

    def __init__(self, ticks: Ticks, rate_hz: int) -> None:
        self._rate_hz = ticks.rate_hz
        self._hz = rate_hz
        self._count = 0
        self.due = ticks.firing(0, rate_hz)

    def advance(self) -> None:
        """Move on to the next firing."""
        self._count += 1
        self.due = -(-self._count * self._rate_hz // self._hz)


@dataclass(frozen=True, slots=True)
class DeviceClock:
    """A device's own clock: an offset and a drift against session time, and at most one jump.

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
        """What the clock shows at session time ``t_s`` [s]."""
        jumped = self.jump_s if t_s >= self.jump_at_s else 0.0
        return t_s + self.offset_s + self.drift * t_s + jumped


def stream(seed: int, *path: str | int) -> np.random.Generator:
    """A random stream that depends on the session's seed and its own name only.

    Adding a room never shifts another room's stream. A *person* and a *performance* have separate streams, so
    that the same people meet every method.

    Args:
        seed: the session's seed, not negative.
        path: the stream's name, such as ``"humans", "person", 0``.

    Returns:
        a fresh generator; the same arguments give the same numbers in every process.
    """
    key = zlib.crc32("/".join(str(part) for part in path).encode())
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, key])))
