"""Fit the people of the presets paper-entrainment and paper-warmup to the published study.

The study is simulated many times in fidelity timing, with groups whose seeds are those of tuning. The cost is the sum
over the fitted values of the squared distance between the published value and the simulated mean, in units of the
standard deviation between simulated studies. Held-out values are not used. Run, for example:

    python scripts/fit_presets.py paper-entrainment --studies 20 --evaluations 60
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from sjasim.analysis.published_values import PUBLISHED, study_arrays
from sjasim.humans.timing.parameters import TimingParameters, parameters_toml, preset
from sjasim.studies.paper_reproduction import HYPOTHESES, study_design
from sjasim.studies.reproduction_options import ReproductionOptions
from sjasim.studies.study_execution import run_study

FREE = {
    "paper-entrainment": ("timekeeper_s", "iteration_spread", "common_s", "entrainment", "lapse"),
    "paper-warmup": ("timekeeper_s", "iteration_spread", "common_s", "practice", "lapse"),
}
"""Preset -> parameters that are fitted; the others keep the values of the preset."""

STUDY_SD = {
    "gsi_mean": 0.027, "gsi_rise": 0.038, "gsi_sd_within_groups": 0.014, "gsi_sd_group_means": 0.019,
    "ta_mean_s": 0.065, "ta_within_0.8_s": 0.03, "ta_within_1.2_s": 0.03, "ta_within_1.6_s": 0.027,
}  # fmt: skip
"""Fitted value -> its standard deviation between simulated studies, which changes little with the parameters."""

STEP = 1.15
"""Factor by which the first simplex changes each parameter."""


class Fit:
    """Cost of parameters, with the best ones so far.

    Args:
        name: name of the preset.
        studies: number of simulated studies for each evaluation; all evaluations use the same groups.
        seed: seed of the groups.
    """

    def __init__(self, name: str, studies: int, seed: int) -> None:
        self._start = preset(name)
        self._free = FREE[name]
        options = ReproductionOptions(humans=name, studies=studies, seed=seed)
        self._design = study_design(options, seeds="tuning")
        assert dict(self._design.session.method_options) == dict(HYPOTHESES.get(name, {}))
        self.best = (np.inf, self._start)

    @property
    def start(self) -> np.ndarray:
        """(P,) parameters of the preset."""
        return np.array([getattr(self._start, field) for field in self._free])

    def cost(self, values: np.ndarray) -> float:
        """Sum of the squared distances of the fitted values, each in its standard deviation between studies."""
        if (values < 0.0).any():
            return 1e6
        people = replace(self._start, **dict(zip(self._free, values.tolist(), strict=True)))
        distances = self._distances(people)
        cost = float(np.square(distances).sum())
        if cost < self.best[0]:
            self.best = (cost, people)
            print(f"{cost:.2f}", dict(zip(self._free, values.round(4).tolist(), strict=True)), flush=True)
        return cost

    def _distances(self, people: TimingParameters) -> np.ndarray:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "people.toml"
            path.write_text(parameters_toml(people), encoding="utf-8")
            studies = study_arrays(run_study(replace(self._design, humans=(str(path),))))
        fitted = [value for value in PUBLISHED if value.role == "fitted"]
        return np.array([(np.nanmean(value.compute(studies)) - value.value) / STUDY_SD[value.name] for value in fitted])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("preset", choices=sorted(FREE))
    parser.add_argument("--studies", type=int, default=20, help="simulated studies for each evaluation")
    parser.add_argument("--evaluations", type=int, default=60, help="largest number of evaluations")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()

    fit = Fit(arguments.preset, arguments.studies, arguments.seed)
    start = fit.start
    simplex = np.array([start] + [np.where(np.arange(len(start)) == k, STEP * start, start) for k in range(len(start))])
    options = {"maxfev": arguments.evaluations, "initial_simplex": simplex, "xatol": 0.002, "fatol": 0.1}
    minimize(fit.cost, start, method="Nelder-Mead", options=options)
    print(parameters_toml(fit.best[1]))


if __name__ == "__main__":
    main()
