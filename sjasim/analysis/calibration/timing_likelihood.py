"""Likelihood of trials under the human timing model, as a function of a parameter vector."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from ...core import Array
from ...humans.timing.parameters import TimingParameters
from .kalman_likelihood import Noise, PhaseFilter, log_mixture
from .optimisation import Bounds
from .tapping_trials import TappingTrials, finite_mean

SPREAD_FROM = 8
"""Fewest iterations for a fitted spread between iterations, and fewest groups for one between groups."""

FREE_COMMON_SD = 100.0
"""Standard deviation of a common shift that is left free, in typical deviations."""

IMPOSSIBLE_COST = 1e12
"""Cost of parameters under which an event would have a variance of 0 or less."""

ITERATION_GRID = 4.2 * np.linspace(-1.0, 1.0, 31)
"""Standardised log scales of iterations over which the likelihood is summed."""

GROUP_GRID = 3.2 * np.linspace(-1.0, 1.0, 7)
"""Standardised log scales of groups over which the likelihood is summed."""


class TimingLikelihood:
    """Cost (minus the log likelihood) of trials over a parameter vector, in units of the typical deviation.

    Noises are entries as variances. The likelihood is nearly quadratic in a variance, so that its curvature gives a
    confidence interval even at a variance of 0. Spreads count by their absolute value.

    Args:
        trials: the data.
        matrix: whether each pair of dancers has its own coupling.
        each: whether each dancer has its own scale of noise.
    """

    def __init__(self, trials: TappingTrials, matrix: bool, each: bool) -> None:
        self.trials = trials
        self.matrix = matrix
        self.each = each

        late_s = trials.late_s
        self.means_s = finite_mean(late_s, (0, 1))
        """(D,) constant lateness of each dancer [s]."""

        centred_s = late_s - self.means_s
        common_s = finite_mean(centred_s, 2)
        own_s = centred_s - common_s[..., None]
        self.unit_s = max(float(np.nanstd(own_s)), 1e-6)
        """Typical deviation of a dancer from the group, the unit of the parameters [s]."""

        self.dancers: int = late_s.shape[2]
        self._filter = PhaseFilter(centred_s / self.unit_s)
        self._common = float(np.nanstd(common_s)) / self.unit_s
        sessions, self.session = np.unique(trials.session, return_inverse=True)
        self._iterations_differ = trials.music and len(late_s) >= SPREAD_FROM
        self._groups_differ = self._iterations_differ and SPREAD_FROM <= len(sessions) < len(late_s)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the vector's entries."""
        pairs = [(i, j) for i in range(self.dancers) for j in range(self.dancers) if i != j]
        gains = [f"coupling[{i + 1}][{j + 1}]" for i, j in pairs] if self.matrix else ["coupling"]
        # The last dancer's scale follows from the others'.
        scales = [f"scale[{i + 1}]" for i in range(self.dancers - 1)] if self.each else []
        common = ["common_s", "common_correlation"] if self.trials.music else []
        spreads = ["iteration_spread"] * self._iterations_differ + ["group_spread"] * self._groups_differ
        return ("timekeeper_s", "motor_s", *gains, *scales, *common, *spreads)

    def start(self) -> Array:
        """(P,) parameters from which the optimisation starts."""
        guesses = {
            "timekeeper_s": 0.6, "motor_s": 0.15, "common_s": self._common**2, "common_correlation": 0.5,
            "iteration_spread": 0.1, "group_spread": 0.05, "scale": 0.0,
            "coupling": 0.5 / self.dancers,
        }  # fmt: skip
        return np.array([guesses[name.partition("[")[0]] for name in self.names])

    def bounds(self) -> Bounds:
        """Lower and upper bound of each entry."""
        limits = {
            "timekeeper_s": (1e-6, 1e3),
            "motor_s": (0.0, 1e3),
            "common_s": (1e-6, 1e6),
            "common_correlation": (0.0, 0.999),
            "coupling": (-0.9, 0.9) if self.matrix else (0.0, 2.0 / self.dancers),
            "scale": (-3.0, 3.0),
            "iteration_spread": (-1.0, 1.0),
            "group_spread": (-0.5, 0.5),
        }
        return [limits[name.partition("[")[0]] for name in self.names]

    def gains(self, values: Mapping[str, float]) -> Array:
        """(D, D) share of its lead over each other dancer that each dancer corrects.

        Args:
            values: entries by name.
        """
        if not self.matrix:
            coupling = min(max(values["coupling"], 0.0), 1.0)
            return TimingParameters(coupling=coupling).coupling_gains(self.dancers)

        gains = np.zeros((self.dancers, self.dancers))
        for name, value in values.items():
            if name.startswith("coupling["):
                i, j = (int(part.rstrip("]")) - 1 for part in name.split("[")[1:])
                gains[i, j] = value
        return gains

    def scales(self, values: Mapping[str, float]) -> Array:
        """(D,) factors of the dancers' noise; their logarithms add up to 0.

        Args:
            values: entries by name; those of scales are logarithms.
        """
        if not self.each:
            return np.ones(self.dancers)
        logarithms = np.array([value for name, value in values.items() if name.startswith("scale[")])
        return np.asarray(np.exp(np.append(logarithms, -logarithms.sum())))

    def cost(self, vector: Array) -> float:
        """Minus the log likelihood, without constants.

        Args:
            vector: (P,) the entries.
        """
        values = dict(zip(self.names, map(float, vector), strict=True))
        gains = self.gains(values)
        phase = np.diag(gains.sum(axis=1)) - gains

        distance, log_det = self._filter.evaluate(phase, self._noise(values))
        if not np.isfinite(log_det).all():
            return IMPOSSIBLE_COST
        iteration_spread = values.get("iteration_spread", 0.0)
        group_spread = values.get("group_spread", 0.0)
        return 0.5 * float(log_det.sum()) - self._log_mixture(distance, iteration_spread, group_spread)

    def _noise(self, values: Mapping[str, float]) -> Noise:
        """Noise of the model; in free time, first deviations and the common shift are left free."""
        squared_scales = self.scales(values) ** 2
        timekeeper = values["timekeeper_s"] * squared_scales
        music = self.trials.music
        return Noise(
            timekeeper=timekeeper,
            first=timekeeper if music else np.full(self.dancers, FREE_COMMON_SD**2),
            motor=values["motor_s"] * squared_scales,
            common=values["common_s"] if music else FREE_COMMON_SD**2,
            correlation=values.get("common_correlation", 0.0),
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
