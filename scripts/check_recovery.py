#!/usr/bin/env python3
"""Check that the fit recovers the published timing model from an independent simulator, and print bias and coverage.

The simulator is written from the published equation and shares no code with sjasim. Each line of the table is a regime:
mean estimate minus truth, relative to the truth, and the share of 95 % intervals that contain the truth.

python scripts/check_recovery.py --groups 100
python scripts/check_recovery.py --groups 100 --time free
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from typing import Literal, NamedTuple

# Many small matrices: threads of the linear algebra would only get in each other's way.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import tyro
from joblib import Parallel, delayed

from sjasim.analysis.calibration.timing_fit import fit_trials
from sjasim.analysis.calibration.trials import arrange_trials
from sjasim.core import Array, Kind
from sjasim.core.session_log import TableEvent

PERIOD_S = 0.5
"""Period of the simulated timekeepers [s]."""

NAMES = ("timekeeper_s", "motor_s", "coupling")
"""Parameters of the published model."""


class Regime(NamedTuple):
    """Simulated groups: their size, noise [s] and coupling, and how much of them is recorded."""

    people: int
    timekeeper_s: float
    motor_s: float
    coupling: float
    takes: int = 8
    events: int = 60


REGIMES = (
    Regime(2, 0.020, 0.010, 0.1),
    Regime(2, 0.015, 0.020, 0.4),
    Regime(3, 0.020, 0.010, 0.2),
    Regime(3, 0.015, 0.020, 0.2),
    Regime(3, 0.025, 0.005, 0.3),
    Regime(4, 0.020, 0.010, 0.4),
    Regime(4, 0.015, 0.020, 0.1),
    Regime(3, 0.020, 0.010, 0.2, takes=4, events=30),
    Regime(2, 0.020, 0.010, 0.2, takes=2, events=60),
)
"""Regimes that are checked."""


@dataclass(frozen=True)
class Options:
    """Recovery of known parameters.

    Attributes:
        groups: number of simulated groups of each regime.
        time: what the fit assumes of the tempo: steady, as in the published model, or free.
        seed: seed of the first group.
        jobs: number of processes.
    """

    groups: int = 100
    time: Literal["steady", "free"] = "steady"
    seed: int = 0
    jobs: int = 2


def simulate_take(regime: Regime, rng: np.random.Generator) -> Array:
    """Return the (E, D) event times of one take [s].

    t_i(k+1) = t_i(k) + P - sum_j a (t_i(k) - t_j(k)) + T_i(k) + M_i(k+1) - M_i(k). Source: wing2014, eq. (1).
    """
    motor = rng.normal(0.0, regime.motor_s, regime.people)
    times = rng.normal(0.0, regime.timekeeper_s, regime.people) + motor
    rows = [times]
    for _ in range(regime.events - 1):
        before = motor
        motor = rng.normal(0.0, regime.motor_s, regime.people)
        timekeeper = rng.normal(0.0, regime.timekeeper_s, regime.people)
        asynchrony = regime.coupling * (times[:, None] - times[None, :]).sum(axis=1)
        times = times + PERIOD_S - asynchrony + timekeeper + motor - before
        rows.append(times)
    return np.array(rows) + 2.0


def fit_group(regime: Regime, time: str, seed: int) -> Array:
    """Return the (3, 3) value, lower and upper end of each parameter of `NAMES`, fitted to one simulated group."""
    rng = np.random.default_rng([seed, *np.frombuffer(repr(regime).encode(), np.uint8)])
    events = [
        TableEvent(f"take {take}", 1, f"person_{person + 1}", Kind.CLAP, float(t_s), False, 1)
        for take in range(regime.takes)
        for row in simulate_take(regime, rng)
        for person, t_s in enumerate(row)
    ]
    fit = fit_trials(arrange_trials(events, None, steady=time == "steady"))
    estimates = [fit.estimates[name] for name in NAMES]
    return np.array([[estimate.value, estimate.low, estimate.high] for estimate in estimates])


def summary(regime: Regime, fits: Array) -> tuple[Array, Array]:
    """Return the (3,) relative bias and (3,) coverage of the 95 % intervals.

    Args:
        regime: with the true values.
        fits: (G, 3, 3) fits of all groups, as `fit_group` returns them.
    """
    truth = np.array([getattr(regime, name) for name in NAMES])
    bias = fits[:, :, 0].mean(axis=0) / truth - 1.0
    coverage = ((fits[:, :, 1] <= truth) & (truth <= fits[:, :, 2])).mean(axis=0)
    return bias, coverage


def main(options: Options) -> None:
    """Fit all groups of all regimes, and print a line for each regime."""
    sys.stdout.write(
        "people takes events timekeeper motor coupling |  bias [%]: tk  motor   coup | coverage: tk motor coup\n"
    )
    for regime in REGIMES:
        seeds = range(options.seed, options.seed + options.groups)
        work = [delayed(fit_group)(regime, options.time, seed) for seed in seeds]
        bias, coverage = summary(regime, np.array(Parallel(n_jobs=options.jobs)(work)))
        shown = (
            f"{regime.people:6} {regime.takes:5} {regime.events:6} {regime.timekeeper_s:10.3f} {regime.motor_s:5.3f}"
        )
        shown += f" {regime.coupling:8.2f} |  " + " ".join(f"{100 * value:+10.1f}"[2:] for value in bias)
        sys.stdout.write(f"{shown} | " + " ".join(f"{value:6.2f}" for value in coverage) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
