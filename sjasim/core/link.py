"""Network links: latency, jitter, loss and order; a heap of timed messages for sensors, server and robot alike."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

T = TypeVar("T")

_BLOCK = 64


@dataclass(frozen=True, slots=True)
class LinkQuality:
    """How one direction of a link behaves.

    Attributes:
        latency_s: shortest one-way delay.
        jitter_s: mean of the exponential delay on top of it.
        loss: probability that a message never arrives.
        ordered: whether a message may overtake an earlier one (False) or not (True).
    """

    latency_s: float
    jitter_s: float
    loss: float
    ordered: bool = False


class Mail(Generic[T]):
    """Messages under way, over one link or many; they come out in order of arrival."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, T]] = []  # arrival, number sent: no two are equal
        self._sequence = 0
        self.next_arrival_s = math.inf
        """When the next message comes out; infinite when none is under way."""

    def put(self, t_arrival_s: float, message: T) -> None:
        """Send a message on its way."""
        heapq.heappush(self._heap, (t_arrival_s, self._sequence, message))
        self._sequence += 1
        self.next_arrival_s = self._heap[0][0]

    def receive(self, until_s: float) -> list[tuple[float, T]]:
        """Take out every message that has arrived by ``until_s``, as (arrival time, message), earliest first."""
        arrived: list[tuple[float, T]] = []
        while self._heap and self._heap[0][0] <= until_s:
            t_arrival_s, _, message = heapq.heappop(self._heap)
            arrived.append((t_arrival_s, message))
        self.next_arrival_s = self._heap[0][0] if self._heap else math.inf
        return arrived


class Link(Generic[T]):
    """One direction of a link: it decides whether and when a message arrives.

    Args:
        quality: latency, jitter, loss.
        rng: the link's own random stream.
        mail: where its messages are while they are under way; links may share one.
    """

    def __init__(self, quality: LinkQuality, rng: np.random.Generator, mail: Mail[T]) -> None:
        self._quality = quality
        self._rng = rng
        self._draws: list[tuple[bool, float]] = []
        self._mail = mail
        self._last_arrival_s = -np.inf
        self.sent = 0
        self.lost = 0

    def send(self, t_s: float, message: T) -> None:
        """Put a message in at session time ``t_s``; it may be lost.

        The same number of random draws is spent on lost and delivered messages, so that changing the loss
        changes nothing else.
        """
        self.sent += 1
        if not self._draws:
            self._draws = self._drawn()
        lost, delay_s = self._draws.pop()
        if lost:
            self.lost += 1
            return
        arrival = t_s + delay_s
        if self._quality.ordered:
            arrival = max(arrival, self._last_arrival_s)
            self._last_arrival_s = arrival
        self._mail.put(arrival, message)

    def _drawn(self) -> list[tuple[bool, float]]:
        """The fate of the next messages, whether they are lost and their delay [s]; for many at a time is cheaper."""
        quality = self._quality
        lost, delays = self._rng.random(_BLOCK) < quality.loss, self._rng.standard_exponential(_BLOCK)
        return list(zip(lost.tolist(), (quality.latency_s + delays * quality.jitter_s).tolist(), strict=True))
