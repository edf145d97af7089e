"""Chance level of the group synchronisation index, from surrogate groups that cannot be coordinated.

An index cannot be read without the index of a group that does not coordinate at all, which is far above 0 if everybody
dances the same choreography to the same music. Three kinds of surrogates answer three questions:

- ``pseudo_groups``: every agent comes from another group, in the same iteration. They share music and choreography,
  but have never met. This is the chance level to compare with.
- ``interval_shuffle``: the intervals between an agent's events are put into random order. The first and the last event,
  the order of kinds and the intervals stay; when an event falls in between is lost.
- ``uniform_shift``: an agent's events are shifted along a circle by a random time. All its intervals but one stay; the
  phase to the others and to the music is lost.

To add a surrogate: a function of `EventRows` and a generator that returns the indices of one replication, and a row in
`SURROGATES`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ..anticipation.pair_kernel import pair_indices
from ..core import Array, BoolArray, IntArray
from .event_rows import EventRows

DRAWS = 500
"""Number of surrogate sessions, rounded up to whole replications of the study."""

POINT = 0.95
"""Share of the surrogates that lie below the reported point."""


class Indices(NamedTuple):
    """Group synchronisation indices of N iterations.

    Attributes:
        gsi: (N,) under the paper's edges.
        gsi_full_edges: (N,) under all edges.
        gsi_humans: (N,) of the dancers alone.
    """

    gsi: Array
    gsi_full_edges: Array
    gsi_humans: Array


def group_indices(rows: EventRows, times_us: IntArray, slices: IntArray, robot_edges: BoolArray) -> Indices:
    """Compute the indices of N groups of agents, as `anticipation.synchrony.group_index` does.

    Args:
        rows: gives the kinds of the events, the window and whether there is a robot.
        times_us: (E,) time of each event [us].
        slices: (N, H, 2) first event and the one after the last event of each agent, the robot last.
        robot_edges: (N, D) to which dancers the robot has an edge under the paper's edges; not read without a robot.
    """
    pairs = pair_indices(times_us, rows.kinds, np.ascontiguousarray(slices), rows.tau_us, rows.kind_count)
    agents = pairs.shape[1]
    dancers = agents - 1 if rows.has_robot else agents

    # The product of individual index and connectivity is the sum over the outgoing edges divided by H - 1.
    humans = pairs[:, :dancers, :dancers].sum(axis=(1, 2)) / max(dancers * (dancers - 1), 1)
    full = pairs.sum(axis=(1, 2)) / max(agents * (agents - 1), 1)
    if not rows.has_robot:
        return Indices(full, full, humans)
    left_out = np.where(robot_edges, 0.0, pairs[:, -1, :dancers]).sum(axis=1)
    return Indices(full - left_out / max(agents * (agents - 1), 1), full, humans)


def observed_indices(rows: EventRows) -> Indices:
    """Compute the (R,) indices of the real groups."""
    return group_indices(rows, rows.times_us, rows.slices, rows.robot_edges)


def pseudo_groups(rows: EventRows, rng: np.random.Generator) -> Indices | None:
    """Compute the indices of groups whose agents come from different groups; None with fewer groups than agents.

    A dancer keeps their number, since the robot's edges lead to numbers. As many pseudo-groups are drawn as there are
    groups.

    Args:
        rows: events of one condition.
        rng: draws the groups.
    """
    groups = len(rows.row_of)
    agents = rows.slices.shape[1]
    if groups < agents:
        return None

    donors = rng.integers(0, groups, (groups, agents))
    while True:
        repeated = (np.diff(np.sort(donors, axis=1), axis=1) == 0).any(axis=1)
        if not repeated.any():
            break
        donors[repeated] = rng.integers(0, groups, (int(repeated.sum()), agents))

    # (groups, iterations, agents) rows from which the agents come; a donor without the iteration spoils the group.
    source = rows.row_of[donors].transpose(0, 2, 1).reshape(-1, agents)
    source = source[(source >= 0).all(axis=1)]
    slices = rows.slices[source, np.arange(agents)]
    return group_indices(rows, rows.times_us, slices, rows.robot_edges[source[:, -1]])


def interval_shuffle(rows: EventRows, rng: np.random.Generator) -> Indices:
    """Compute the indices after the intervals between each agent's events are put into random order.

    Args:
        rows: events of one condition.
        rng: draws the order.
    """
    series = rows.series
    first = np.concatenate([[True], series[1:] != series[:-1]])
    intervals = np.diff(rows.times_us, prepend=0)
    intervals[first] = rows.times_us[first]

    # The first event of a series stays; the others are sorted by a random number within the series.
    order = np.lexsort((np.where(first, -1.0, rng.random(len(series))), series))
    total = np.cumsum(intervals[order])
    before = np.repeat((total - intervals)[first], np.diff(np.append(np.flatnonzero(first), len(series))))
    return group_indices(rows, total - before, rows.slices, rows.robot_edges)


def uniform_shift(rows: EventRows, rng: np.random.Generator) -> Indices:
    """Compute the indices after each agent's events are shifted along a circle by a time of their own.

    The circle is as long as the time from the earliest to the latest event of all iterations.

    Args:
        rows: events of one condition.
        rng: draws the shifts.
    """
    start_us = int(rows.times_us.min())
    length_us = int(rows.times_us.max()) - start_us + 1
    shift_us = rng.integers(0, length_us, int(rows.series.max()) + 1)[rows.series]
    shifted = start_us + (rows.times_us - start_us + shift_us) % length_us
    return group_indices(rows, shifted, rows.slices, rows.robot_edges)


SURROGATES: Mapping[str, Callable[[EventRows, np.random.Generator], Indices | None]] = {
    "pseudo_groups": pseudo_groups,
    "interval_shuffle": interval_shuffle,
    "uniform_shift": uniform_shift,
}
"""Name -> indices of one replication of all sessions of a condition."""


def chance_level(rows: EventRows, rng: np.random.Generator, draws: int = DRAWS) -> dict[str, object]:
    """Compute the chance level of every index from every kind of surrogate.

    Args:
        rows: events of one condition.
        rng: draws the surrogates.
        draws: number of surrogate sessions.

    Returns:
        ``observed``, ``mean``, ``p95`` and ``above_p95`` of ``gsi`` and pseudo-groups: the mean index of the real
        iterations and of the surrogate ones, the point below which 95 % of the surrogate iterations lie, and the share
        of real iterations above it. The same for each index and surrogate under ``surrogates``, where a kind that the
        study is too small for is None.
    """
    # Each replication draws as many surrogate sessions as there are real ones.
    observed = observed_indices(rows)
    replications = -(-draws // max(len(rows.row_of), 1))
    by_surrogate: dict[str, dict[str, dict[str, float]] | None] = {}
    for name, surrogate in SURROGATES.items():
        drawn = [surrogate(rows, rng) for _ in range(replications)]
        found = [indices for indices in drawn if indices is not None]
        by_surrogate[name] = _levels(observed, found) if found else None

    undefined = {"observed": float(observed.gsi.mean()), "mean": float("nan"), "p95": float("nan")}
    pseudo = by_surrogate["pseudo_groups"]
    leading = pseudo["gsi"] if pseudo is not None else {**undefined, "above_p95": float("nan")}
    return {**leading, "surrogates": by_surrogate}


def _levels(observed: Indices, drawn: list[Indices]) -> dict[str, dict[str, float]]:
    """Mean and 95 % point of each index over the drawn iterations, beside the observed mean."""
    levels: dict[str, dict[str, float]] = {}
    for index, real in observed._asdict().items():
        values = np.concatenate([getattr(indices, index) for indices in drawn])
        point = float(np.quantile(values, POINT)) if len(values) else float("nan")
        levels[index] = {
            "observed": float(real.mean()),
            "mean": float(values.mean()) if len(values) else float("nan"),
            "p95": point,
            "above_p95": float(np.mean(real > point)),
        }
    return levels
