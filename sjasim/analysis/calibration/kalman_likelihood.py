"""The likelihood of event times under linear phase correction, by a Kalman filter over the events.

The state is every dancer's own deviation and the group's common shift; dancers' events are its noisy sums. Which
events are missing is all that the filter's gains depend on, so they are worked out once for every pattern of gaps.

Source: jacoby2015, section 2 (the ensemble as a linear model); the state-space form and its likelihood are textbook.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from ...core import Array, BoolArray, IntArray


class Noise(NamedTuple):
    """Variances of the model, in the square of the data's unit.

    Attributes:
        timekeeper: (D,) of each event's timekeeper noise.
        first: (D,) of own deviations at a sequence's first event.
        motor: (D,) of the noise that is not carried on.
        common: of the common shift.
        correlation: of the common shift from event to event.
    """

    timekeeper: Array
    first: Array
    motor: Array
    common: float
    correlation: float


@njit(cache=True)
def _gains(
    present: BoolArray, transition: Array, timekeeper: Array, first: Array, motor: Array, common: float, rho: float
) -> tuple[Array, Array]:
    """(E, D, D + 1) gain of each event and (E, D) variance of its innovation, for one pattern of gaps."""
    events, dancers = present.shape
    size = dancers + 1
    gains = np.zeros((events, dancers, size))
    variances = np.ones((events, dancers))
    covariance = np.zeros((size, size))
    step = np.zeros((size, size))
    step[:dancers, :dancers] = transition
    step[dancers, dancers] = rho
    for e in range(events):
        if e == 0:
            for i in range(dancers):
                covariance[i, i] = first[i]
            covariance[dancers, dancers] = common
        else:
            covariance = step @ covariance @ step.T
            for i in range(dancers):
                covariance[i, i] += timekeeper[i]
            covariance[dancers, dancers] += common * (1.0 - rho * rho)
        for i in range(dancers):
            if not present[e, i]:
                continue
            column = covariance[:, i] + covariance[:, dancers]
            variance = column[i] + column[dancers] + motor[i]
            gains[e, i] = column / variance
            variances[e, i] = variance
            for a in range(size):
                for b in range(size):
                    covariance[a, b] -= gains[e, i, a] * column[b]
    return gains, variances


@njit(cache=True)
def _distance(times: Array, present: BoolArray, gains: Array, variances: Array, transition: Array, rho: float) -> float:
    """Squared distance of one sequence from its predictions, in their standard deviations."""
    events, dancers = present.shape
    state = np.zeros(dancers + 1)
    moved = np.zeros(dancers + 1)
    total = 0.0
    for e in range(events):
        if e:
            for i in range(dancers):
                moved[i] = 0.0
                for j in range(dancers):
                    moved[i] += transition[i, j] * state[j]
            moved[dancers] = rho * state[dancers]
            state[:] = moved
        for i in range(dancers):
            if present[e, i]:
                gap = times[e, i] - state[i] - state[dancers]
                total += gap * gap / variances[e, i]
                for a in range(dancers + 1):
                    state[a] += gains[e, i, a] * gap
    return total


@njit(cache=True)
def _evaluate(
    times: Array, pattern: IntArray, patterns: BoolArray, transition: Array, timekeeper: Array, first: Array,
    motor: Array, common: float, rho: float,
) -> tuple[Array, Array]:  # fmt: skip
    distance, log_det = np.zeros(len(times)), np.zeros(len(times))
    for p in range(len(patterns)):
        gains, variances = _gains(patterns[p], transition, timekeeper, first, motor, common, rho)
        log_sum = np.log(variances).sum() if variances.min() > 0.0 else np.inf
        for n in range(len(times)):
            if pattern[n] == p:
                log_det[n] = log_sum
                distance[n] = _distance(times[n], patterns[p], gains, variances, transition, rho)
    return distance, log_det


@njit(cache=True)
def log_mixture(distance: Array, counts: IntArray, log_scale: Array, log_weight: Array) -> Array:
    """(N,) log densities, but for determinants and constants, of sequences whose noise has a random scale.

    Args:
        distance: (N,) squared distances at scale 1.
        counts: (N,) events in each sequence.
        log_scale: (S,) logarithms of the scales.
        log_weight: (S,) logarithms of their probabilities.
    """
    inverse = np.exp(-2.0 * log_scale)
    out = np.empty(len(distance))
    terms = np.empty(len(log_scale))
    for n in range(len(distance)):
        highest = -np.inf
        for s in range(len(log_scale)):
            terms[s] = log_weight[s] - counts[n] * log_scale[s] - 0.5 * distance[n] * inverse[s]
            highest = max(highest, terms[s])
        total = 0.0
        for s in range(len(log_scale)):
            if terms[s] > highest - 40.0:
                total += np.exp(terms[s] - highest)
        out[n] = highest + np.log(total)
    return out


class PhaseFilter:
    """Sequences of event times, ready to be judged under any parameters.

    Args:
        times_s: (N, E, D) event times minus what is expected, NaN where there is none.
    """

    def __init__(self, times_s: Array) -> None:
        present = np.isfinite(times_s)
        patterns, pattern = np.unique(present, axis=0, return_inverse=True)
        self._patterns, self._pattern = patterns, pattern.reshape(-1)
        self._times = np.where(present, times_s, 0.0)
        self.counts: IntArray = present.sum(axis=(1, 2))
        """(N,) events in each sequence."""

    def evaluate(self, transition: Array, noise: Noise) -> tuple[Array, Array]:
        """(N,) squared distances of the sequences, and (N,) log determinants of their covariances.

        A sequence's log density is ``-(distance + log determinant + count log 2 pi) / 2``; with all noises scaled by s
        it is ``-(distance / s^2 + log determinant + count log(2 pi s^2)) / 2``.

        Args:
            transition: (D, D) own deviations of one event from those of the event before.
            noise: the variances.
        """
        out = _evaluate(
            self._times, self._pattern, self._patterns, np.ascontiguousarray(transition), noise.timekeeper,
            noise.first, noise.motor, float(noise.common), float(noise.correlation),
        )  # fmt: skip
        return out[0], out[1]
