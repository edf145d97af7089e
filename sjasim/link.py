"""A network link: latency, jitter, loss and order; a heap of timed messages for sensors, server and robot alike."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

T = TypeVar("T")


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


class Link(Generic[T]):
    """One direction of a link; messages go in with their sending time and come out in order of arrival.

    Args:
        quality: latency, jitter, loss.
        rng: the link's own random stream.
    """

    def __init__(self, quality: LinkQuality, rng: np.random.Generator) -> None:
        self._quality = quality
        self._random, self._exponential = rng.random, rng.standard_exponential
        self._heap: list[tuple[float, int, T]] = []  # arrival, number sent: no two are equal
        self._sequence = 0
        self._last_arrival_s = -np.inf
        self.next_arrival_s = math.inf
        """When the next message comes out; infinite when none is under way."""
        self.sent = 0
        self.lost = 0

    def send(self, t_s: float, message: T) -> None:
        """Put a message in at session time ``t_s``; it may be lost.

        The same number of random draws is spent on lost and delivered messages, so that changing the loss
        changes nothing else.
        """
        self.sent += 1
        lost = self._random() < self._quality.loss
        delay = self._quality.latency_s + self._exponential() * self._quality.jitter_s
        if lost:
            self.lost += 1
            return
        arrival = t_s + delay
        if self._quality.ordered:
            arrival = max(arrival, self._last_arrival_s)
            self._last_arrival_s = arrival
        heapq.heappush(self._heap, (arrival, self._sequence, message))
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
