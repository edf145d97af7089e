"""Phase correction gains of an ensemble in free time, by bounded generalised least squares (bGLS).

Each player's own interval is regressed on the asynchronies with every other player before it. The residuals of
neighbouring intervals are correlated, because motor noise lengthens one interval and shortens the next. The estimate
alternates between gains and covariance, with motor noise bounded by timekeeper noise.

Source: jacoby2015, section 3 (bGLS of ensembles). The tempo of the performance, which all players share, is not a
player's noise here: noise is estimated from the residuals less their mean over players. Where the tempo varies more
than the players' own noise, gains are estimated too high, because motor noise then is hard to tell from correction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solveh_banded

from ...core import Array, IntArray
from .tapping_trials import FitError

ROUNDS = 20
"""Alternations between gains and covariance. Source: jacoby2015."""

FEWEST_INTERVALS = 20
"""Fewest intervals of all takes together for each gain of a player to be estimated."""


@dataclass(frozen=True, slots=True)
class EnsembleRegression:
    """Estimates of an ensemble.

    Attributes:
        gains: (P, P) share of the asynchrony with each other player (column) that each player (row) corrects; the
            diagonal is 0.
        errors: (P, P) standard errors of the gains.
        timekeeper_s: standard deviation of a player's timekeeper noise, equal for all [s].
        motor_s: standard deviation of the motor noise [s].
        tempo_s: standard deviation of what the players' residuals have in common beyond their own noise [s].
        intervals: number of intervals of each player.
    """

    gains: Array
    errors: Array
    timekeeper_s: float
    motor_s: float
    tempo_s: float
    intervals: int


@dataclass(frozen=True, slots=True)
class EnsembleIntervals:
    """Intervals of one take between events that everybody performs; E intervals, P players.

    Attributes:
        onsets_s: (E, P) onsets before the intervals [s].
        intervals_s: (E, P) the intervals, less the interval that the tempo suggests [s].
        number: (E,) number of each interval in the take; consecutive intervals have consecutive numbers.
    """

    onsets_s: Array
    intervals_s: Array
    number: IntArray


def regress_ensemble(takes: Sequence[EnsembleIntervals]) -> EnsembleRegression:
    """Estimate gains and noise from several takes of the same players.

    Constant leads of a player and the mean interval of each take are removed.

    Raises:
        FitError: there are fewer than two players, or too few intervals.
    """
    # A single interval is its own mean, and says nothing.
    takes = [take for take in takes if len(take.number) > 1]
    players = takes[0].onsets_s.shape[1] if takes else 0
    count = sum(len(take.number) for take in takes)
    if players < 2 or count < FEWEST_INTERVALS * players:
        raise FitError(
            f"too little to fit: {count} intervals between chords that everybody plays, "
            f"of at least {FEWEST_INTERVALS * max(players, 2)}"
        )

    gains = np.zeros((players, players))
    errors = np.zeros((players, players))
    residuals = np.empty((count, players))
    neighbours = np.concatenate([np.append(np.diff(take.number) == 1, False) for take in takes])[:-1]
    for player in range(players):
        others = np.delete(np.arange(players), player)
        asynchronies = np.concatenate(
            [_centred(take.onsets_s[:, [player]] - take.onsets_s[:, others]) for take in takes]
        )
        intervals = np.concatenate([_centred(take.intervals_s[:, player]) for take in takes])
        slopes, standard_errors = _bounded_regression(asynchronies, intervals, neighbours)
        # A player who is late shortens the next interval, so that gains are the slopes with the other sign.
        gains[player, others] = -slopes
        errors[player, others] = standard_errors
        residuals[:, player] = intervals - asynchronies @ slopes

    # Each player has lost a share of its own noise to the mean, which the factor restores.
    common = residuals.mean(axis=1, keepdims=True)
    factor = players / (players - 1)
    variance, motor_variance = (factor * value for value in _bounded_variances(residuals - common, neighbours))
    return EnsembleRegression(
        gains=gains,
        errors=errors,
        timekeeper_s=float(np.sqrt(max(variance - 2.0 * motor_variance, 0.0))),
        motor_s=float(np.sqrt(motor_variance)),
        tempo_s=float(np.sqrt(max(float((common**2).mean()) - variance / players, 0.0))),
        intervals=count,
    )


def _bounded_regression(asynchronies: Array, intervals: Array, neighbours: Array) -> tuple[Array, Array]:
    """Slopes of a player's intervals on its asynchronies, and their standard errors.

    Args:
        asynchronies: (N, P - 1) with each other player.
        intervals: (N,) following them.
        neighbours: (N - 1,) whether an interval follows the one before without a gap.
    """
    slopes = np.linalg.lstsq(asynchronies, intervals, rcond=None)[0]
    both = np.column_stack([asynchronies, intervals])

    for _ in range(ROUNDS):
        residual = intervals - asynchronies @ slopes
        variance, motor_variance = _bounded_variances(residual[:, None], neighbours)
        # The covariance matrix has two bands: the diagonal, and neighbouring intervals above it.
        bands = np.vstack([np.append(0.0, np.where(neighbours, -motor_variance, 0.0)), np.full(len(both), variance)])

        weighted = asynchronies.T @ solveh_banded(bands, both)
        information = weighted[:, :-1]
        slopes = np.linalg.solve(information, weighted[:, -1])
    return np.asarray(slopes, dtype=np.float64), np.sqrt(np.diag(np.linalg.inv(information)))


def _bounded_variances(residuals: Array, neighbours: Array) -> tuple[float, float]:
    """Variance of residuals, and the motor variance that their correlation shows: at most a third of it.

    Args:
        residuals: (N, P) residuals of intervals.
        neighbours: (N - 1,) whether an interval follows the one before without a gap.
    """
    variance = float((residuals**2).mean())
    products = (residuals[:-1] * residuals[1:])[np.asarray(neighbours, dtype=bool)]
    correlated = -float(products.mean()) if len(products) else 0.0
    # A third of the variance is where motor and timekeeper noise are equal.
    return variance, min(max(correlated, 0.0), variance / 3.0)


def _centred(values: Array) -> Array:
    """Values less their mean over the first axis."""
    return np.asarray(values - values.mean(axis=0))
