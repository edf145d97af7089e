#!/usr/bin/env python3
"""Measure how often each test rejects in studies without a difference: a table of shares, which should be 5 %.

python scripts/type_one_error.py --studies 500 --groups 9
python scripts/type_one_error.py --studies 500 --groups 9 --method eca --humans paper-warmup --jobs 2
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace

import numpy as np
import tyro
from joblib import Parallel, delayed
from rich.console import Console
from rich.table import Table

from sjasim.analysis.error_rates import RECOMMENDED, rejection_shares
from sjasim.config import SessionConfig
from sjasim.core import Array
from sjasim.studies.null_studies import null_studies

LIMITS = (0.03, 0.07)
"""Allowed shares of the recommended test at level .05."""


@dataclass(frozen=True)
class Options:
    """Options of this script.

    Attributes:
        studies: number of studies.
        groups: number of groups in each.
        method: method of both sessions of a group.
        humans: human timing model.
        seed: seed of the first group.
        jobs: number of processes.
    """

    studies: int = 500
    groups: int = 9
    method: str = "sia"
    humans: str = "paper-entrainment"
    seed: int = 1_000_000
    jobs: int = 1


def main(options: Options) -> int:
    """Simulate the studies, print the table, and return 1 if the recommended test misses the limits."""
    table = Table(title=f"{options.studies} studies of {options.groups} groups without a difference, level .05")
    for column in ("measure", "test", "rejects", "95 % interval"):
        table.add_column(column)

    met = True
    rng = np.random.default_rng(options.seed)
    for measure, values in simulate(options).items():
        for test, row in rejection_shares(values, rng).items():
            # An index has one value for each iteration, so the iterations are its events.
            if measure == "GSI" and test.startswith("events"):
                continue
            table.add_row(measure, test, f"{row['share']:.3f}", f"{row['low']:.3f} to {row['high']:.3f}")
            met = met and (test != RECOMMENDED or LIMITS[0] <= row["share"] <= LIMITS[1])
    Console().print(table)
    return 0 if met else 1


def simulate(options: Options) -> dict[str, Array]:
    """Timing appropriateness and group synchronisation index of all studies; see `NullStudies`."""
    config = SessionConfig(method=options.method, humans=options.humans, fidelity="timing")
    seeds = range(options.seed, options.seed + options.studies * options.groups, options.groups)
    one = delayed(null_studies)
    parts = Parallel(n_jobs=options.jobs)(one(replace(config, seed=seed), 1, options.groups) for seed in seeds)
    return {
        "TA": np.concatenate([part.ta_s for part in parts]),
        "GSI": np.concatenate([part.gsi for part in parts]),
    }


if __name__ == "__main__":
    sys.exit(main(tyro.cli(Options, description=__doc__)))
