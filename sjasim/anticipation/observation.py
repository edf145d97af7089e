"""Features of the dance for learned methods: beat, the dancers' latest events and their last iteration, as numbers.

The Gymnasium environments use the same functions, so that a policy gets the same features in training and as a method.
"""

from __future__ import annotations

import math
from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from ..core import SYNCHRONY_KINDS, Array, Event, Move
from ..core.compiled import compiled_entry
from ..core.method_io import MethodContext
from ..core.tempo import TempoMap
from .event_history import EventHistory, nominal_times
from .timing_appropriateness import EPSILON_S

Row = NDArray[np.float32]
"""Features as float32, the precision of the environments' observations."""

MOVES = (Move.STOP, Move.FORWARD, Move.BACKWARD, Move.TURN)
"""Moves that a policy chooses from; a policy's action is an index into them."""

MAX_AGE_S = 10.0
"""Upper bound of the age of an event [s]: half an iteration of the paper's dance. It stands for "never" as well."""

MAX_DEVIATION_S = 3.0
"""Bound of the deviation of a dancer's step from the music, to both sides [s]."""

MIN_SCALED_BEAT = -2.0
"""Lower bound of the beat divided by 40, reached long before the music; the upper bound is its opposite."""

PERIODS = (1.0, 4.0, 8.0, 40.0)
"""Periods of the beat's phases [beats]: a beat, a bar, two bars, and an iteration of the paper's dance."""

_PHASE_RATES = np.array([math.tau / period for period in PERIODS])
"""(4,) angular frequencies of the phases [rad/beat]."""

_KIND_INDEX = {kind: index for index, kind in enumerate(SYNCHRONY_KINDS)}

_BEAT_FEATURES = 1 + 2 * len(PERIODS)
"""Number of features of the beat: its scaled value, then cosine and sine of each phase."""


def iteration_at(context: MethodContext, t_s: float) -> int:
    """The iteration whose window holds a session time; the last iteration for later times."""
    return min(bisect_left(context.window_end_s, t_s), context.iterations)


@compiled_entry
def write_time_features(t_s: float, line: tuple[float, float], last_s: Array, beats: Row, ages: Row) -> None:
    """Write the features that change with time alone.

    Args:
        t_s: session time [s].
        line: beat as a linear function of session time, see `EventFeatures.line`.
        last_s: (D, 5, 2) when each dancer last did each kind, regular and early [s].
        beats: (9,) to write: the beat over 40, then the cosines and the sines of its phases in `PERIODS`.
        ages: (D * 10,) to write: seconds since each time in ``last_s``, from 0 to `MAX_AGE_S`.
    """
    beat = line[0] + line[1] * t_s
    beats[0] = min(max(beat / 40.0, MIN_SCALED_BEAT), -MIN_SCALED_BEAT)
    for k in range(len(_PHASE_RATES)):
        beats[1 + k] = math.cos(_PHASE_RATES[k] * beat)
        beats[1 + len(_PHASE_RATES) + k] = math.sin(_PHASE_RATES[k] * beat)

    for k, event_s in enumerate(last_s.flat):
        ages[k] = min(max(t_s - event_s, 0.0), MAX_AGE_S)


class EventFeatures:
    """Collects events and computes the features of a learned method from them.

    It uses what an anticipation method is told and nothing else.

    Args:
        context: the dance.

    Attributes:
        iteration: the iteration whose window holds the session time that has been reached; the last one after its
            window, and -1 before the first call of `advance_to`.
        line: beat of the iteration as a linear function of session time, valid at the present tempo: the beat at
            session time 0, and beats per second.
        last_s: (D, 5, 2) when each dancer last did each kind, regular and early [s]; minus infinity for never.
        last_iteration: (D, K) deviation of each dancer's step from its beat in the iteration before [s]; 0 if unknown.
    """

    def __init__(self, context: MethodContext) -> None:
        self._context = context
        self._history = EventHistory(context, EPSILON_S)
        self._person_index = {name: index for index, name in enumerate(context.cast)}
        self._tempo = context.tempo or TempoMap((0.0, 1.0), (0.0, context.beat_s))
        self._valid_until_s = -math.inf

        self.line = (0.0, 0.0)
        self.iteration = -1
        self.last_s = np.full((len(context.cast), len(SYNCHRONY_KINDS), 2), -np.inf)
        self.last_iteration: Row = np.zeros((len(context.cast), len(context.steps)), dtype=np.float32)

    def add(self, event: Event) -> None:
        """Add an event; those of persons outside the cast are ignored."""
        person = self._person_index.get(event.person)
        if person is None:
            return
        self._history.add(event)
        index = (person, _KIND_INDEX[event.kind], int(event.early))
        self.last_s[index] = max(self.last_s[index], event.t_s)

    def advance_to(self, t_s: float) -> bool:
        """Update iteration and tempo to a session time, which must not be before the last one.

        Returns:
            whether another iteration has begun, or the first one.
        """
        # Within a tempo segment and an iteration nothing changes; the environments call this at every step.
        if t_s <= self._valid_until_s:
            return False

        context = self._context
        previous = self.iteration
        iteration = self.iteration = iteration_at(context, t_s)
        window_end_s = context.window_end_s[iteration] if iteration < context.iterations else math.inf
        beat, rate, tempo_end_s = self._tempo.line(t_s)
        self.line = (beat - self._tempo.beat(context.iteration_start_s[iteration]), rate)
        self._valid_until_s = min(window_end_s, tempo_end_s)

        if iteration == previous:
            return False
        if iteration:
            nominal_s = nominal_times(context, iteration - 1)
            deviation_s = np.nan_to_num(self._history.step_times(iteration - 1) - nominal_s)
            self.last_iteration = np.clip(deviation_s, -MAX_DEVIATION_S, MAX_DEVIATION_S).astype(np.float32)
        return True

    def row(self, t_s: float, move: int, sent_s: float) -> Row:
        """(N,) all features of a learned method: beat, move in force, ages, iteration, last iteration.

        Args:
            t_s: session time, not before the last one [s].
            move: the robot's move in force, as an index into `MOVES`.
            sent_s: session time when it was sent [s].
        """
        self.advance_to(t_s)
        beats = np.empty(_BEAT_FEATURES, dtype=np.float32)
        ages = np.empty(self.last_s.size, dtype=np.float32)
        write_time_features(t_s, self.line, self.last_s, beats, ages)

        one_hot = [0.0] * len(MOVES)
        one_hot[move] = 1.0
        command = [*one_hot, min(t_s - sent_s, MAX_AGE_S)]
        deviations = self.last_iteration.ravel()
        return np.concatenate([beats, command, ages, [self.iteration], deviations], dtype=np.float32)
