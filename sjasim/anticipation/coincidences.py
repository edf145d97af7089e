"""Coincidences of events of several agents, and the pairwise synchronisation index that is computed from them.

Times are rounded to whole microseconds before they are compared, so that the result does not depend on floating-point
rounding. A lag of exactly tau does not coincide.

Source: iqbal2016, eqs. (1)-(4), which extend quianquiroga2002.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core import Array, IntArray, Kind
from ..core.errors import ConfigError

Series = tuple[Sequence[float] | Array, Sequence[str]]
"""Events of one agent: (N,) times [s] and (N,) kinds."""

BoolArray = NDArray[np.bool_]

_NO_EVENTS: IntArray = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Coincidences:
    """Pairwise synchrony of H agents over the K kinds of events that occur.

    Attributes:
        kinds: the K kinds.
        by_kind: (H, H, K) synchronisation index Q(e) of each pair for each kind.
        index: (H, H) pairwise synchronisation index Q_xy.
        empty: (H, H) whether neither agent of the pair has an event.
    """

    kinds: tuple[str, ...]
    by_kind: Array
    index: Array
    empty: BoolArray


def microseconds(times_s: Sequence[float] | Array) -> IntArray:
    """Round times to whole microseconds.

    Args:
        times_s: (N,) finite times [s].

    Returns:
        (N,) times [us].

    Raises:
        ConfigError: a time is not finite, or the array has more than one axis.
    """
    times = np.asarray(times_s, dtype=np.float64)
    if times.ndim != 1 or not np.isfinite(times).all():
        raise ConfigError("times", times_s, "a flat sequence of finite seconds")
    return np.rint(times * 1e6).astype(np.int64)


class EncodedEvents(NamedTuple):
    """Events of H agents as arrays for compiled code.

    Attributes:
        times_us: (N,) times of all events [us], agent by agent.
        kinds: (N,) number of each event's kind, from 0.
        slices: (H, 2) first event of each agent, and the one after the last.
        tau_us: two events coincide if they are less than this apart [us].
        kind_count: number of kinds.
    """

    times_us: IntArray
    kinds: IntArray
    slices: IntArray
    tau_us: int
    kind_count: int


def encoded_events(series: Sequence[Series], tau: float) -> EncodedEvents:
    """Convert the events of each of H agents, in any order, to arrays.

    Args:
        series: events of each agent.
        tau: two events coincide if they are less than this apart [s].

    Raises:
        ConfigError: tau is not positive, times are not finite, or times and kinds differ in length.
    """
    if not tau > 0.0:
        raise ConfigError("tau", tau, "a positive number of seconds")

    codes: dict[str, int] = {}
    kinds: list[int] = []
    ends = [0]
    for times_s, names in series:
        if len(times_s) != len(names):
            raise ConfigError("kinds", len(names), f"as many as times: {len(times_s)}")
        # A turn is what the robot does where the dancers clap.
        kinds += [codes.setdefault(Kind.CLAP if name == Kind.TURN else name, len(codes)) for name in names]
        ends.append(len(kinds))

    times = [np.asarray(times_s, dtype=np.float64) for times_s, _ in series]
    times_us = microseconds(np.concatenate([np.zeros(0), *times]))
    slices = np.array([ends[:-1], ends[1:]], dtype=np.int64).T
    return EncodedEvents(times_us, np.array(kinds, dtype=np.int64), slices.copy(), round(tau * 1e6), len(codes))


@dataclass(frozen=True, slots=True)
class _Events:
    """Events of H agents on one time line on which each of K kinds has a separate interval.

    The intervals are more than tau apart. All kinds can therefore be searched at once, because events of different
    kinds never coincide.

    Attributes:
        kinds: the K kinds.
        owner: (N,) index of the agent of each event.
        kind: (N,) index of the kind of each event.
        line_us: (N,) position of each event on the time line [us].
        stride_us: distance between the beginnings of the intervals of two successive kinds [us].
    """

    kinds: tuple[str, ...]
    owner: IntArray
    kind: IntArray
    line_us: IntArray
    stride_us: int


def count_coincidences(series: Sequence[Series], tau: float, one_to_one: bool) -> Coincidences:
    """Count the coincidences of all pairs of agents, and compute their pairwise synchronisation indices.

    Args:
        series: events of each of H agents, in any order.
        tau: two events coincide if they are less than this apart [s].
        one_to_one: match each event at most once, instead of counting every pair of events.

    Returns:
        the indices of all pairs of agents.

    Raises:
        ConfigError: tau is not positive, times are not finite, or times and kinds differ in length.

    Source: iqbal2016, eqs. (1)-(4).
    """
    if not tau > 0.0:
        raise ConfigError("tau", tau, "a positive number of seconds")
    tau_us = round(tau * 1e6)
    events = _on_one_line(series, tau_us)
    agents = len(series)
    kinds = len(events.kinds)
    cells = agents * kinds

    number = np.bincount(events.owner * kinds + events.kind, minlength=cells).reshape(agents, kinds)
    count_function = _count_matches if one_to_one else _count_pairs
    count = count_function(events, agents, tau_us)

    # Q(e): number of coincidences over the geometric mean of the numbers of events. The maximum with 1 avoids 0/0.
    product = number[:, None] * number
    by_kind = count / np.sqrt(np.maximum(product, 1))

    # Q_xy: mean over kinds, weighted by the numbers of events of both agents.
    weight = number[:, None] + number
    total = weight.sum(axis=2)
    index = (by_kind * weight).sum(axis=2) / np.maximum(total, 1)
    return Coincidences(events.kinds, by_kind, index, total == 0)


def _on_one_line(series: Sequence[Series], tau_us: int) -> _Events:
    """Return the events of all agents on one time line; see `_Events`."""
    codes: dict[str, int] = {}
    encoded = [_encode(events, codes) for events in series]
    owner = np.repeat(np.arange(len(series)), [len(times) for times, _ in encoded])
    line_us = np.concatenate([_NO_EVENTS, *(times for times, _ in encoded)])
    kind = np.concatenate([_NO_EVENTS, *(kinds for _, kinds in encoded)])

    stride_us = 1
    if len(line_us):
        stride_us = int(line_us.max() - line_us.min()) + tau_us + 1
        line_us = line_us - line_us.min()
    return _Events(tuple(codes), owner, kind, line_us + stride_us * kind, stride_us)


def _encode(series: Series, codes: dict[str, int]) -> tuple[IntArray, IntArray]:
    """Return times [us] and kind codes of one agent's events; ``codes`` is extended by kinds that it lacks."""
    times_s, kinds = series
    times = microseconds(times_s)
    if len(times) != len(kinds):
        raise ConfigError("kinds", len(kinds), f"as many as times: {len(times)}")
    names = (Kind.CLAP.value if kind == Kind.TURN else str(kind) for kind in kinds)
    return times, np.array([codes.setdefault(name, len(codes)) for name in names], dtype=np.int64)


def _count_pairs(events: _Events, agents: int, tau_us: int) -> Array:
    """(H, H, K) number of pairs of events less than tau apart.

    This is the sum c(x|y) + c(y|x) of eqs. (1) and (2). A positive lag contributes 1 to one term, and a lag of 0
    contributes 1/2 to each, so that every pair contributes 1 to the sum.
    """
    kinds = len(events.kinds)
    cells = agents * kinds
    count = np.zeros((agents, agents, kinds))
    for agent in range(agents):
        train = np.sort(events.line_us[events.owner == agent])
        first = train.searchsorted(events.line_us - tau_us, "right")
        after_last = train.searchsorted(events.line_us + tau_us, "left")
        inside = after_last - first
        count[:, agent] = np.bincount(events.owner * kinds + events.kind, inside, cells).reshape(agents, kinds)
    return count


def _count_matches(events: _Events, agents: int, tau_us: int) -> Array:
    """(H, H, K) size of the maximum one-to-one matching of events less than tau apart."""
    kinds = len(events.kinds)
    trains = [np.sort(events.line_us[events.owner == agent]) for agent in range(agents)]
    count = np.zeros((agents, agents, kinds))
    for i, j in combinations(range(agents), 2):
        matched = np.array(_match(trains[i].tolist(), trains[j].tolist(), tau_us), dtype=np.int64)
        # The interval of the time line that contains an event is the index of its kind.
        of_kind = np.bincount(matched // events.stride_us, minlength=kinds)
        count[i, j] = of_kind
        count[j, i] = of_kind
    return count


def _match(x: list[int], y: list[int], tau_us: int) -> list[int]:
    """Times of x in a maximum one-to-one matching of sorted times less than tau apart.

    The greedy choice of the earliest possible partner is optimal for sorted times and a constant tau.
    """
    i = 0
    j = 0
    matched: list[int] = []
    while i < len(x) and j < len(y):
        lag = x[i] - y[j]
        if abs(lag) < tau_us:
            matched.append(x[i])
            i += 1
            j += 1
        elif lag > 0:
            j += 1
        else:
            i += 1
    return matched
