"""Arranges the events of people without music: which events belong together, and when they are to be expected."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...core import Array, Kind
from ...core.session_log import TableEvent
from .tapping_trials import FitError, finite_mean

LARGEST_TEMPO_RATIO = 1.25
"""Ratio of two dancers' tempi beyond which their events do not correspond one to one (assumed)."""

LOOSEST_SHARE = 0.12
"""Distance of dancers, over the time between two events, beyond which they may not be together at all.

Dancers who do not hear one another are 0.14 to 0.18 apart, groups with weak coupling less than 0.12 (measured on
simulated groups).
"""

FEWEST_INTERVALS = 5
"""Fewest intervals between a dancer's events that give a tempo (assumed).

With fewer intervals, one omitted step would look like another tempo.
"""

IRREGULAR = 0.3
"""Distance of an interval from whole periods, over a period, that a steady tempo does not have (assumed)."""

FEWEST_FOR_SCORE = 3
"""Fewest trials of the same events whose mean intervals count as the score's (assumed)."""

PACER_SHARE = 0.1
"""Irregularity of a pacer, over that of the most regular other dancer, at most (assumed)."""

FEWEST_FOR_PACER = 10
"""Fewest pairs of successive intervals that tell a pacer from a person (assumed)."""

DancersEvents = Mapping[str, Sequence[TableEvent]]
"""Dancer -> events of one trial."""

Label = tuple[Kind, int]
"""Kind of an event, and how many events of the kind come before it in its trial."""


class FreeTrial(NamedTuple):
    """One trial without music.

    Attributes:
        labels: of its E events, in order of time.
        times_s: (E, D) event times [s]; NaN for an absent dancer.
        share: mean distance of the dancers from their mean, over the usual time between two events of a kind.
    """

    labels: tuple[Label, ...]
    times_s: Array
    share: float


def cluster_trial(trial: DancersEvents, cast: Sequence[str]) -> FreeTrial:
    """The events of one trial that belong together: of one kind and different dancers, close in time.

    Close is within half of the usual interval between two events of one dancer.

    Raises:
        FitError: the dancers' tempi differ by more than `LARGEST_TEMPO_RATIO`.
    """
    rows: list[tuple[Label, Array]] = []
    distances = []
    for kind in Kind:
        clusters = _clusters(trial, cast, kind)
        rows += [((kind, k), cluster) for k, cluster in enumerate(clusters)]
        times_s = np.array(clusters).reshape(-1, len(cast))
        distances.append((times_s - finite_mean(times_s, 1)[:, None]).ravel() / _usual_interval_s(trial, kind))

    rows.sort(key=lambda row: float(np.nanmean(row[1])))
    share = float(np.sqrt(finite_mean(np.concatenate(distances) ** 2, 0)))
    return FreeTrial(
        tuple(label for label, _ in rows), np.array([row for _, row in rows]).reshape(-1, len(cast)), share
    )


def looseness_warnings(trials: Sequence[FreeTrial]) -> tuple[str, ...]:
    """A warning if dancers are so far apart that the assignment of events, and with it the coupling, may be chance."""
    counts = [trial.times_s.size for trial in trials]
    share = float(np.sqrt(np.average([trial.share**2 for trial in trials], weights=counts)))
    if not share > LOOSEST_SHARE:
        return ()
    distance = f"dancers are {share:.2f} of the time between two events apart, not within {LOOSEST_SHARE:g}"
    return (f"{distance}: which events belong together may be chance, and coupling with it",)


def late_at_steady_tempo(trial: FreeTrial) -> Array:
    """(E, D) lateness behind a steady tempo from the group's first event to its last [s], on a grid of its periods.

    Periods in which nobody has an event are rows of NaN.

    Raises:
        FitError: the intervals between the group's events are not whole numbers of periods.
    """
    mean_s = finite_mean(trial.times_s, 1)
    intervals_s = np.diff(mean_s)
    if not len(intervals_s):
        return np.zeros_like(trial.times_s)

    period_s = float(np.median(intervals_s))
    periods = np.rint(intervals_s / period_s)
    if np.abs(intervals_s / period_s - periods).max() > IRREGULAR or periods.min() < 1:
        shortest, longest = float(intervals_s.min()), float(intervals_s.max())
        raise FitError(
            f"the tempo is not steady: intervals are {shortest:.2f} to {longest:.2f} s, not multiples of "
            f"{period_s:.2f} s; fit in free time (--time free)"
        )

    beat = np.concatenate([[0.0], np.cumsum(periods)])
    expected_s = mean_s[0] + (mean_s[-1] - mean_s[0]) * beat / beat[-1]
    late_s = np.full((int(beat[-1]) + 1, trial.times_s.shape[1]), np.nan)
    late_s[beat.astype(int)] = trial.times_s - expected_s[:, None]
    return late_s


def late_behind_score(trials: Sequence[FreeTrial]) -> list[Array] | None:
    """(E, D) lateness of each trial behind the mean intervals of all trials [s], or None if these are not comparable.

    Trials are comparable if there are `FEWEST_FOR_SCORE` of the same events in the same order. Each trial has a tempo
    of its own, by which the mean intervals are stretched.
    """
    if len(trials) < FEWEST_FOR_SCORE or len({trial.labels for trial in trials}) > 1 or len(trials[0].labels) < 2:
        return None

    mean_s = np.array([finite_mean(trial.times_s, 1) for trial in trials])
    intervals_s = np.diff(mean_s, axis=1)
    length_s = intervals_s.sum(axis=1, keepdims=True)
    score = (intervals_s / length_s).mean(axis=0)
    expected_s = np.concatenate([np.zeros((len(trials), 1)), np.cumsum(score * length_s, axis=1)], axis=1)
    return [trial.times_s - (mean_s[n, 0] + expected_s[n])[:, None] for n, trial in enumerate(trials)]


def late_behind_group(trial: FreeTrial) -> Array:
    """(E, D) lateness behind the mean of the events that belong together [s]."""
    return np.asarray(trial.times_s - finite_mean(trial.times_s, 1)[:, None])


def find_pacers(trials: Sequence[FreeTrial]) -> tuple[int, ...]:
    """Indices of dancers who keep exact time whatever the others do, such as a metronome.

    A pacer's successive intervals differ far less than anybody else's. The comparison is by changes of the interval, so
    that a tempo that drifts slowly does not count.
    """
    changes_s = np.concatenate([np.diff(trial.times_s, n=2, axis=0) for trial in trials])
    enough = np.isfinite(changes_s).sum(axis=0) >= FEWEST_FOR_PACER
    if not enough.all():
        return ()

    irregularity_s = np.sqrt(finite_mean(changes_s**2, 0))
    order = np.argsort(irregularity_s)
    # At least one person remains; everybody before the first large step is a pacer.
    for count in range(len(order) - 1, 0, -1):
        if irregularity_s[order[count - 1]] <= PACER_SHARE * irregularity_s[order[count]]:
            return tuple(sorted(int(k) for k in order[:count]))
    return ()


def _usual_interval_s(trial: DancersEvents, kind: Kind) -> float:
    """Usual time between two events of a kind of one dancer [s]; infinite if no dancer has two.

    Raises:
        FitError: the dancers' tempi differ by more than `LARGEST_TEMPO_RATIO`.
    """
    times = {agent: [event.t_s for event in own if event.kind is kind] for agent, own in trial.items()}
    intervals = {agent: float(np.median(np.diff(own))) for agent, own in times.items() if len(own) > 1}
    if not intervals:
        return np.inf

    reliable = {agent: interval for agent, interval in intervals.items() if len(times[agent]) > FEWEST_INTERVALS}
    if reliable:
        slowest = max(reliable, key=lambda agent: reliable[agent])
        fastest = min(reliable, key=lambda agent: reliable[agent])
        if reliable[slowest] > LARGEST_TEMPO_RATIO * reliable[fastest]:
            tempi = f"every {reliable[fastest]:.2f} s, {slowest}'s every {reliable[slowest]:.2f} s"
            raise FitError(f"{fastest}'s {kind} comes {tempi}: they do not correspond one to one, and are not fitted")

    return float(np.median(list(intervals.values())))


def _clusters(trial: DancersEvents, cast: Sequence[str], kind: Kind) -> list[Array]:
    """(D,) times of the events of a kind that belong together [s], for each such cluster; NaN for an absent dancer."""
    events = sorted((event for own in trial.values() for event in own if event.kind is kind), key=lambda e: e.t_s)
    window_s = 0.5 * _usual_interval_s(trial, kind)

    clusters: list[Array] = []
    first_s = -np.inf
    for event in events:
        column = cast.index(event.agent)
        if not clusters or event.t_s - first_s > window_s or np.isfinite(clusters[-1][column]):
            clusters.append(np.full(len(cast), np.nan))
            first_s = event.t_s
        clusters[-1][column] = event.t_s
    return clusters
