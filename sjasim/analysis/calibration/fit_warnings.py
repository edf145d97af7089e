"""Reservations about a fit: what its user should know before trusting it, a sentence each."""

from __future__ import annotations

import numpy as np

from ...core import Array
from .tapping_trials import TappingTrials, finite_mean
from .timing_likelihood import TimingLikelihood

FEW_EVENTS = 100
"""Events of each person below which estimates are reported as uncertain (assumed).

With 120 events of each of three people, the mean estimate of the motor noise was 9 % too small
(scripts/check_recovery.py).
"""

SAME_PERFORMANCE = 0.9
"""Correlation of two trials' changes of lateness from which they are taken for one performance (assumed)."""

FEWEST_CHANGES = 12
"""Fewest changes of lateness for such a correlation; fewer could be alike by chance (assumed)."""

WIDE = 1.5
"""Width of an interval of coupling, over the fitted gain, beyond which data in free time are said to leave it open."""


def fit_warnings(likelihood: TimingLikelihood, vector: Array, intervals: Array) -> tuple[str, ...]:
    """Reservations about a fit.

    Those of the data come first, then few events, repeated performances and pacers, entries on their bounds, wide
    intervals, and too few sessions. A noise or gain of 0 is a result, not a reservation.

    Args:
        likelihood: of the trials.
        vector: (P,) fitted entries.
        intervals: (P, 2) ends of their intervals.
    """
    trials = likelihood.trials
    found = [*trials.warnings, *_about_data(trials)]
    lower, upper = np.array(likelihood.bounds()).T
    at_lower = np.isclose(vector, lower, rtol=1e-4, atol=1e-9)
    at_upper = np.isclose(vector, upper, rtol=1e-4, atol=1e-9)
    on_bound = at_upper | (at_lower & (lower != 0.0))
    low, high = intervals.T
    undetermined = (low <= lower) & (high >= upper)

    for flags, text in (
        (on_bound, "on the bounds of what is fitted, and say little"),
        (undetermined, "not determined by these data, with intervals from bound to bound"),
    ):
        names = [name for name, flag in zip(likelihood.names, flags, strict=True) if flag]
        if names:
            found.append(f"{text}: {', '.join(names)}")

    found += _about_coupling(likelihood, vector, high - low)
    if (likelihood.matrix or likelihood.each) and len(set(trials.session.tolist())) == 1:
        found.append("one session is too little to tell people apart: give several of the same people")
    return tuple(found)


def _about_coupling(likelihood: TimingLikelihood, vector: Array, width: Array) -> list[str]:
    """Reservations about a single gain; empty for a matrix."""
    if likelihood.matrix:
        return []

    entry = likelihood.names.index("coupling")
    found = []
    if vector[entry] < 0.0:
        found.append("the fitted coupling is negative, people drive one another apart; they are simulated without any")
    if likelihood.trials.time == "free" and width[entry] > WIDE * abs(vector[entry]):
        found.append("in free time these data leave the coupling open; if the tempo is steady, fit with --time steady")
    return found


def _about_data(trials: TappingTrials) -> list[str]:
    """Reservations about the trials: few events, the same performance twice, and pacers."""
    found = []
    events = int(np.isfinite(trials.late_s).any(axis=2).sum())
    if events < FEW_EVENTS:
        found.append(
            f"only {events} events of each person, fewer than {FEW_EVENTS}: gains and noise may come out distorted"
        )

    pairs = same_performances(trials)
    if pairs:
        first, second = pairs[0]
        found.append(
            f"trials {first + 1} and {second + 1} ({len(pairs)} such pairs) are takes of one performance, in which "
            "people move alike: they count as independent, so the intervals are too narrow"
        )
    if trials.pacers:
        names = ", ".join(trials.agents[k] for k in trials.pacers)
        found.append(f"taken for an exact pacer, such as a metronome, without noise or correction: {names}")
    return found


def same_performances(trials: TappingTrials) -> list[tuple[int, int]]:
    """Pairs of trials in which the same dancers deviate alike from event to event: two takes of one performance."""
    late_s = trials.late_s - finite_mean(trials.late_s, 2)[..., None]
    changes = np.diff(late_s, axis=1).reshape(len(late_s), -1)
    present = np.isfinite(changes)
    # Dancers' changes add up to 0, so one of them says nothing new.
    enough = present.astype(float) @ present.T.astype(float) >= FEWEST_CHANGES * 1.5

    changes = np.where(present, changes, 0.0)
    size = np.sqrt((changes**2).sum(axis=1))
    size[size == 0.0] = np.inf
    alike = (changes @ changes.T / np.outer(size, size) > SAME_PERFORMANCE) & enough
    return [(int(i), int(j)) for i, j in np.argwhere(np.triu(alike, 1))]
