"""When an event ideally happens, given when the dancers did it, and how far off the robot was.

The same association serves ECA's schedule and the timing appropriateness: each event belongs to the nearest
expected occurrence of its kind, so that one missing event never shifts the ones behind it.

Source: iqbal2016, sections III-B and VI-B.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..core import Array, Kind
from ..core.method_io import Step

BoolArray = NDArray[np.bool_]

EPSILON_S = 1.5
"""Width of a cluster's links [s]; assumed, for iqbal2016 names epsilon without a value: wider than the spread of
dancers who are together, and far below half of the 8.1 s between two events of a kind."""


def match_to_steps(
    times_s: Sequence[float] | Array, kinds: Sequence[str], steps: Sequence[Step], expected_s: Array
) -> Array:
    """One agent's time of each step of an iteration.

    Every event goes to the expected occurrence of its kind that is nearest in time, never by count; where two
    events claim one, the nearer counts (the earlier of two equally near). Kinds that no step has are ignored.

    Args:
        times_s: (N,) event times on the clock of ``expected_s`` [s], in any order.
        kinds: (N,) their kinds; a turn counts as a clap.
        steps: the K steps.
        expected_s: (K,) when each step is expected [s].

    Returns:
        (K,) times [s], NaN where a step has no event.
    """
    found = np.full(len(steps), np.nan)
    ordinals: dict[Kind, list[int]] = {}
    for index, step in enumerate(steps):
        ordinals.setdefault(step.kind, []).append(index)
    order = np.argsort(np.asarray(times_s, dtype=np.float64), kind="stable")
    for place in order:
        time = float(times_s[place])
        kind = Kind.CLAP if kinds[place] == Kind.TURN else Kind(kinds[place])
        candidates = ordinals.get(kind)
        if not candidates:
            continue
        nearest = min(candidates, key=lambda index: abs(float(expected_s[index]) - time))
        if not abs(found[nearest] - expected_s[nearest]) <= abs(time - expected_s[nearest]):
            found[nearest] = time
    return found


def main_cluster(times_s: Array, epsilon_s: float = EPSILON_S) -> BoolArray:
    """Members of the largest cluster under single linkage; of equally large ones the earliest.

    Args:
        times_s: (N,) times [s]; NaN is a member of nothing.
        epsilon_s: largest gap between neighbours of one cluster [s].

    Returns:
        (N,) membership; all False without any time.
    """
    times = np.asarray(times_s, dtype=np.float64)
    member = np.zeros(len(times), dtype=bool)
    order = np.argsort(times, kind="stable")[: int(np.isfinite(times).sum())]
    if len(order) == 0:
        return member
    labels = np.concatenate([[0], np.cumsum(np.diff(times[order]) > epsilon_s)])
    member[order[labels == np.argmax(np.bincount(labels))]] = True
    return member


def ideal_times(dancers_s: Array, epsilon_s: float = EPSILON_S, min_members: int = 1) -> Array:
    """Mean time of the dancers' main cluster for every step.

    Args:
        dancers_s: (D, K) each dancer's time of each step [s], NaN where missing.
        epsilon_s: see `main_cluster`.
        min_members: fewest members a cluster needs.

    Returns:
        (K,) ideal times [s], NaN where the cluster is smaller.

    Source: iqbal2016, section VI-B; means over those present, where the paper divides by three.
    """
    columns = np.asarray(dancers_s, dtype=np.float64).T
    ideal = np.full(len(columns), np.nan)
    for index, column in enumerate(columns):
        member = main_cluster(column, epsilon_s)
        if member.sum() >= max(min_members, 1):
            ideal[index] = column[member].mean()
    return ideal


def timing_appropriateness(robot_s: Array, dancers_s: Array, epsilon_s: float = EPSILON_S) -> Array:
    """TA of every step: how far the robot was from the dancers' mean.

    Args:
        robot_s: (K,) the robot's time of each step [s], NaN where it did not perform it.
        dancers_s: (D, K) the dancers' [s], NaN where missing.
        epsilon_s: see `main_cluster`.

    Returns:
        (K,) absolute differences [s]; NaN where the robot or all dancers missed the step.

    Source: iqbal2016, section VI-B.
    """
    return np.asarray(np.abs(np.asarray(robot_s, dtype=np.float64) - ideal_times(dancers_s, epsilon_s)))
