"""What a learner is told of the dancers: events, the last iteration and the beat, as a row of numbers."""

from __future__ import annotations

import math
from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from ..answers import Brief
from ..types import (
    SYNCHRONY_KINDS,
    Array,
    Event,
    Move,
)
from .appropriateness import EPSILON_S
from .history import History, nominal_times

Row = NDArray[np.float32]

MOVES = (Move.STOP, Move.FORWARD, Move.BACKWARD, Move.TURN)
"""What a learner chooses from, in order."""

OLDEST_S = 10.0
"""Age at which an event is forgotten [s]; one that never was has this age: half an iteration of the paper's dance."""

LATEST_S = 3.0
"""Bound of what is told of the last iteration's times, to both sides of the music [s]."""

PERIODS = (1.0, 4.0, 8.0, 40.0)
"""Beats after which each of the beat's phases comes again: beat, bar, two bars, the paper's iteration."""

_TURNS = [math.tau / period for period in PERIODS]
_KIND = {kind: index for index, kind in enumerate(SYNCHRONY_KINDS)}


def iteration_at(brief: Brief, t_s: float) -> int:
    """The iteration whose window holds a session time; the last one after it."""
    return min(bisect_left(brief.window_end_s, t_s), brief.iterations)


class Features:
    """Events in, rows of numbers out; it knows what a method knows and nothing more.

    Args:
        brief: the dance.
    """

    def __init__(self, brief: Brief) -> None:
        self._brief = brief
        self._history = History(brief, EPSILON_S)
        self._closed = -1
        self._person = {name: index for index, name in enumerate(brief.cast)}
        self._last_s = np.full((len(brief.cast), len(SYNCHRONY_KINDS), 2), -np.inf)
        self._last_iteration = np.zeros((len(brief.cast), len(brief.steps)), dtype=np.float32)

    def add(self, event: Event) -> None:
        """Remember an event; those of persons outside the cast are not told."""
        person = self._person.get(event.person)
        if person is None:
            return
        self._history.add(event)
        place = person, _KIND[event.kind], int(event.early)
        self._last_s[place] = max(self._last_s[place], event.t_s)

    def iteration(self, t_s: float) -> int:
        """The iteration whose window holds a session time; the last one after it."""
        return iteration_at(self._brief, t_s)

    def beat(self, t_s: float) -> tuple[float, ...]:
        """The beat of the iteration over 40, then cosines and sines of its phases in `PERIODS`; 9 numbers."""
        beat = self._brief.beat(self.iteration(t_s), t_s)
        phases = [turn * beat for turn in _TURNS]
        return beat / 40.0, *map(math.cos, phases), *map(math.sin, phases)

    def event_age(self, t_s: float) -> Array:
        """(D, 5, 2) seconds since each dancer's last event of each kind; regular, then early."""
        return np.asarray(np.minimum(t_s - self._last_s, OLDEST_S))

    def last_iteration(self, t_s: float) -> Row:
        """(D, K) when each dancer did each step in the iteration before, after its beat [s]; 0 where unknown."""
        before = self.iteration(t_s) - 1
        if before != self._closed:
            self._closed = before
            late_s = np.nan_to_num(self._history.times(before) - nominal_times(self._brief, before))
            self._last_iteration = np.clip(late_s, -LATEST_S, LATEST_S).astype(np.float32)
        return self._last_iteration

    def row(self, t_s: float, move: int, sent_s: float) -> Row:
        """(N,) everything a learned method is told.

        Args:
            t_s: session time.
            move: of the robot in force, by its place in `MOVES`.
            sent_s: session time when it was sent.
        """
        chosen = [0.0] * len(MOVES)
        chosen[move] = 1.0
        head = [*self.beat(t_s), *chosen, min(t_s - sent_s, OLDEST_S)]
        late = self.last_iteration(t_s).ravel()
        return np.concatenate(
            [np.array(head), self.event_age(t_s).ravel(), [self.iteration(t_s)], late], dtype=np.float32
        )
