"""Simulated network links with latency, jitter and loss, and the queue of messages in transit."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

T = TypeVar("T")

_BLOCK = 64
"""Number of messages for which random numbers are drawn together; one call of NumPy per message would be slower."""


@dataclass(frozen=True, slots=True)
class LinkQuality:
    """Delay and loss of one direction of a link.

    Attributes:
        latency_s: smallest one-way delay [s].
        jitter_s: mean of the exponentially distributed delay that is added to ``latency_s`` [s].
        loss: probability that a message is lost.
        ordered: whether messages arrive in the order of sending; otherwise a message may overtake another.
    """

    latency_s: float
    jitter_s: float
    loss: float
    ordered: bool = False


class MessageQueue(Generic[T]):
    """Queue of the messages in transit over one or more links, in order of arrival."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, T]] = []
        """(arrival time [s], sequence number, message).

        The sequence number orders messages that arrive at the same time, and avoids comparisons of messages.
        """
        self._sequence = 0
        self.next_arrival_s = math.inf
        """Session time at which the next message arrives [s]; infinity if no message is in transit."""

    def put(self, t_arrival_s: float, message: T) -> None:
        """Add a message that arrives at session time ``t_arrival_s``."""
        heapq.heappush(self._heap, (t_arrival_s, self._sequence, message))
        self._sequence += 1
        self.next_arrival_s = self._heap[0][0]

    def receive(self, until_s: float) -> list[tuple[float, T]]:
        """Remove and return the messages that have arrived by ``until_s``: (arrival time, message), earliest first."""
        arrived: list[tuple[float, T]] = []
        while self._heap and self._heap[0][0] <= until_s:
            t_arrival_s, _, message = heapq.heappop(self._heap)
            arrived.append((t_arrival_s, message))
        self.next_arrival_s = self._heap[0][0] if self._heap else math.inf
        return arrived


class Link(Generic[T]):
    """One direction of a network link, which draws the delay and the loss of each message.

    Args:
        quality: delay and loss of the link.
        rng: random stream of this link alone.
        queue: queue for the messages in transit; several links may share one.
    """

    def __init__(self, quality: LinkQuality, rng: np.random.Generator, queue: MessageQueue[T]) -> None:
        self._quality = quality
        self._rng = rng
        self._draws: list[tuple[bool, float]] = []
        self._queue = queue
        self._last_arrival_s = -np.inf
        self.sent = 0
        self.lost = 0

    def send(self, t_s: float, message: T) -> None:
        """Send a message at session time ``t_s``; it may be lost.

        Delays are drawn for lost messages as well, so that a change of the loss rate does not change the delays of the
        delivered messages.
        """
        self.sent += 1
        if not self._draws:
            self._draws = self._draw_block()
        lost, delay_s = self._draws.pop()
        if lost:
            self.lost += 1
            return

        arrival = t_s + delay_s
        if self._quality.ordered:
            arrival = max(arrival, self._last_arrival_s)
            self._last_arrival_s = arrival
        self._queue.put(arrival, message)

    def _draw_block(self) -> list[tuple[bool, float]]:
        """Return (whether it is lost, delay [s]) for each of the next messages."""
        quality = self._quality
        lost = self._rng.random(_BLOCK) < quality.loss
        delays_s = quality.latency_s + self._rng.standard_exponential(_BLOCK) * quality.jitter_s
        return list(zip(lost.tolist(), delays_s.tolist(), strict=True))
