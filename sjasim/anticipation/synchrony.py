"""The paper's synchrony equations, pure: pair, individual and group index, and the most synchronous person.

Times are compared in whole microseconds, so that a tie is a tie and a lag of exactly tau is outside. Early
events are no part of any index; callers leave them out. A turn counts as a clap. Any unit of time origin will do,
as only differences enter.

Source: iqbal2016, eqs. (1)-(6), (10), (11); the pairwise index extends quianquiroga2002.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ..core import ROBOT, Array, IntArray, Kind
from ..core.errors import ConfigError

Series = tuple[Sequence[float] | Array, Sequence[str]]
"""One agent's events: times [s] and, of the same length, kinds."""

BoolArray = NDArray[np.bool_]

TIE = 1e-9
"""Individual indices this close are tied (rounding, not evidence)."""


@dataclass(frozen=True, slots=True)
class PairSynchrony:
    """How synchronous two series are.

    Attributes:
        index: Q_xy; 0 where no event is left to compare. Bursts of one kind closer than tau can lift it above 1.
        by_kind: Q(e) of every kind that occurs in either series.
        empty: whether neither series had an event, so that ``index`` says nothing.
    """

    index: float
    by_kind: Mapping[str, float]
    empty: bool


@dataclass(frozen=True, slots=True)
class GroupSynchrony:
    """The group topology graph of one iteration and what follows from it.

    Attributes:
        agents: the vertices, in the order of all arrays.
        pairs: (H, H) pair indices, symmetric, 0 on the diagonal.
        edges: (H, H) whether an edge leads from row to column.
        individual: (H,) mean weight of the outgoing edges; 0 for an agent without any.
        connectivity: (H,) out-degree / (H - 1).
        gsi: the group synchronisation index.
        empty_pairs: pairs in which neither agent had an event; their index of 0 is no evidence.
    """

    agents: tuple[str, ...]
    pairs: Array
    edges: BoolArray
    individual: Array
    connectivity: Array
    gsi: float
    empty_pairs: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class MostSynchronous:
    """The choice of the person to follow.

    Attributes:
        person: the most synchronous one.
        tied: everyone who shared the highest individual index, in the order of the cast; one name if no tie.
        individual: individual indices in the order of the cast.
    """

    person: str
    tied: tuple[str, ...]
    individual: Array


def microseconds(times_s: Sequence[float] | Array) -> IntArray:
    """Times rounded to whole microseconds.

    Args:
        times_s: (N,) finite times [s].

    Raises:
        ConfigError: a time is not finite, or the array has more than one axis.
    """
    times = np.asarray(times_s, dtype=np.float64)
    if times.ndim != 1 or not np.isfinite(times).all():
        raise ConfigError("times", times_s, "a flat sequence of finite seconds")
    return np.rint(times * 1e6).astype(np.int64)


def pair_synchrony(a: Series, b: Series, tau: float = 0.25, one_to_one: bool = False) -> PairSynchrony:
    """Q_xy of two series with its parts.

    A kind that only one series has gets Q(e) = 0 and keeps its weight, for a missing event is a failure; a kind
    that neither has does not count; with no kind left the index is 0 and ``empty`` is set.

    Args:
        a: times [s] and kinds of one agent, in any order.
        b: the same of the other.
        tau: strict window of a coincidence [s].
        one_to_one: match each event at most once (largest matching), which bounds Q by 1; the printed equation,
            which counts every pair of events within tau, does not.

    Raises:
        ConfigError: tau is not positive, times are not finite, or times and kinds differ in length.

    Source: iqbal2016, eqs. (1)-(4).
    """
    counted = _count((a, b), tau, one_to_one)
    by_kind = dict(zip(counted.kinds, counted.synchrony[0, 1].tolist(), strict=True))
    return PairSynchrony(float(counted.index[0, 1]), by_kind, bool(counted.empty[0, 1]))


def pair_index(
    times_a: Sequence[float] | Array,
    kinds_a: Sequence[str],
    times_b: Sequence[float] | Array,
    kinds_b: Sequence[str],
    tau: float = 0.25,
    one_to_one: bool = False,
) -> float:
    """Pairwise synchronisation index Q_xy of two agents' events; `pair_synchrony` gives its parts too.

    Args:
        times_a: (N,) times of one agent's events [s], in any order.
        kinds_a: (N,) their kinds.
        times_b: (M,) times of the other's [s].
        kinds_b: (M,) their kinds.
        tau: strict window of a coincidence [s] (iqbal2016: .25).
        one_to_one: bounded variant, see `pair_synchrony`.

    Returns:
        0 for no synchrony (or no events at all), 1 for full synchrony; dense trains can exceed 1.

    Source: iqbal2016, eq. (4).
    """
    return pair_synchrony((times_a, kinds_a), (times_b, kinds_b), tau, one_to_one).index


def individual_index(pairs: Array, edges: BoolArray | None = None) -> Array:
    """Mean weight of every agent's outgoing edges.

    Args:
        pairs: (H, H) pair indices; the diagonal is ignored.
        edges: (H, H) whether an edge leads from row to column; None for the full graph.

    Returns:
        (H,) individual indices; 0 for an agent without outgoing edges.

    Source: iqbal2016, eqs. (5), (6).
    """
    out = _out_edges(len(pairs), edges)
    degrees = out.sum(axis=1)
    sums = np.where(out, pairs, 0.0).sum(axis=1)
    return np.asarray(np.divide(sums, degrees, out=np.zeros(len(pairs)), where=degrees > 0))


def connectivity(edges: BoolArray) -> Array:
    """Out-degree of every agent over the H - 1 possible edges; 0 for a group of one.

    Source: iqbal2016, eq. (10).
    """
    out = _out_edges(len(edges), edges)
    return np.asarray(out.sum(axis=1) / max(len(edges) - 1, 1), dtype=np.float64)


def group_index(
    series: Mapping[str, Series],
    edges: str = "paper",
    *,
    follows: Sequence[str] | None = None,
    tau: float = 0.25,
    one_to_one: bool = False,
    robot: str = ROBOT,
) -> GroupSynchrony:
    """Group synchronisation index of one iteration, with the graph it comes from.

    Under the paper's edges perfect synchrony of three dancers and a robot scores 1 where the robot has all its
    edges (ECA), 10/12 where it follows one dancer (SIA), and 9/12 where it follows none (SIA in iteration 1); so
    methods compare fairly under ``full`` only, and both are always reported.

    Args:
        series: events of one iteration by agent, the robot among them or not; an agent without events belongs
            here with empty series.
        edges: ``paper``: dancers have edges to everyone, the robot to those it follows; ``full``: all edges.
        follows: whom the robot follows, under ``paper``: None for every dancer (ECA and all methods that use all
            of them), the most synchronous person of the iteration before for SIA, () for nobody.
        tau: strict window of a coincidence [s].
        one_to_one: bounded variant, see `pair_synchrony`.
        robot: name of the robot among the agents.

    Raises:
        ConfigError: an unknown edge rule, or ``follows`` names somebody who is not in ``series``.

    Source: iqbal2016, eq. (11).
    """
    agents = tuple(series)
    counted = _count(tuple(series.values()), tau, one_to_one)
    pairs = np.where(np.eye(len(agents), dtype=bool), 0.0, counted.index)
    out = _graph(agents, edges, follows, robot)
    individual, connected = individual_index(pairs, out), connectivity(out)
    gsi = float(np.mean(individual * connected)) if agents else 0.0
    for array in (pairs, out, individual, connected):
        array.flags.writeable = False
    empty = tuple((a, b) for (i, a), (j, b) in combinations(enumerate(agents), 2) if counted.empty[i, j])
    return GroupSynchrony(agents, pairs, out, individual, connected, gsi, empty)


def most_synchronous(
    series: Mapping[str, Series], before: str | None = None, tau: float = 0.25, one_to_one: bool = False
) -> MostSynchronous:
    """The dancer with the highest individual index, from the dancers' own graph.

    A tie (about a third of iterations) keeps the previous choice if it is among the tied, else the first of them
    in the order of ``series``; so does an iteration without any events, in which everyone is tied at 0.

    Args:
        series: the dancers' events of one iteration, at least one dancer, in the order of the cast; no robot.
        before: the previous iteration's choice, or None.
        tau: strict window of a coincidence [s].
        one_to_one: bounded variant, see `pair_synchrony`.

    Source: iqbal2016, section III-A.3.
    """
    group = group_index(series, "full", tau=tau, one_to_one=one_to_one)
    best = group.individual.max()
    tied = tuple(name for name, value in zip(group.agents, group.individual, strict=True) if value >= best - TIE)
    return MostSynchronous(before if before in tied and before is not None else tied[0], tied, group.individual)


@dataclass(frozen=True, slots=True)
class _Counted:
    """Pairwise synchrony of H agents over the K kinds that occur: Q(e) (H, H, K), Q_xy (H, H), no event (H, H)."""

    kinds: tuple[str, ...]
    synchrony: Array
    index: Array
    empty: BoolArray


def _count(series: Sequence[Series], tau: float, one_to_one: bool) -> _Counted:
    """All pairs and kinds at once: each kind gets its own stretch of one time line, farther apart than tau."""
    if not tau > 0.0:
        raise ConfigError("tau", tau, "a positive number of seconds")
    tau_us = round(tau * 1e6)
    codes: dict[str, int] = {}
    times, kinds = zip(*(_coded(events, codes) for events in series), strict=True) if series else ((), ())
    size, many = len(series), len(codes)
    owner = np.repeat(np.arange(size), [len(part) for part in times])
    line, code = np.concatenate([_NO_EVENTS, *times]), np.concatenate([_NO_EVENTS, *kinds])
    stride = int(line.max() - line.min()) + tau_us + 1 if len(line) else 1
    line = line - (line.min() if len(line) else 0) + stride * code
    events = np.bincount(owner * many + code, minlength=size * many).reshape(size, many)
    trains = [np.sort(line[owner == agent]) for agent in range(size)]
    count = np.zeros((size, size, many))
    if one_to_one:
        for i, j in combinations(range(size), 2):
            matched = np.array(_matches(trains[i].tolist(), trains[j].tolist(), tau_us), dtype=np.int64) // stride
            count[i, j] = count[j, i] = np.bincount(matched, minlength=many)
    else:
        for agent, train in enumerate(trains):
            # c(x|y) + c(y|x): lags strictly inside tau; a tie's two halves make one.
            inside = train.searchsorted(line + tau_us, "left") - train.searchsorted(line - tau_us, "right")
            count[:, agent] = np.bincount(owner * many + code, inside, size * many).reshape(size, many)
    product, weight = events[:, None] * events, events[:, None] + events
    synchrony = count / np.sqrt(np.maximum(product, 1))
    weights = weight.sum(axis=2)
    index = (synchrony * weight).sum(axis=2) / np.maximum(weights, 1)
    return _Counted(tuple(codes), synchrony, index, weights == 0)


_NO_EVENTS: IntArray = np.zeros(0, dtype=np.int64)


def _coded(series: Series, codes: dict[str, int]) -> tuple[IntArray, IntArray]:
    """Times [us] and codes of kinds; a kind not met before gets the next code."""
    times_s, kinds = series
    times = microseconds(times_s)
    if len(times) != len(kinds):
        raise ConfigError("kinds", len(kinds), f"as many as times: {len(times)}")
    names = (Kind.CLAP.value if kind == Kind.TURN else str(kind) for kind in kinds)
    return times, np.array([codes.setdefault(name, len(codes)) for name in names], dtype=np.int64)


def _matches(x: list[int], y: list[int], tau_us: int) -> list[int]:
    """Times in x of the largest one-to-one matching inside tau; on a line the earliest fitting partner is optimal."""
    i = j = 0
    found: list[int] = []
    while i < len(x) and j < len(y):
        lag = x[i] - y[j]
        if abs(lag) < tau_us:
            found.append(x[i])
            i, j = i + 1, j + 1
        elif lag > 0:
            j += 1
        else:
            i += 1
    return found


def _out_edges(size: int, edges: BoolArray | None) -> BoolArray:
    others = ~np.eye(size, dtype=bool)
    return others if edges is None else np.asarray(edges, dtype=bool) & others


def _graph(agents: tuple[str, ...], edges: str, follows: Sequence[str] | None, robot: str) -> BoolArray:
    if edges not in ("paper", "full"):
        raise ConfigError("edges", edges, "paper or full")
    out = _out_edges(len(agents), None)
    if edges == "paper" and follows is not None and robot in agents:
        unknown = [name for name in follows if name not in agents or name == robot]
        if unknown:
            raise ConfigError("follows", unknown, f"dancers among {', '.join(agents)}")
        out[agents.index(robot)] = [name in follows for name in agents]
    return out
