"""What a learner is told of the dancers: events, the last iteration and the beat, as a row of numbers."""

from __future__ import annotations

from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from ..types import SYNCHRONY_KINDS, Brief, Event
from .history import History, nominal_times

Row = NDArray[np.float32]

OLDEST_S = 10.0
"""Age at which an event is forgotten [s]; one that never was has this age: half an iteration of the paper's dance."""

LATEST_S = 3.0
"""Bound of what is told of the last iteration's times, to both sides of the music [s]."""

PERIODS = (1.0, 4.0, 8.0, 40.0)
"""Beats after which each of the beat's phases comes again: beat, bar, two bars, the paper's iteration."""

EPSILON_S = 1.5
_KIND = {kind: index for index, kind in enumerate(SYNCHRONY_KINDS)}


class Features:
    """Events in, rows of numbers out; it knows what a method knows and nothing more.

    Args:
        brief: the dance.
    """

    def __init__(self, brief: Brief) -> None:
        self._brief = brief
        self._history = History(brief, EPSILON_S)
        self._nominal = nominal_times(brief)
        self._closed = -1
        self._person = {name: index for index, name in enumerate(brief.cast)}
        self._last_s = np.full((len(brief.cast), len(SYNCHRONY_KINDS), 2), -np.inf)
        self._last_iteration = np.zeros((len(brief.cast), len(brief.steps)), dtype=np.float32)
        self._turns = 2.0 * np.pi / np.array(PERIODS)

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
        return min(bisect_left(self._brief.window_end_s, t_s), self._brief.iterations)

    def beat(self, t_s: float) -> Row:
        """(9,) the beat of the iteration over 40, then cosines and sines of its phases in `PERIODS`."""
        beat = (t_s - self._brief.iteration_start_s[self.iteration(t_s)]) / self._brief.beat_s
        phase = self._turns * beat
        return np.concatenate([[beat / 40.0], np.cos(phase), np.sin(phase)]).astype(np.float32)

    def event_age(self, t_s: float) -> Row:
        """(D, 5, 2) seconds since each dancer's last event of each kind; regular, then early."""
        return np.minimum(np.maximum(t_s - self._last_s, 0.0), OLDEST_S).astype(np.float32)

    def last_iteration(self, t_s: float) -> Row:
        """(D, K) when each dancer did each step in the iteration before, after its beat [s]; 0 where unknown."""
        before = self.iteration(t_s) - 1
        if before != self._closed:
            self._closed = before
            late_s = np.nan_to_num(self._history.times(before) - self._nominal)
            self._last_iteration = np.clip(late_s, -LATEST_S, LATEST_S).astype(np.float32)
        return self._last_iteration
