"""Timing appropriateness: ideal time of each step from the dancers' event times, and the robot's deviation from it.

ECA's schedule and the timing appropriateness assign events to steps in the same way: an event belongs to the step of
its kind whose expected time is nearest, so that one missing event does not shift the ones after it.

Source: iqbal2016, sections III-B and VI-B.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..core import Array, Kind
from ..core.method_io import Step
from .coincidences import BoolArray

EPSILON_S = 1.5
"""Largest gap between neighbouring times of one cluster [s].

Assumed, since iqbal2016 gives no value for epsilon: wider than the spread of dancers who are together, and far below
half of the 8.1 s between two events of a kind.
"""


def match_to_steps(
    times_s: Sequence[float] | Array, kinds: Sequence[str], steps: Sequence[Step], expected_s: Array
) -> Array:
    """Assign an agent's events to the steps of an iteration.

    Every event is assigned to the step of its kind whose expected time is nearest, independently of the number of
    events before it. If several events are assigned to one step, the nearest one is kept, and of two equally near ones
    the earlier. Events of a kind that no step has are ignored.

    Args:
        times_s: (N,) event times on the clock of ``expected_s`` [s], in any order.
        kinds: (N,) their kinds; a turn counts as a clap.
        steps: the K steps.
        expected_s: (K,) when each step is expected [s].

    Returns:
        (K,) times [s], NaN where a step has no event.
    """
    # Lists, because an iteration has a few steps only, for which NumPy's calls would take longer than the work.
    expected = [float(value) for value in expected_s]
    matched_s = [math.nan] * len(steps)
    steps_of: dict[str, list[int]] = {}
    for index, step in enumerate(steps):
        steps_of.setdefault(step.kind, []).append(index)

    for time_s, name in sorted(zip(map(float, times_s), kinds, strict=True), key=lambda event: event[0]):
        kind = Kind.CLAP if name == Kind.TURN else name
        candidates = steps_of.get(kind)
        if not candidates:
            continue

        nearest = min(candidates, key=lambda index: abs(expected[index] - time_s))
        # Written with "not" so that a step without an event yet, NaN, takes this one.
        if not abs(matched_s[nearest] - expected[nearest]) <= abs(time_s - expected[nearest]):
            matched_s[nearest] = time_s

    return np.array(matched_s)


def main_cluster(times_s: Array, epsilon_s: float = EPSILON_S) -> BoolArray:
    """Find the members of the largest cluster under single linkage, or of the earliest of several equally large ones.

    Args:
        times_s: (N,) times [s]; NaN belongs to no cluster.
        epsilon_s: largest gap between neighbouring times of one cluster [s].

    Returns:
        (N,) membership; all False if no time is finite.

    Source: iqbal2016, section III-B, which does not name the clustering method.
    """
    member = np.zeros(len(times_s), dtype=bool)
    member[_main_cluster(np.asarray(times_s, dtype=np.float64).tolist(), epsilon_s)] = True
    return member


def _main_cluster(times_s: list[float], epsilon_s: float) -> list[int]:
    """Indices of the members of the main cluster, in order; see `main_cluster`."""
    order = sorted((index for index, time_s in enumerate(times_s) if not math.isnan(time_s)), key=times_s.__getitem__)

    largest: list[int] = []
    cluster: list[int] = []
    for index in order:
        if cluster and times_s[index] - times_s[cluster[-1]] > epsilon_s:
            cluster = []
        cluster.append(index)
        # Of equally large clusters the earliest stays.
        if len(cluster) > len(largest):
            largest = cluster
    return sorted(largest)


def ideal_times(dancers_s: Array, epsilon_s: float = EPSILON_S, min_members: int = 1) -> Array:
    """Compute the mean time of the dancers' main cluster for every step.

    Args:
        dancers_s: (D, K) each dancer's time of each step [s], NaN where missing.
        epsilon_s: see `main_cluster` [s].
        min_members: smallest number of members for which a mean is computed.

    Returns:
        (K,) ideal times [s], NaN where the cluster is smaller.

    Source: iqbal2016, section VI-B. The mean is taken over the detected dancers; the paper divides by 3.
    """
    columns = np.asarray(dancers_s, dtype=np.float64).T.tolist()
    ideal_s = np.full(len(columns), np.nan)
    for index, column in enumerate(columns):
        members = _main_cluster(column, epsilon_s)
        if len(members) >= max(min_members, 1):
            ideal_s[index] = sum(column[member] for member in members) / len(members)
    return ideal_s


def lateness(robot_s: Array, dancers_s: Array, epsilon_s: float = EPSILON_S) -> Array:
    """Compute how late the robot is in every step: its time minus the dancers' mean time.

    The absolute value is the timing appropriateness (TA) of the step.

    Args:
        robot_s: (K,) the robot's time of each step [s], NaN where it did not perform it.
        dancers_s: (D, K) each dancer's time of each step [s], NaN where missing.
        epsilon_s: see `main_cluster` [s].

    Returns:
        (K,) differences, negative where the robot is early [s]; NaN where the robot or all dancers missed the step.

    Source: iqbal2016, section VI-B, which takes the absolute value.
    """
    return np.asarray(robot_s, dtype=np.float64) - ideal_times(dancers_s, epsilon_s)
