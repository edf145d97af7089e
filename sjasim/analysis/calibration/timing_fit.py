"""How a group couples and how noisily it keeps time, fitted to event times by maximum likelihood.

What can be told apart: timekeeper noise is carried on to the next event and is corrected, motor noise is not; what all
dancers share is common. With a timetable the common shift is an AR(1) process about the music; without one ("free")
each event's common time is left open, and only what divides the dancers counts. The order rule of
`humans.timing` (no move and no hold shorter than people can make it) is not in the likelihood; it touches one move in
seventy of the paper's presets. Corrections towards the music or the robot, drifting tempi and the robot's influence on
people's noise are not fitted: they would be taken for common shift and for spread from iteration to iteration. Persons
who differ in noise from session to session show as spread of their groups.

Source: jacoby2015 (the estimation problem, and that noise variances and gains trade off against each other).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import logsumexp

from ...core import Array, IntArray
from ...core.errors import ConfigError, SjasimError
from ...humans.timing.parameters import REFERENCE_GROUP_SIZE, TimingParameters
from .kalman_likelihood import Noise, PhaseFilter, log_mixture
from .optimisation import LEVEL, Bounds, intervals, lowest

FEWEST_EVENTS = 30
SPREAD_FROM = 8
"""Spread from iteration to iteration, and from group to group, is fitted from so many of them on."""
OPEN = 100.0
"""Standard deviation of a common shift that is left open, in typical deviations."""
IMPOSSIBLE = 1e12
"""Cost of variances that no events could have."""
GRID = 4.2 * np.linspace(-1.0, 1.0, 31), 3.2 * np.linspace(-1.0, 1.0, 7)
"""Standardised log scales of iterations and of groups over which the likelihood is summed."""


def mean_seen(values: Array, axis: int | tuple[int, ...]) -> Array:
    """Mean of what is finite along some axes; NaN where nothing is."""
    count = np.isfinite(values).sum(axis=axis)
    return np.asarray(np.where(count, np.nansum(values, axis=axis) / np.maximum(count, 1), np.nan))


class FitError(SjasimError):
    """There is too little in the data, or nothing that the model can describe."""


@dataclass(frozen=True, slots=True)
class TappingTrials:
    """What groups did, ready to be fitted.

    Attributes:
        agents: the D dancers.
        late_s: (N, E, D) event times minus the music's beats, or minus the group's mean in free time; NaN where
            missing. One row per iteration or trial.
        session: (N,) which session each row belongs to.
        music: whether the music's beats are known; else the time is free.
        phrases: events that a dancer leaves out together, as lists of event indices.
        unused: how many events found no place, because another of the same dancer was nearer to it.
        warnings: what speaks against a fit, a line each, in words.
    """

    agents: tuple[str, ...]
    late_s: Array
    session: IntArray
    music: bool
    phrases: tuple[tuple[int, ...], ...] = ()
    unused: int = 0
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Estimate:
    """A fitted value and its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class TimingFit:
    """What was found.

    Attributes:
        values: fields of `TimingParameters` as fitted, whether or not a group could dance them.
        estimates: by name, every fitted value with its interval; ``coupling[1][2]`` is how dancer 1 corrects towards
            dancer 2.
        agents: the dancers, in order.
        performances: how many iterations or trials were fitted.
        events: how many events.
        log_likelihood: at the maximum.
        warnings: what speaks against the estimates, a line each, in words.
    """

    values: Mapping[str, Any]
    estimates: Mapping[str, Estimate]
    agents: tuple[str, ...]
    performances: int
    events: int
    log_likelihood: float
    warnings: tuple[str, ...] = ()

    @property
    def parameters(self) -> TimingParameters:
        """The human timing model's parameters, ready to be danced.

        Raises:
            FitError: no group could dance them, for under the fitted gains differences would grow.
        """
        try:
            return TimingParameters(**self.values)
        except ConfigError as error:
            raise FitError(f"the fit makes no group that can dance: {error.field} wants {error.allowed}") from error


def fit_trials(data: TappingTrials, *, coupling: str = "one", noise: str = "one") -> TimingFit:
    """Fit the human timing model.

    Args:
        data: event times of one or many groups of the same size.
        coupling: ``one`` number for all pairs, or ``matrix``: one for each.
        noise: ``one`` scale for all dancers, or ``each`` their own.

    Raises:
        ConfigError: another word for coupling or noise.
        FitError: fewer than `FEWEST_EVENTS` events or two dancers.
    """
    for name, value, words in (("coupling", coupling, ("one", "matrix")), ("noise", noise, ("one", "each"))):
        if value not in words:
            raise ConfigError(name, value, f"one of {', '.join(words)}")
    if coupling == "matrix" and not data.music:
        allowed = "one, in free time: differences between dancers do not tell who of two gave way"
        raise ConfigError("coupling", coupling, allowed)
    events = int(np.isfinite(data.late_s).sum())
    if events < FEWEST_EVENTS or len(data.agents) < 2:
        found = f"{events} events of {len(data.agents)} dancers"
        raise FitError(f"too little to fit: {found}, of at least {FEWEST_EVENTS} events of 2 dancers")
    model = _Model(data, coupling == "matrix", noise == "each")
    at = model.start()
    spreads = [name.endswith("_spread") for name in model.names]
    for free in (np.logical_not(spreads), np.ones(len(at), dtype=bool)):
        at = lowest(model.cost, at, model.bounds(), free, events)
    ends = intervals(model.cost, at, model.bounds(), events)
    estimates = model.estimates(at, ends)
    shape = data.agents, len(data.late_s), events
    fit = TimingFit(_values(estimates, data, model), estimates, *shape, -model.cost(at))
    return replace(fit, warnings=_doubts(fit, model, at, ends))


@dataclass
class _Model:
    """The likelihood of performances over a vector of parameters, in units of the typical deviation."""

    data: TappingTrials
    matrix: bool
    each: bool
    _late: Array = field(init=False)
    _unit: float = field(init=False)

    def __post_init__(self) -> None:
        late_s = self.data.late_s
        self._means = mean_seen(late_s, (0, 1))
        centred = late_s - self._means
        together = mean_seen(centred, 2)
        apart = centred - together[..., None]
        self._unit = max(float(np.nanstd(apart)), 1e-6)
        self._filter = PhaseFilter(centred / self._unit)
        self._dancers = late_s.shape[2]
        self._common = float(np.nanstd(together)) / self._unit
        sessions, self._session = np.unique(self.data.session, return_inverse=True)
        self._many = self.data.music and len(late_s) >= SPREAD_FROM
        self._groups = self._many and SPREAD_FROM <= len(sessions) < len(late_s)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the vector's entries."""
        pairs = [(i, j) for i in range(self._dancers) for j in range(self._dancers) if i != j]
        gains = [f"coupling[{i + 1}][{j + 1}]" for i, j in pairs] if self.matrix else ["coupling"]
        scales = [f"scale[{i + 1}]" for i in range(self._dancers - 1)] if self.each else []
        common = ["common_s", "common_correlation"] if self.data.music else []
        spreads = ["iteration_spread"] * self._many + ["group_spread"] * self._groups
        return ("timekeeper_s", "motor_s", *gains, *scales, *common, *spreads)

    def start(self) -> Array:
        """A first guess."""
        guesses = {
            "timekeeper_s": 0.6, "motor_s": 0.15, "common_s": self._common**2, "common_correlation": 0.5,
            "iteration_spread": 0.1, "group_spread": 0.05, "scale": 0.0,
            "coupling": 0.5 / (self._dancers if self.matrix else REFERENCE_GROUP_SIZE),
        }  # fmt: skip
        return np.array([guesses[name.partition("[")[0]] for name in self.names])

    def bounds(self) -> Bounds:
        """Least and largest values.

        Noises are fitted as variances, of which the likelihood is nearly quadratic, so that its curvature means
        something at 0 too; spreads count by their size.
        """
        limits = {
            "timekeeper_s": (1e-6, 1e3),
            "motor_s": (0.0, 1e3),
            "common_s": (1e-6, 1e6),
            "common_correlation": (0.0, 0.999),
            "coupling": (-0.9, 0.9) if self.matrix else (0.0, 0.6),
            "scale": (-3.0, 3.0),
            "iteration_spread": (-1.0, 1.0),
            "group_spread": (-0.5, 0.5),
        }
        return [limits[name.partition("[")[0]] for name in self.names]

    def gains(self, values: Mapping[str, float]) -> Array:
        """(D, D) share of its lead over each other dancer that each dancer gives up."""
        if not self.matrix:
            return TimingParameters(coupling=min(max(values["coupling"], 0.0), 0.6)).coupling_gains(self._dancers)
        out = np.zeros((self._dancers, self._dancers))
        for name, value in values.items():
            if name.startswith("coupling["):
                i, j = (int(part.rstrip("]")) - 1 for part in name.split("[")[1:])
                out[i, j] = value
        return out

    def scales(self, values: Mapping[str, float]) -> Array:
        """(D,) factors of the dancers' noise; their logarithms add up to 0."""
        logs = np.array([value for name, value in values.items() if name.startswith("scale[")])
        return np.exp(np.append(logs, -logs.sum())) if self.each else np.ones(self._dancers)

    def cost(self, vector: Array) -> float:
        """Minus the log likelihood."""
        values = dict(zip(self.names, map(float, vector), strict=True))
        gains = self.gains(values)
        transition = np.eye(self._dancers) + gains - np.diag(gains.sum(axis=1))
        own = self.scales(values) ** 2
        timekeeper = values["timekeeper_s"] * own
        noise = Noise(
            timekeeper,
            timekeeper if self.data.music else np.full(self._dancers, OPEN**2),
            values["motor_s"] * own,
            values["common_s"] if self.data.music else OPEN**2,
            values.get("common_correlation", 0.0),
        )
        distance, log_det = self._filter.evaluate(transition, noise)
        if not np.isfinite(log_det).all():
            return IMPOSSIBLE
        spreads = values.get("iteration_spread", 0.0), values.get("group_spread", 0.0)
        return 0.5 * float(log_det.sum()) - self._log_mixture(distance, *spreads)

    def _log_mixture(self, distance: Array, iteration: float, group: float) -> float:
        """Log likelihood but for the determinants, summed over the scales that iterations and groups may have."""
        if not self._many:
            return -0.5 * float(distance.sum())
        nodes, group_nodes = (grid for grid in GRID)
        if not self._groups:
            group_nodes = np.zeros(1)
        weights, group_weights = (-(grid**2) / 2 - logsumexp(-(grid**2) / 2) for grid in (nodes, group_nodes))
        log_scale = iteration * nodes - iteration**2 / 2
        by_group = np.empty((len(group_nodes), self._session.max() + 1))
        for g, node in enumerate(group_nodes):
            log_s = log_scale + group * node - group**2 / 2
            by_group[g] = np.bincount(self._session, log_mixture(distance, self._filter.counts, log_s, weights))
        return float(logsumexp(by_group + group_weights[:, None], axis=0).sum())

    def estimates(self, vector: Array, ends: Array) -> dict[str, Estimate]:
        """Values with their intervals, in the parameters' own units.

        Args:
            vector: (P,) the fitted entries.
            ends: (P, 2) ends of their intervals.
        """
        out = {}
        for name, value, (low, high), (least, most) in zip(self.names, vector, ends, self.bounds(), strict=True):
            found = np.array([value, max(low, least), min(high, most)])
            if name.endswith("_spread"):
                found = np.array([abs(value), max(abs(value) - (value - low), 0.0), abs(value) + (high - value)])
            elif name.startswith("scale["):
                found = np.exp(found)
            elif name.endswith("_s"):
                found = self._unit * np.sqrt(np.maximum(found, 0.0))
            out[name] = Estimate(*map(float, found))
        return {**out, **self._lateness(), **self._lapses()}

    def _lateness(self) -> dict[str, Estimate]:
        """Constant lateness of each dancer, with the error of the mean over sessions (or over performances)."""
        late_s, session = self.data.late_s, self._session
        if session.max() < 1:
            session = np.arange(len(late_s))
        means = np.array([mean_seen(late_s[session == k], (0, 1)) for k in range(session.max() + 1)])
        wide = np.full(self._dancers, np.inf)
        if len(means) > 1:
            wide = LEVEL * np.nanstd(means, axis=0) / np.sqrt(len(means) - 1)
        return {
            f"late_s[{i + 1}]": Estimate(float(mean), float(mean - wide[i]), float(mean + wide[i]))
            for i, mean in enumerate(self._means)
        }

    def _lapses(self) -> dict[str, Estimate]:
        """Share of phrases of which nothing was seen, with Wilson's interval."""
        if not self.data.phrases:
            return {}
        seen = np.isfinite(self.data.late_s)
        missed = np.array([~seen[:, list(phrase)].any(axis=1) for phrase in self.data.phrases])
        n, share = missed.size, float(missed.mean())
        centre, spread = (share + LEVEL**2 / 2 / n), np.sqrt(share * (1 - share) / n + LEVEL**2 / 4 / n**2)
        low, high = ((centre + side * LEVEL * spread) / (1 + LEVEL**2 / n) for side in (-1, 1))
        return {"lapse": Estimate(share, float(max(low, 0.0)), float(high))}


def _values(estimates: Mapping[str, Estimate], data: TappingTrials, model: _Model) -> dict[str, Any]:
    """The estimates as fields of `TimingParameters`."""
    values = {name: estimate.value for name, estimate in estimates.items()}
    plain: dict[str, Any] = {name: value for name, value in values.items() if "[" not in name}
    dancers = range(len(data.agents))
    if model.matrix:
        plain["coupling"] = tuple(tuple(float(gain) for gain in row) for row in model.gains(values))
    if model.each:
        logs = {name: float(np.log(value)) for name, value in values.items() if name.startswith("scale[")}
        plain["scale"] = tuple(float(scale) for scale in model.scales(logs))
    plain["late_s"] = tuple(values[f"late_s[{i + 1}]"] for i in dancers)
    return {**plain, "about": _about(data)}


def _doubts(fit: TimingFit, model: _Model, vector: Array, ends: Array) -> tuple[str, ...]:
    """What speaks against a fit: entries on their bounds, intervals as wide as these, too few sessions, no dance.

    A noise or a gain of 0 is a finding, not a doubt.
    """
    least, most = np.array(model.bounds()).T
    at_least, at_most = (np.isclose(vector, bound, rtol=1e-4, atol=1e-9) for bound in (least, most))
    low, high = ends.T
    said = list(model.data.warnings)
    for flags, words in (
        (at_most | (at_least & (least != 0.0)), "on the bounds of what is fitted, and say little"),
        ((low <= least) & (high >= most), "not told by these data: intervals from bound to bound"),
    ):
        names = [name for name, flag in zip(model.names, flags, strict=True) if flag]
        said += [f"{words}: {', '.join(names)}"] if names else []
    if (model.matrix or model.each) and len(set(model.data.session.tolist())) == 1:
        said.append("one session is too little to tell people apart: give several of the same people")
    try:
        _ = fit.parameters
    except FitError as error:
        said.append(str(error))
    return tuple(said)


def _about(data: TappingTrials) -> str:
    sessions = len(set(data.session.tolist()))
    time = "about the music" if data.music else "in free time"
    told = f"performances: {len(data.late_s)}, sessions: {sessions}, dancers: {', '.join(data.agents)}"
    return f"fitted {time}; {told}"
