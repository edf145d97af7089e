"""Simulated network links with latency, jitter and loss, and the queue of messages under way."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

T = TypeVar("T")

_BLOCK = 64
"""Messages for which random numbers are drawn at once, which is cheaper than drawing for each message."""


@dataclass(frozen=True, slots=True)
class LinkQuality:
    """Delay and loss of one direction of a link.

    Attributes:
        latency_s: shortest one-way delay [s].
        jitter_s: mean of the exponentially distributed delay on top of it [s].
        loss: probability that a message never arrives.
        ordered: whether messages arrive in the order of sending; if not, one may overtake another.
    """

    latency_s: float
    jitter_s: float
    loss: float
    ordered: bool = False


class MessageQueue(Generic[T]):
    """Queue of messages under way, over one link or several; it gives them out in order of arrival."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, T]] = []
        """(arrival, number of sending, message); the number makes ties definite and keeps messages uncompared."""
        self._sequence = 0
        self.next_arrival_s = math.inf
        """Session time at which the next message arrives; infinite when none is under way [s]."""

    def put(self, t_arrival_s: float, message: T) -> None:
        """Add a message that arrives at this session time."""
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
    """One direction of a link, which decides whether and when a message arrives.

    Args:
        quality: delay and loss.
        rng: the link's own random stream.
        queue: holds the messages while they are under way; links may share one.
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

        A lost message takes as many random numbers as a delivered one, so that another loss rate does not change the
        delays of the messages that still arrive.
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
        """(whether it is lost, delay [s]) of the next messages."""
        quality = self._quality
        lost = self._rng.random(_BLOCK) < quality.loss
        delays_s = quality.latency_s + self._rng.standard_exponential(_BLOCK) * quality.jitter_s
        return list(zip(lost.tolist(), delays_s.tolist(), strict=True))
