"""Fits coupling and noise of the human timing model to event times, by maximum likelihood.

What the data can tell apart: the timekeeper carries its noise over to the next event, but not motor noise; dancers
correct both, as they observe them; what all dancers share is the common shift. With music, the common shift is an AR(1)
process about the beats. At a steady tempo there is none, as in the published model. In free time the common time of
each event is left free, and only what differs between dancers counts. Differences alone hardly tell weak correction
of little motor noise from strong correction of much: give ``steady`` where the tempo is steady. For a coupling matrix
in free time, the group's intervals are compared with the mean intervals of several trials of the same events, and
the group's deviation from them is fitted as ``tempo_s``.

Not in the likelihood: the order rule of `humans.timing` (no move and no hold shorter than people can make it), which
concerns one move in seventy under the paper's presets. Corrections towards the music or the robot, drifting tempi and
the robot's influence on people's noise are not fitted; they would appear as common shift and as spread between
iterations. Persons whose noise differs from session to session appear as spread between groups.

Source: jacoby2015 (the estimation problem, and the trade-off between noise variances and gains).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...core import Array
from ...core.errors import ConfigError
from ...humans.timing.parameters import TimingParameters
from .fit_warnings import fit_warnings
from .optimisation import Z_95, minimise, minimum_with_intervals
from .tapping_trials import FitError, TappingTrials, finite_mean
from .timing_likelihood import TimingLikelihood

FEWEST_EVENTS = 30
"""Fewest events for a fit."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A fitted value and its 95 % confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class TimingFit:
    """Result of a fit.

    Attributes:
        values: fields of `TimingParameters` as fitted, whether or not a group could dance with them.
        estimates: name -> value and interval; ``coupling[1][2]`` is how far dancer 1 corrects towards dancer 2.
        agents: the dancers, in order.
        iterations: number of fitted trials, that is, iterations of a dance or takes of a piece.
        events: number of fitted events.
        log_likelihood: at the maximum.
        warnings: reservations about the estimates, a sentence each.
    """

    values: Mapping[str, Any]
    estimates: Mapping[str, Estimate]
    agents: tuple[str, ...]
    iterations: int
    events: int
    log_likelihood: float
    warnings: tuple[str, ...] = ()

    @property
    def parameters(self) -> TimingParameters:
        """Parameters of the human timing model, with which dancers can be simulated.

        Raises:
            FitError: no group could dance with them, since differences between dancers would grow.
        """
        try:
            return TimingParameters(**self.values)
        except ConfigError as error:
            raise FitError(f"the fit makes no group that can dance: {error.field} wants {error.allowed}") from error


def fit_trials(data: TappingTrials, *, coupling: str = "one", noise: str = "one") -> TimingFit:
    """Fit the human timing model.

    Args:
        data: event times of one or many groups of the same size.
        coupling: ``one`` number for all pairs of dancers, or ``matrix``, one for each pair.
        noise: ``one`` scale for all dancers, or ``each`` their own.

    Raises:
        ConfigError: coupling or noise is another word.
        FitError: there are fewer than `FEWEST_EVENTS` events or two dancers.
    """
    _check_options(data, coupling, noise)
    events = int(np.isfinite(data.late_s).sum())
    if events < FEWEST_EVENTS or len(data.agents) < 2:
        found = f"{events} events of {len(data.agents)} dancers"
        raise FitError(f"too little to fit: {found}, of at least {FEWEST_EVENTS} events of 2 dancers")

    likelihood = TimingLikelihood(data, coupling == "matrix", noise == "each")
    bounds = likelihood.bounds()

    # Spreads are freed last: far from the minimum they would absorb the misfit of the other parameters.
    is_spread = np.array([name.endswith("_spread") for name in likelihood.names])
    minima = [minimise(likelihood.cost, start, bounds, ~is_spread, events) for start in likelihood.starts()]
    if is_spread.any():
        best = min(minima, key=likelihood.cost)
        minima = [minimise(likelihood.cost, best, bounds, np.ones_like(is_spread), events)]
    vector, intervals = minimum_with_intervals(likelihood.cost, minima, bounds, events)

    estimates = _estimates(likelihood, vector, intervals)
    fit = TimingFit(
        values=_parameter_values(estimates, likelihood),
        estimates=estimates,
        agents=data.agents,
        iterations=len(data.late_s),
        events=events,
        log_likelihood=-likelihood.cost(vector),
    )
    warnings = list(fit_warnings(likelihood, vector, intervals))
    # The property raises if no group could dance with the parameters.
    try:
        _ = fit.parameters
    except FitError as error:
        warnings.append(str(error))
    return replace(fit, warnings=tuple(warnings))


def _check_options(data: TappingTrials, coupling: str, noise: str) -> None:
    """Raise `ConfigError` if an option is unknown, or cannot be fitted to these data."""
    for name, value, allowed in (("coupling", coupling, ("one", "matrix")), ("noise", noise, ("one", "each"))):
        if value not in allowed:
            raise ConfigError(name, value, f"one of {', '.join(allowed)}")

    if coupling == "matrix" and not (data.expects_time or data.pacers):
        reason = (
            "one, in free time: differences between dancers do not tell which of two corrected; the tempo must be "
            "steady (time = steady), or the same events played three times"
        )
        raise ConfigError("coupling", coupling, reason)


def _estimates(likelihood: TimingLikelihood, vector: Array, intervals: Array) -> dict[str, Estimate]:
    """Every fitted value with its interval, in the units of `TimingParameters`.

    Args:
        likelihood: of the trials.
        vector: (P,) fitted entries.
        intervals: (P, 2) ends of their intervals.
    """
    found = {}
    entries = zip(likelihood.names, vector, intervals, likelihood.bounds(), strict=True)
    for name, value, (low, high), (lower_bound, upper_bound) in entries:
        numbers = np.array([value, max(low, lower_bound), min(high, upper_bound)])
        if name.startswith("scale["):
            numbers = np.exp(numbers)
        elif name.endswith("_s"):
            # A noise is fitted as a variance in units of the typical deviation.
            numbers = likelihood.unit_s * np.sqrt(np.maximum(numbers, 0.0))
        found[name] = Estimate(*map(float, numbers))

    return {**found, **_lateness(likelihood), **_lapse_rate(likelihood.trials)}


def _lateness(likelihood: TimingLikelihood) -> dict[str, Estimate]:
    """Constant lateness of each dancer, with the standard error of the mean over sessions, or over trials of one."""
    late_s = likelihood.trials.late_s
    session = likelihood.session
    if likelihood.trials.pacers:
        late_s = late_s - late_s[..., [likelihood.trials.pacers[0]]]
    elif likelihood.trials.time != "music":
        late_s = late_s - finite_mean(late_s, 2)[..., None]
    if session.max() < 1:
        session = np.arange(len(late_s))

    means_s = np.array([finite_mean(late_s[session == k], (0, 1)) for k in range(session.max() + 1)])
    half_width_s = np.full(likelihood.dancers, np.inf)
    if len(means_s) > 1:
        half_width_s = Z_95 * np.nanstd(means_s, axis=0) / np.sqrt(len(means_s) - 1)
    return {
        f"late_s[{i + 1}]": Estimate(float(mean), float(mean - half_width_s[i]), float(mean + half_width_s[i]))
        for i, mean in enumerate(likelihood.means_s)
        if i in likelihood.correcting
    }


def _lapse_rate(trials: TappingTrials) -> dict[str, Estimate]:
    """Share of phrases of which a dancer performed nothing, with Wilson's interval; empty without phrases."""
    if not trials.phrases:
        return {}

    present = np.isfinite(trials.late_s)
    missed = np.array([~present[:, list(phrase)].any(axis=1) for phrase in trials.phrases])
    n = missed.size
    share = float(missed.mean())

    centre = share + Z_95**2 / 2 / n
    spread = np.sqrt(share * (1 - share) / n + Z_95**2 / 4 / n**2)
    low, high = ((centre + side * Z_95 * spread) / (1 + Z_95**2 / n) for side in (-1, 1))
    return {"lapse": Estimate(share, float(max(low, 0.0)), float(high))}


def _parameter_values(estimates: Mapping[str, Estimate], likelihood: TimingLikelihood) -> dict[str, Any]:
    """The estimates as fields of `TimingParameters`."""
    values = {name: estimate.value for name, estimate in estimates.items()}
    fields: dict[str, Any] = {name: value for name, value in values.items() if "[" not in name and name != "tempo_s"}

    if likelihood.matrix:
        fields["coupling"] = tuple(tuple(float(gain) for gain in row) for row in likelihood.gains(values))
    else:
        # The nearest gain with which a group can dance.
        fields["coupling"] = max(values["coupling"], 0.0)
    if likelihood.trials.pacers:
        fields["correction"] = tuple(float(k in likelihood.correcting) for k in range(likelihood.dancers))
        fields["scale"] = fields["correction"]
    if likelihood.each:
        logarithms = {name: float(np.log(value)) for name, value in values.items() if name.startswith("scale[")}
        fields["scale"] = tuple(float(scale) for scale in likelihood.scales(logarithms))
    fields["late_s"] = tuple(values.get(f"late_s[{i + 1}]", 0.0) for i in range(likelihood.dancers))
    return {**fields, "about": _description(likelihood.trials)}


def _description(trials: TappingTrials) -> str:
    """Text of the parameters' field ``about``: what they were fitted to."""
    sessions = len(set(trials.session.tolist()))
    time = {"music": "about the music", "steady": "at a steady tempo of their own", "free": "in free time"}[trials.time]
    counts = f"iterations: {len(trials.late_s)}, sessions: {sessions}, dancers: {', '.join(trials.agents)}"
    return f"fitted {time}; {counts}"
