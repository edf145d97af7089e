"""The paper's synchrony equations: pairwise, individual and group synchronisation index, most synchronous person.

Pure functions of event times and kinds. Events are counted in `coincidences`: two events coincide if they are of one
kind and less than tau apart. Early events belong to no index: callers leave them out. A turn counts as a clap. The
origin of time is arbitrary, since only differences enter.

Source: iqbal2016, eqs. (1)-(6), (10), (11); the pairwise index extends quianquiroga2002.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..core import ROBOT, Array
from ..core.errors import ConfigError
from .coincidences import BoolArray, Series, count_coincidences

TIE_TOLERANCE = 1e-9
"""Individual indices closer than this are tied: the difference is rounding."""


@dataclass(frozen=True, slots=True)
class PairSynchrony:
    """Synchrony of two agents.

    Attributes:
        index: Q_xy; 0 if neither agent has an event. Bursts of one kind closer than tau can lift it above 1.
        by_kind: Q(e) of every kind that occurs in either series.
        empty: whether neither agent had an event, so that ``index`` says nothing.
    """

    index: float
    by_kind: Mapping[str, float]
    empty: bool


@dataclass(frozen=True, slots=True)
class GroupSynchrony:
    """Group topology graph of one iteration, and the indices that follow from it.

    Attributes:
        agents: the H vertices, in the order of all arrays.
        pairs: (H, H) pairwise indices, symmetric, 0 on the diagonal.
        edges: (H, H) whether an edge leads from row to column.
        individual: (H,) mean weight of the outgoing edges; 0 for an agent without any.
        connectivity: (H,) out-degree over H - 1.
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
    """The most synchronous person of an iteration.

    Attributes:
        person: the most synchronous dancer.
        tied: everyone with the highest individual index, in the order of the cast; one name if there is no tie.
        individual: (D,) individual indices, in the order of the cast.
    """

    person: str
    tied: tuple[str, ...]
    individual: Array


def pair_synchrony(a: Series, b: Series, tau: float = 0.25, one_to_one: bool = False) -> PairSynchrony:
    """Pairwise synchronisation index Q_xy of two agents, with its parts.

    A kind that only one agent has gets Q(e) = 0 and keeps its weight, since a missing event is a failure. A kind that
    neither has does not count. Without any event the index is 0 and ``empty`` is set.

    Args:
        a: times [s] and kinds of one agent's events, in any order.
        b: those of the other agent.
        tau: two events coincide if they are less than this apart [s].
        one_to_one: match each event at most once (maximum matching), which bounds Q by 1. The printed equation counts
            every pair of events within tau and is not bounded.

    Raises:
        ConfigError: tau is not positive, times are not finite, or times and kinds differ in length.

    Source: iqbal2016, eqs. (1)-(4).
    """
    counted = count_coincidences((a, b), tau, one_to_one)
    by_kind = dict(zip(counted.kinds, counted.by_kind[0, 1].tolist(), strict=True))
    return PairSynchrony(float(counted.index[0, 1]), by_kind, bool(counted.empty[0, 1]))


def pair_index(
    times_a: Sequence[float] | Array,
    kinds_a: Sequence[str],
    times_b: Sequence[float] | Array,
    kinds_b: Sequence[str],
    tau: float = 0.25,
    one_to_one: bool = False,
) -> float:
    """Pairwise synchronisation index Q_xy of two agents; `pair_synchrony` returns its parts as well.

    Args:
        times_a: (N,) times of one agent's events [s], in any order.
        kinds_a: (N,) their kinds.
        times_b: (M,) times of the other agent's events [s].
        kinds_b: (M,) their kinds.
        tau: two events coincide if they are less than this apart [s] (iqbal2016: .25).
        one_to_one: bounded variant, see `pair_synchrony`.

    Returns:
        0 for no synchrony (or no events at all), 1 for full synchrony; bursts of events can exceed 1.

    Source: iqbal2016, eq. (4).
    """
    return pair_synchrony((times_a, kinds_a), (times_b, kinds_b), tau, one_to_one).index


def individual_index(pairs: Array, edges: BoolArray | None = None) -> Array:
    """Individual synchronisation index of every agent: the mean weight of its outgoing edges.

    Args:
        pairs: (H, H) pairwise indices; the diagonal is ignored.
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
    """(H,) connectivity of every agent: its out-degree over the H - 1 possible edges; 0 for a group of one.

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
    """Group synchronisation index (GSI) of one iteration, with the graph it is computed from.

    With the paper's edges, perfect synchrony of three dancers and a robot scores 1 if the robot has all its edges
    (ECA), 10/12 if it follows one dancer (SIA), and 9/12 if it follows nobody (SIA in iteration 1). Methods can
    therefore be compared with ``full`` edges only; a session reports both.

    Args:
        series: events of one iteration by agent, with or without the robot. An agent without events is included, with
            empty series.
        edges: ``paper``: dancers have edges to everyone, the robot to those it follows; ``full``: all edges.
        follows: whom the robot follows, for ``paper`` edges: None for all dancers (ECA and other methods that use all
            of them), the most synchronous person of the iteration before for SIA, () for nobody.
        tau: two events coincide if they are less than this apart [s].
        one_to_one: bounded variant, see `pair_synchrony`.
        robot: name of the robot among the agents.

    Raises:
        ConfigError: an unknown edge rule, or ``follows`` names somebody who is not in ``series``, tau is not positive,
            times are not finite, or times and kinds differ in length.

    Source: iqbal2016, eq. (11).
    """
    agents = tuple(series)
    counted = count_coincidences(tuple(series.values()), tau, one_to_one)
    pairs = np.where(np.eye(len(agents), dtype=bool), 0.0, counted.index)
    out = _graph_edges(agents, edges, follows, robot)

    individual = individual_index(pairs, out)
    connected = connectivity(out)
    gsi = float(np.mean(individual * connected)) if agents else 0.0

    for array in (pairs, out, individual, connected):
        array.flags.writeable = False
    empty = tuple((a, b) for (i, a), (j, b) in combinations(enumerate(agents), 2) if counted.empty[i, j])
    return GroupSynchrony(agents, pairs, out, individual, connected, gsi, empty)


def most_synchronous(
    series: Mapping[str, Series], previous: str | None = None, tau: float = 0.25, one_to_one: bool = False
) -> MostSynchronous:
    """The most synchronous person (MSP): the dancer with the highest individual index, in the graph of the dancers.

    In a tie, which happens in about a third of the iterations, the previous choice is kept if it is among the tied;
    else the first of them in the order of ``series`` is chosen. In an iteration without events everyone is tied.

    Args:
        series: the dancers' events of one iteration, at least one dancer, in the order of the cast; no robot.
        previous: the choice of the iteration before, or None.
        tau: two events coincide if they are less than this apart [s].
        one_to_one: bounded variant, see `pair_synchrony`.

    Source: iqbal2016, section III-A.3.
    """
    group = group_index(series, "full", tau=tau, one_to_one=one_to_one)
    best = group.individual.max()
    tied = tuple(
        name for name, value in zip(group.agents, group.individual, strict=True) if value >= best - TIE_TOLERANCE
    )
    person = previous if previous is not None and previous in tied else tied[0]
    return MostSynchronous(person, tied, group.individual)


def _out_edges(count: int, edges: BoolArray | None) -> BoolArray:
    """(H, H) edges without those from an agent to itself; the full graph for None."""
    others = ~np.eye(count, dtype=bool)
    return others if edges is None else np.asarray(edges, dtype=bool) & others


def _graph_edges(agents: tuple[str, ...], edges: str, follows: Sequence[str] | None, robot: str) -> BoolArray:
    """(H, H) edges of the group topology graph, of which those of the robot depend on whom it follows."""
    if edges not in ("paper", "full"):
        raise ConfigError("edges", edges, "paper or full")
    out = _out_edges(len(agents), None)

    if edges == "paper" and follows is not None and robot in agents:
        unknown = [name for name in follows if name not in agents or name == robot]
        if unknown:
            raise ConfigError("follows", unknown, f"dancers among {', '.join(agents)}")
        out[agents.index(robot)] = [name in follows for name in agents]
    return out
