"""Likelihood of event times under linear phase correction, from a Kalman filter over the events of each sequence.

The state has every timekeeper's deviation and the group's common shift; an observed event is the sum of the two plus
motor noise. Dancers correct observed events: those that are in the data enter the next state as a known input, and only
the motor noise of missing ones adds to the state's noise. The gains depend only on which events are missing, so they
are computed once for every pattern of missing events, and not for every sequence.

Source: jacoby2015, section 2 (the ensemble as a linear model). The state-space form and its likelihood are standard.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core import Array, BoolArray, IntArray
from ...core.compiled import compiled_entry, compiled_inner


class Noise(NamedTuple):
    """Noise of the model; variances are in the square of the data's unit.

    Attributes:
        timekeeper: (D,) variance that each event adds to the timekeepers' deviations.
        first: (D,) variance of the timekeepers' deviations at the first event of a sequence.
        motor: (D,) variance of the motor noise.
        tempo: variance that each event adds to all deviations alike.
        common: variance of the common shift.
        correlation: correlation of the common shift between successive events.
        rate: 0 for a common shift of the events; 1 if it is a rate, by which all deviations grow at every event, and
            the first deviations have a common part of the same variance.
    """

    timekeeper: Array
    first: Array
    motor: Array
    tempo: float
    common: float
    correlation: float
    rate: float = 0.0


@compiled_inner
def _step(present: BoolArray, phase: Array, rho: float, rate: float) -> Array:
    """(D + 1, D + 1) state at one event from that at the event before, without known input.

    What a dancer corrects at the event before is the observed event less the common shift or, where there is no
    observed event, the deviation itself.

    Args:
        present: (D,) which events there are at the event before.
        phase: (D, D) as in `_gains`.
        rho: as in `_gains`.
        rate: as in `_gains`.
    """
    dancers = len(phase)
    step = np.zeros((dancers + 1, dancers + 1))
    step[dancers, dancers] = rho

    for i in range(dancers):
        step[i, i] = 1.0
        step[i, dancers] = rate
        for j in range(dancers):
            if present[j]:
                step[i, dancers] += (1.0 - rate) * phase[i, j]
            else:
                step[i, j] -= phase[i, j]
    return step


@compiled_inner
def _gains(
    present: BoolArray, phase: Array, timekeeper: Array, first: Array, motor: Array, tempo: float, common: float,
    rho: float, rate: float,
) -> tuple[Array, Array]:  # fmt: skip
    """(E, D, D + 1) gain of each event and (E, D) variance of its innovation, for one pattern of missing events.

    Args:
        present: (E, D) which events there are.
        phase: (D, D) share of each observed deviation (column) that each dancer (row) corrects.
        timekeeper: (D,) see `Noise`.
        first: (D,) see `Noise`.
        motor: (D,) see `Noise`.
        tempo: see `Noise`.
        common: see `Noise`.
        rho: correlation of the common shift, see `Noise`.
        rate: see `Noise`.
    """
    events, dancers = present.shape
    size = dancers + 1
    gains = np.zeros((events, dancers, size))
    variances = np.ones((events, dancers))

    # The last entry of the state is the common shift.
    covariance = np.zeros((size, size))

    for e in range(events):
        # Prediction; the noise of the common shift keeps its variance stationary.
        if e == 0:
            for i in range(dancers):
                covariance[i, i] = first[i]
                # With a rate, the time of the first event is as free as the rate.
                for j in range(dancers):
                    covariance[i, j] += rate * common
            covariance[dancers, dancers] = common
        else:
            step = _step(present[e - 1], phase, rho, rate)
            covariance = step @ covariance @ step.T
            for i in range(dancers):
                covariance[i, i] += timekeeper[i]
                for j in range(dancers):
                    covariance[i, j] += tempo
            # Motor noise that the data do not show, but that the dancers correct.
            for j in range(dancers):
                if not present[e - 1, j]:
                    for a in range(dancers):
                        for b in range(dancers):
                            covariance[a, b] += phase[a, j] * phase[b, j] * motor[j]
            covariance[dancers, dancers] += common * (1.0 - rho * rho)

        # Update with one event after the other: their motor noises are independent.
        for i in range(dancers):
            if not present[e, i]:
                continue
            column = covariance[:, i] + (1.0 - rate) * covariance[:, dancers]
            variance = column[i] + (1.0 - rate) * column[dancers] + motor[i]
            gains[e, i] = column / variance
            variances[e, i] = variance
            for a in range(size):
                for b in range(size):
                    covariance[a, b] -= gains[e, i, a] * column[b]

    return gains, variances


@compiled_inner
def _squared_distance(
    times: Array, present: BoolArray, gains: Array, variances: Array, phase: Array, rho: float, rate: float
) -> float:
    """Sum of the squared innovations of one sequence, each over its variance; arguments as in `_gains`."""
    events, dancers = present.shape
    state = np.zeros(dancers + 1)
    predicted = np.zeros(dancers + 1)
    total = 0.0

    for e in range(events):
        if e:
            for i in range(dancers):
                predicted[i] = state[i] + rate * state[dancers]
                for j in range(dancers):
                    observed = times[e - 1, j] - (1.0 - rate) * state[dancers] if present[e - 1, j] else state[j]
                    predicted[i] -= phase[i, j] * observed
            predicted[dancers] = rho * state[dancers]
            state[:] = predicted

        for i in range(dancers):
            if present[e, i]:
                innovation = times[e, i] - state[i] - (1.0 - rate) * state[dancers]
                total += innovation * innovation / variances[e, i]
                for a in range(dancers + 1):
                    state[a] += gains[e, i, a] * innovation

    return total


@compiled_entry
def _evaluate(
    times: Array, pattern: IntArray, patterns: BoolArray, phase: Array, timekeeper: Array, first: Array,
    motor: Array, tempo: float, common: float, rho: float, rate: float,
) -> tuple[Array, Array]:  # fmt: skip
    """(N,) squared distances and (N,) log determinants of all sequences; an impossible variance gives infinity.

    Args:
        times: (N, E, D) event times; missing ones have any finite value.
        pattern: (N,) index into ``patterns`` of each sequence.
        patterns: (P, E, D) which events there are.
        phase: (D, D) as in `_gains`, like the arguments that follow.
        timekeeper: (D,).
        first: (D,).
        motor: (D,).
        tempo: variance common to all deviations.
        common: variance of the common shift.
        rho: its correlation.
        rate: whether it is a rate.
    """
    distance = np.zeros(len(times))
    log_det = np.zeros(len(times))

    for p in range(len(patterns)):
        gains, variances = _gains(patterns[p], phase, timekeeper, first, motor, tempo, common, rho, rate)
        log_sum = np.log(variances).sum() if variances.min() > 0.0 else np.inf
        for n in range(len(times)):
            if pattern[n] == p:
                log_det[n] = log_sum
                distance[n] = _squared_distance(times[n], patterns[p], gains, variances, phase, rho, rate)

    return distance, log_det


@compiled_entry
def log_mixture(distance: Array, counts: IntArray, log_scale: Array, log_weight: Array) -> Array:
    """(N,) log densities of sequences whose noise has a random scale, without determinants and constants.

    Args:
        distance: (N,) squared distances at scale 1.
        counts: (N,) number of events in each sequence.
        log_scale: (S,) logarithms of the scales.
        log_weight: (S,) logarithms of their probabilities.
    """
    inverse_square = np.exp(-2.0 * log_scale)
    result = np.empty(len(distance))
    terms = np.empty(len(log_scale))

    for n in range(len(distance)):
        highest = -np.inf
        for s in range(len(log_scale)):
            terms[s] = log_weight[s] - counts[n] * log_scale[s] - 0.5 * distance[n] * inverse_square[s]
            highest = max(highest, terms[s])

        # Terms below the highest by 40 are less than its last digit.
        total = 0.0
        for s in range(len(log_scale)):
            if terms[s] > highest - 40.0:
                total += np.exp(terms[s] - highest)
        result[n] = highest + np.log(total)

    return result


class PhaseFilter:
    """Sequences of event times, prepared for evaluating their likelihood under many parameters.

    Args:
        times_s: (N, E, D) event times minus their expectation; NaN where there is no event.
    """

    def __init__(self, times_s: Array) -> None:
        present = np.isfinite(times_s)
        patterns, pattern = np.unique(present, axis=0, return_inverse=True)
        self._patterns = patterns
        self._pattern = pattern.reshape(-1)
        # The filter skips missing events by their pattern; a NaN would spread through its arithmetic.
        self._times = np.where(present, times_s, 0.0)
        self.counts: IntArray = present.sum(axis=(1, 2))
        """(N,) number of events in each sequence."""

    def evaluate(self, phase: Array, noise: Noise) -> tuple[Array, Array]:
        """(N,) squared distances of the sequences, and (N,) log determinants of their covariances.

        The log density of a sequence of n events is ``-(distance + log determinant + n log 2 pi) / 2``. With all noises
        scaled by s it is ``-(distance / s^2 + log determinant + n log(2 pi s^2)) / 2``.

        Args:
            phase: (D, D) share of each observed deviation (column) that each dancer (row) corrects; its rows add up to
                0, so that what is common to all is not corrected.
            noise: the model's noise.
        """
        distance, log_det = _evaluate(
            self._times, self._pattern, self._patterns, np.ascontiguousarray(phase), noise.timekeeper,
            noise.first, noise.motor, float(noise.tempo), float(noise.common), float(noise.correlation),
            float(noise.rate),
        )  # fmt: skip
        return distance, log_det
