"""Pairwise, individual and group synchronisation index, and the most synchronous person.

All functions are pure functions of event times and kinds. Two events coincide if they have the same kind and are less
than tau apart; `coincidences` counts them. A turn is treated as a clap. Callers must leave out early events, for which
the indices are not defined. The origin of time is arbitrary, since only time differences are used.

Source: iqbal2016, eqs. (1)-(6), (10), (11); the pairwise index extends quianquiroga2002.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..core import ROBOT, Array
from ..core.errors import ConfigError
from .coincidences import BoolArray, Series, count_coincidences, encoded_events
from .pair_kernel import pair_indices as compiled_indices

TIE_TOLERANCE = 1e-9
"""Individual indices that differ by at most this are tied; smaller differences are due to rounding."""


@dataclass(frozen=True, slots=True)
class PairSynchrony:
    """Synchrony of two agents.

    Attributes:
        index: pairwise synchronisation index Q_xy; 0 if neither agent has an event. It can exceed 1 if an agent has
            several events of one kind within tau.
        by_kind: kind -> Q(e), for every kind that occurs in either series.
        empty: whether neither agent has an event, so that ``index`` is not meaningful.
    """

    index: float
    by_kind: Mapping[str, float]
    empty: bool


@dataclass(frozen=True, slots=True)
class PairIndices:
    """Pairwise synchronisation indices of H agents in one iteration.

    Attributes:
        agents: names of the agents.
        index: (H, H) pairwise indices, symmetric, 0 on the diagonal.
        empty: (H, H) whether neither agent of the pair has an event.
    """

    agents: tuple[str, ...]
    index: Array
    empty: BoolArray

    def first(self, count: int) -> PairIndices:
        """Return the indices of the first ``count`` agents."""
        return PairIndices(self.agents[:count], self.index[:count, :count], self.empty[:count, :count])


@dataclass(frozen=True, slots=True)
class GroupSynchrony:
    """Group topology graph of one iteration, and the indices that follow from it.

    Attributes:
        agents: names of the H vertices, in the order of the rows and columns of all arrays.
        pairs: (H, H) pairwise indices, symmetric, 0 on the diagonal.
        edges: (H, H) whether an edge leads from row to column.
        individual: (H,) individual synchronisation index: mean weight of the outgoing edges; 0 without such edges.
        connectivity: (H,) out-degree divided by H - 1.
        gsi: group synchronisation index.
        empty_pairs: pairs in which neither agent has an event, so that their index of 0 is not meaningful.
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
        person: name of the most synchronous dancer.
        tied: names of all dancers with the highest individual index, in the order of the series; one name if there is
            no tie.
        individual: (D,) individual indices, in the order of the series.
    """

    person: str
    tied: tuple[str, ...]
    individual: Array


def pair_synchrony(a: Series, b: Series, tau: float = 0.25, one_to_one: bool = False) -> PairSynchrony:
    """Compute the pairwise synchronisation index Q_xy of two agents, and the index Q(e) of each kind.

    A kind that occurs for one agent only has Q(e) = 0 and enters the weighted mean, so that missing events lower the
    index. A kind that occurs for neither agent does not enter the mean. Without any event the index is 0 and ``empty``
    is True.

    Args:
        a: times [s] and kinds of the first agent's events, in any order.
        b: times [s] and kinds of the second agent's events, in any order.
        tau: two events coincide if they are less than this apart [s].
        one_to_one: match each event at most once (maximum matching), which bounds Q by 1. The equation in the paper
            counts every pair of events within tau and is not bounded.

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
    """Compute the pairwise synchronisation index Q_xy of two agents; `pair_synchrony` also returns Q(e) of each kind.

    Args:
        times_a: (N,) times of the first agent's events [s], in any order.
        kinds_a: (N,) kinds of these events.
        times_b: (M,) times of the second agent's events [s], in any order.
        kinds_b: (M,) kinds of these events.
        tau: two events coincide if they are less than this apart [s] (iqbal2016: .25 s).
        one_to_one: bounded variant, see `pair_synchrony`.

    Returns:
        the index: 0 for no synchrony or no events, 1 for full synchrony. It can exceed 1 if an agent has several events
        of one kind within tau and ``one_to_one`` is False.

    Source: iqbal2016, eq. (4).
    """
    return pair_synchrony((times_a, kinds_a), (times_b, kinds_b), tau, one_to_one).index


def individual_index(pairs: Array, edges: BoolArray | None = None) -> Array:
    """Compute the individual synchronisation index of every agent: the mean weight of its outgoing edges.

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
    """Compute the connectivity of every agent: its out-degree divided by the H - 1 possible edges.

    Args:
        edges: (H, H) whether an edge leads from row to column; the diagonal is ignored.

    Returns:
        (H,) values from 0 to 1; 0 for a group of one.

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
    """Compute the group synchronisation index (GSI) of one iteration, and the graph that it is computed from.

    With the paper's edges, the GSI of three dancers and a robot in perfect synchrony is 1 if the robot has edges to all
    dancers (ECA), 10/12 if it follows one dancer (SIA), and 9/12 if it follows none (SIA in iteration 1). Use ``full``
    edges to compare methods. A session reports both.

    Args:
        series: agent -> events of one iteration, with or without the robot. Include agents without events, with empty
            series.
        edges: ``paper``: dancers have edges to all agents, the robot to the dancers that it follows; ``full``: all
            edges.
        follows: dancers that the robot follows, for ``paper`` edges: None for all dancers (ECA and other methods that
            use the events of all dancers), one name for SIA, () for none.
        tau: two events coincide if they are less than this apart [s].
        one_to_one: bounded variant, see `pair_synchrony`.
        robot: name of the robot among the agents.

    Raises:
        ConfigError: ``edges`` has another value, ``follows`` contains a name that is not a dancer in ``series``, tau is
            not positive, times are not finite, or times and kinds differ in length.

    Source: iqbal2016, eq. (11).
    """
    return group_graph(pair_indices(series, tau, one_to_one), edges, follows=follows, robot=robot)


def pair_indices(series: Mapping[str, Series], tau: float = 0.25, one_to_one: bool = False) -> PairIndices:
    """Compute the pairwise indices of all agents, from which the indices of several graphs can be computed.

    Args:
        series: agent -> events of one iteration.
        tau: two events coincide if they are less than this apart [s].
        one_to_one: bounded variant, see `pair_synchrony`.

    Raises:
        ConfigError: tau is not positive, times are not finite, or times and kinds differ in length.

    Source: iqbal2016, eq. (4).
    """
    agents = tuple(series)
    if one_to_one:
        counted = count_coincidences(tuple(series.values()), tau, one_to_one)
        return PairIndices(agents, np.where(np.eye(len(agents), dtype=bool), 0.0, counted.index), counted.empty)

    events = encoded_events(tuple(series.values()), tau)
    index = compiled_indices(events.times_us, events.kinds, events.slices[None], events.tau_us, events.kind_count)[0]
    counts = events.slices[:, 1] - events.slices[:, 0]
    return PairIndices(agents, index, np.add.outer(counts, counts) == 0)


def group_graph(
    pairs: PairIndices, edges: str = "paper", *, follows: Sequence[str] | None = None, robot: str = ROBOT
) -> GroupSynchrony:
    """Compute the group topology graph and the group synchronisation index from the pairwise indices.

    Args:
        pairs: pairwise indices of all agents.
        edges: see `group_index`.
        follows: see `group_index`.
        robot: name of the robot among the agents.

    Raises:
        ConfigError: ``edges`` has another value, or ``follows`` contains a name that is not a dancer.

    Source: iqbal2016, eq. (11).
    """
    out = _graph_edges(pairs.agents, edges, follows, robot)
    individual = individual_index(pairs.index, out)
    connected = connectivity(out)
    gsi = float(np.mean(individual * connected)) if pairs.agents else 0.0

    for array in (pairs.index, out, individual, connected):
        array.flags.writeable = False
    empty = tuple((a, b) for (i, a), (j, b) in combinations(enumerate(pairs.agents), 2) if pairs.empty[i, j])
    return GroupSynchrony(pairs.agents, pairs.index, out, individual, connected, gsi, empty)


def most_synchronous(
    series: Mapping[str, Series], previous: str | None = None, tau: float = 0.25, one_to_one: bool = False
) -> MostSynchronous:
    """Determine the most synchronous person (MSP): the dancer with the highest individual index.

    The indices are computed in the full graph of the dancers. Ties occur in about a third of the iterations. If
    ``previous`` is one of the tied dancers it is returned, otherwise the first of them in the order of ``series``. In
    an iteration without events all dancers are tied.

    Args:
        series: dancer -> events of one iteration, for at least one dancer. It must not contain the robot.
        previous: most synchronous person of the iteration before, or None.
        tau: two events coincide if they are less than this apart [s].
        one_to_one: bounded variant, see `pair_synchrony`.

    Source: iqbal2016, section III-A.3.
    """
    return most_synchronous_of(pair_indices(series, tau, one_to_one), previous)


def most_synchronous_of(pairs: PairIndices, previous: str | None = None) -> MostSynchronous:
    """Determine the most synchronous person from the dancers' pairwise indices; see `most_synchronous`."""
    individual = individual_index(pairs.index)
    best = individual.max()
    tied = tuple(name for name, value in zip(pairs.agents, individual, strict=True) if value >= best - TIE_TOLERANCE)
    person = previous if previous is not None and previous in tied else tied[0]
    return MostSynchronous(person, tied, individual)


def _out_edges(count: int, edges: BoolArray | None) -> BoolArray:
    """(H, H) edges without self-loops; the full graph if ``edges`` is None."""
    others = ~np.eye(count, dtype=bool)
    return others if edges is None else np.asarray(edges, dtype=bool) & others


def _graph_edges(agents: tuple[str, ...], edges: str, follows: Sequence[str] | None, robot: str) -> BoolArray:
    """(H, H) edges of the group topology graph; arguments as in `group_index`."""
    if edges not in ("paper", "full"):
        raise ConfigError("edges", edges, "paper or full")
    out = _out_edges(len(agents), None)

    if edges == "paper" and follows is not None and robot in agents:
        unknown = [name for name in follows if name not in agents or name == robot]
        if unknown:
            raise ConfigError("follows", unknown, f"dancers among {', '.join(agents)}")
        out[agents.index(robot)] = [name in follows for name in agents]
    return out
