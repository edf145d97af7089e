"""What a learner is told of the dancers: events, the last iteration and the beat, as a row of numbers."""

from __future__ import annotations

import math
from bisect import bisect_left

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..core import SYNCHRONY_KINDS, Array, Event, Move
from ..core.method_io import MethodContext
from ..core.tempo import TempoMap
from .event_history import EventHistory, nominal_times
from .timing_appropriateness import EPSILON_S

Row = NDArray[np.float32]

MOVES = (Move.STOP, Move.FORWARD, Move.BACKWARD, Move.TURN)
"""What a learner chooses from, in order."""

MAX_AGE_S = 10.0
"""Age at which an event is forgotten [s]; one that never was has this age: half an iteration of the paper's dance."""

MAX_DEVIATION_S = 3.0
"""Bound of what is told of the last iteration's times, to both sides of the music [s]."""

MIN_SCALED_BEAT = -2.0
"""Least beat over 40 that is told, long before the music; its opposite is the greatest."""

PERIODS = (1.0, 4.0, 8.0, 40.0)
"""Beats after which each of the beat's phases comes again: beat, bar, two bars, the paper's iteration."""

_TURNS = np.array([math.tau / period for period in PERIODS])
_KIND = {kind: index for index, kind in enumerate(SYNCHRONY_KINDS)}
_BEATS = 1 + 2 * len(PERIODS)


def iteration_at(context: MethodContext, t_s: float) -> int:
    """The iteration whose window holds a session time; the last one after it."""
    return min(bisect_left(context.window_end_s, t_s), context.iterations)


@njit(cache=True)
def write_time_features(t_s: float, line: tuple[float, float], last_s: Array, beats: Row, ages: Row) -> None:
    """Write what is another at every instant.

    Args:
        t_s: session time.
        line: see `EventFeatures`.
        last_s: (D, 5, 2) when each dancer last did each kind [s]; regular, then early.
        beats: (9,) to write: the beat over 40, then cosines and sines of its phases in `PERIODS`.
        ages: (D * 10,) to write: seconds since each of ``last_s``, at most `MAX_AGE_S`.
    """
    beat = line[0] + line[1] * t_s
    beats[0] = min(max(beat / 40.0, MIN_SCALED_BEAT), -MIN_SCALED_BEAT)
    for k in range(len(_TURNS)):
        beats[1 + k], beats[1 + len(_TURNS) + k] = math.cos(_TURNS[k] * beat), math.sin(_TURNS[k] * beat)
    for k, then_s in enumerate(last_s.flat):
        ages[k] = min(max(t_s - then_s, 0.0), MAX_AGE_S)


class EventFeatures:
    """Events in, rows of numbers out; it knows what a method knows and nothing more.

    Args:
        context: the dance.

    Attributes:
        iteration: the one whose window holds the session time that has been reached; the last one after it, -1
            before any.
        line: beat of the iteration at session time 0 if the present tempo had always been, and beats per second.
        last_s: (D, 5, 2) when each dancer last did each kind [s]; regular, then early.
        last_iteration: (D, K) when each dancer did each step in the iteration before, after its beat [s]; 0 where
            unknown.
    """

    def __init__(self, context: MethodContext) -> None:
        self._context = context
        self._history = EventHistory(context, EPSILON_S)
        self._person = {name: index for index, name in enumerate(context.cast)}
        self._until_s = -math.inf
        self._tempo = context.tempo or TempoMap((0.0, 1.0), (0.0, context.beat_s))
        self.line = 0.0, 0.0
        self.iteration = -1
        self.last_s = np.full((len(context.cast), len(SYNCHRONY_KINDS), 2), -np.inf)
        self.last_iteration: Row = np.zeros((len(context.cast), len(context.steps)), dtype=np.float32)

    def add(self, event: Event) -> None:
        """Remember an event; those of persons outside the cast are not told."""
        person = self._person.get(event.person)
        if person is None:
            return
        self._history.add(event)
        place = person, _KIND[event.kind], int(event.early)
        self.last_s[place] = max(self.last_s[place], event.t_s)

    def advance_to(self, t_s: float) -> bool:
        """Go on to a session time, not before the last one; whether another iteration has begun, or the first."""
        if t_s <= self._until_s:
            return False
        context, before = self._context, self.iteration
        iteration = self.iteration = iteration_at(context, t_s)
        window_s = context.window_end_s[iteration] if iteration < context.iterations else math.inf
        beat, rate, ends_s = self._tempo.line(t_s)
        self.line = beat - self._tempo.beat(context.iteration_start_s[iteration]), rate
        self._until_s = min(window_s, ends_s)
        if iteration == before:
            return False
        if iteration:
            late_s = np.nan_to_num(self._history.times(iteration - 1) - nominal_times(context, iteration - 1))
            self.last_iteration = np.clip(late_s, -MAX_DEVIATION_S, MAX_DEVIATION_S).astype(np.float32)
        return True

    def row(self, t_s: float, move: int, sent_s: float) -> Row:
        """(N,) everything a learned method is told.

        Args:
            t_s: session time, not before the last one.
            move: of the robot in force, by its place in `MOVES`.
            sent_s: session time when it was sent.
        """
        self.advance_to(t_s)
        beats, ages = np.empty(_BEATS, dtype=np.float32), np.empty(self.last_s.size, dtype=np.float32)
        write_time_features(t_s, self.line, self.last_s, beats, ages)
        chosen = [0.0] * len(MOVES)
        chosen[move] = 1.0
        own, late_s = [*chosen, min(t_s - sent_s, MAX_AGE_S)], self.last_iteration.ravel()
        return np.concatenate([beats, own, ages, [self.iteration], late_s], dtype=np.float32)
