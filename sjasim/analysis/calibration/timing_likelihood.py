"""Likelihood of trials under the human timing model, as a function of a parameter vector."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from ...core import Array
from .kalman_likelihood import Noise, PhaseFilter, log_mixture
from .optimisation import Bounds
from .tapping_trials import TappingTrials, finite_mean

SPREAD_FROM = 8
"""Fewest iterations for a fitted spread between iterations, and fewest groups for one between groups."""

FREE_SD = 100.0
"""Standard deviation of a deviation or of a common shift that is left free, in typical deviations."""

IMPOSSIBLE_COST = 1e12
"""Cost of parameters under which an event would have a variance of 0 or less."""

ITERATION_GRID = 4.2 * np.linspace(-1.0, 1.0, 31)
"""Standardised log scales of iterations over which the likelihood is summed."""

GROUP_GRID = 3.2 * np.linspace(-1.0, 1.0, 7)
"""Standardised log scales of groups over which the likelihood is summed."""


class TimingLikelihood:
    """Cost (minus the log likelihood) of trials over a parameter vector, in units of the typical deviation.

    Noises are entries as variances, in which the likelihood is nearly quadratic. In free time and with pacers, the
    first deviations of a sequence are left free; otherwise people begin as close together as timekeeper noise lets
    them. Pacers have no noise and correct nothing; times are relative to the first of them.

    Args:
        trials: the data.
        matrix: whether each pair of dancers has its own coupling.
        each: whether each dancer has its own scale of noise.
    """

    def __init__(self, trials: TappingTrials, matrix: bool, each: bool) -> None:
        self.trials = trials
        self.matrix = matrix
        self.each = each
        self.dancers: int = trials.late_s.shape[2]
        self.correcting = tuple(k for k in range(self.dancers) if k not in trials.pacers)
        """Indices of the dancers who correct and have noise: all but the pacers."""

        late_s = trials.late_s
        if trials.pacers:
            late_s = late_s - late_s[..., [trials.pacers[0]]]
            late_s[..., list(trials.pacers)] = np.nan
        common_s = np.zeros(late_s.shape[:2]) if trials.pacers else finite_mean(late_s, 2)

        # In free time the common time says nothing; its mean would only add rounding to the differences.
        own_s = late_s - common_s[..., None]
        self._differences = not (trials.pacers or trials.time == "music" or (matrix and trials.expects_time))
        self._differences &= trials.time != "steady"
        kept_s = late_s if trials.time == "music" or not self._differences else own_s

        self.means_s = finite_mean(late_s if trials.time == "music" else own_s, (0, 1))
        """(D,) constant lateness of each dancer [s]; NaN for a pacer."""

        centred_s = kept_s - self.means_s
        self.unit_s = max(float(np.nanstd(own_s - finite_mean(own_s, (0, 1)))), 1e-6)
        """Typical deviation of a dancer from the group, the unit of the parameters [s]."""

        self._filter = PhaseFilter(centred_s / self.unit_s)
        self._common = float(np.nanstd(finite_mean(centred_s, 2))) / self.unit_s
        sessions, self.session = np.unique(trials.session, return_inverse=True)
        self._iterations_differ = trials.time == "music" and len(late_s) >= SPREAD_FROM
        self._groups_differ = self._iterations_differ and SPREAD_FROM <= len(sessions) < len(late_s)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the vector's entries."""
        pairs = [(i, j) for i in self.correcting for j in range(self.dancers) if i != j]
        gains = [f"coupling[{i + 1}][{j + 1}]" for i, j in pairs] if self.matrix else ["coupling"]
        # The last dancer's scale follows from the others'.
        scales = [f"scale[{i + 1}]" for i in self.correcting[:-1]] if self.each else []
        common: list[str] = []
        if self.trials.time == "music":
            common = ["common_s", "common_correlation"]
        elif self.trials.time == "free" and not (self._differences or self.trials.pacers):
            common = ["tempo_s"]
        spreads = ["iteration_spread"] * self._iterations_differ + ["group_spread"] * self._groups_differ
        return ("timekeeper_s", "motor_s", *gains, *scales, *common, *spreads)

    def starts(self) -> list[Array]:
        """Parameters, (P,) each, from which the optimisation starts.

        Strong correction of much motor noise resembles weak correction of little, so both are tried.
        """
        guesses = {
            "common_s": self._common**2, "common_correlation": 0.5, "tempo_s": 0.5,
            "iteration_spread": 0.1, "group_spread": 0.05, "scale": 0.0,
        }  # fmt: skip
        most = self.bounds()[self.names.index("timekeeper_s") + 2][1]
        variants = (
            {"timekeeper_s": 0.6, "motor_s": 0.15, "coupling": 0.25 * most},
            {"timekeeper_s": 0.15, "motor_s": 0.4, "coupling": 0.12 * most},
            {"timekeeper_s": 0.5, "motor_s": 0.3, "coupling": 0.5 * most},
        )
        return [
            np.array([{**guesses, **variant}[name.partition("[")[0]] for name in self.names]) for variant in variants
        ]

    def bounds(self) -> Bounds:
        """Lower and upper bound of each entry.

        Gains may be a little negative, so that the intervals of people who do not correct include 0.
        """
        # Above the upper bound asynchronies grow; a single tapper and a metronome allow a gain of 1 and more.
        most = 2.0 / self.dancers if len(self.correcting) > 1 else 1.0
        limits = {
            "timekeeper_s": (1e-6, 1e3),
            "motor_s": (0.0, 1e3),
            "common_s": (1e-6, 1e6),
            "common_correlation": (0.0, 0.999),
            "tempo_s": (0.0, 1e6),
            "coupling": (-0.9, 0.9) if self.matrix else (-0.5 * most, most),
            "scale": (-3.0, 3.0),
            "iteration_spread": (0.0, 1.0),
            "group_spread": (0.0, 0.5),
        }
        return [limits[name.partition("[")[0]] for name in self.names]

    def gains(self, values: Mapping[str, float]) -> Array:
        """(D, D) share of its lead over each other dancer that each dancer corrects; pacers correct nothing.

        Args:
            values: entries by name.
        """
        gains = np.zeros((self.dancers, self.dancers))
        if not self.matrix:
            gains[list(self.correcting)] = values["coupling"]
            np.fill_diagonal(gains, 0.0)
            return gains

        for name, value in values.items():
            if name.startswith("coupling["):
                i, j = (int(part.rstrip("]")) - 1 for part in name.split("[")[1:])
                gains[i, j] = value
        return gains

    def scales(self, values: Mapping[str, float]) -> Array:
        """(D,) factors of the dancers' noise: 0 for pacers; the logarithms of the others add up to 0.

        Args:
            values: entries by name; those of scales are logarithms.
        """
        scales = np.zeros(self.dancers)
        logarithms = np.zeros(len(self.correcting))
        if self.each:
            logarithms[:-1] = [value for name, value in values.items() if name.startswith("scale[")]
            logarithms[-1] = -logarithms[:-1].sum()
        scales[list(self.correcting)] = np.exp(logarithms)
        return scales

    def cost(self, vector: Array) -> float:
        """Minus the log likelihood, without constants.

        Args:
            vector: (P,) the entries.
        """
        values = dict(zip(self.names, map(float, vector), strict=True))
        gains = self.gains(values)
        phase = np.diag(gains.sum(axis=1)) - gains

        distance, log_det = self._filter.evaluate(phase, self._noise(values))
        if not (np.isfinite(log_det).all() and np.isfinite(distance).all()):
            return IMPOSSIBLE_COST
        iteration_spread = values.get("iteration_spread", 0.0)
        group_spread = values.get("group_spread", 0.0)
        return 0.5 * float(log_det.sum()) - self._log_mixture(distance, iteration_spread, group_spread)

    def _noise(self, values: Mapping[str, float]) -> Noise:
        """Noise of the model, with variances of `FREE_SD` squared for what is left free."""
        squared_scales = self.scales(values) ** 2
        timekeeper = values["timekeeper_s"] * squared_scales
        free_first = np.where(squared_scales > 0.0, FREE_SD**2, 0.0)
        # The tempo of each trial is left free, since estimates of it would take some of the noise away.
        rate = not (self.trials.time == "music" or self._differences or self.trials.pacers)
        free_common = FREE_SD**2 if rate or self._differences else 0.0
        return Noise(
            timekeeper=timekeeper,
            first=timekeeper if self.trials.time == "music" or rate else free_first,
            motor=values["motor_s"] * squared_scales,
            tempo=values.get("tempo_s", 0.0),
            common=values.get("common_s", free_common),
            correlation=values.get("common_correlation", float(rate)),
            rate=float(rate),
        )

    def _log_mixture(self, distance: Array, iteration_spread: float, group_spread: float) -> float:
        """Log likelihood without determinants, summed over the noise scales that iterations and groups may have."""
        if not self._iterations_differ:
            return -0.5 * float(distance.sum())

        group_grid = GROUP_GRID if self._groups_differ else np.zeros(1)
        weights = _log_normal_weights(ITERATION_GRID)
        group_weights = _log_normal_weights(group_grid)

        # Subtracting half the variance gives log-normal scales a mean of 1.
        log_scale = iteration_spread * ITERATION_GRID - iteration_spread**2 / 2
        by_group = np.empty((len(group_grid), self.session.max() + 1))
        for g, node in enumerate(group_grid):
            log_s = log_scale + group_spread * node - group_spread**2 / 2
            densities = log_mixture(distance, self._filter.counts, log_s, weights)
            by_group[g] = np.bincount(self.session, densities)
        return float(logsumexp(by_group + group_weights[:, None], axis=0).sum())


def _log_normal_weights(grid: Array) -> Array:
    """(G,) logarithms of the weights of a standard normal distribution on a grid, which add up to 1."""
    exponent = -(grid**2) / 2
    return np.asarray(exponent - logsumexp(exponent))
