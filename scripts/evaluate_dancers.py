#!/usr/bin/env python3
"""Evaluate how dancers move, with seeds that were not used for tuning: a table of figures and their targets.

python scripts/evaluate_dancers.py --first-seed 9501 --dances 30
python scripts/evaluate_dancers.py --first-seed 9411 --dances 10 --only free
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator
from typing import NamedTuple

from joblib import Parallel, delayed
from rich.console import Console
from rich.table import Table

from sjasim.config import BodyConfig
from sjasim.simulation.motion_recording import motion_figures
from sjasim.simulation.motion_trials import (
    FULL_RANGE,
    collision_trial,
    count_falls_after_push,
    dance_trial,
    timed_moves_trial,
)

UNSUPPORTED = BodyConfig(FULL_RANGE.model, FULL_RANGE.stature_m, FULL_RANGE.mass_kg, balance_support="none")
"""Bodies without balance support."""

PUSH_NS = 20.0
"""Impulse of a push."""

DIRECTIONS_RAD = {"ahead": 0.0, "the left": math.pi / 2, "behind": math.pi, "the right": -math.pi / 2}
"""Directions from which the robot comes, relative to the dancer's heading."""

MOVES_S = (0.8, 2.0, 3.0)
"""Durations of the timed moves."""


class Row(NamedTuple):
    """One row of the table.

    Attributes:
        figure: name of the figure.
        value: its value.
        target: the target, as text.
        met: whether the target is reached.
    """

    figure: str
    value: float
    target: str
    met: bool


def at_most(name: str, value: float, limit: float) -> Row:
    """Return the row of a figure whose target is an upper limit; an infinite limit is no target."""
    return Row(name, value, f"at most {limit:g}", value <= limit)


def at_least(name: str, value: float, limit: float) -> Row:
    """Return the row of a figure whose target is a lower limit."""
    return Row(name, value, f"at least {limit:g}", value >= limit)


def start_and_stop_rows(name: str, found: dict[str, float]) -> Iterator[Row]:
    """Yield how well starts and stops of the bodies agree with the plan."""
    yield at_most(f"{name}: starts and stops missing", found["crossings_missing"], 0)
    yield at_most(f"{name}: starts and stops, |bias| (ms)", abs(found["crossing_bias_ms"]), 10)
    yield at_most(f"{name}: starts and stops, p95 (ms)", found["crossing_p95_ms"], 33)


def dance_rows(seeds: range, pool: Parallel) -> Iterator[Row]:
    """Yield figures of whole dances with the weak balance support."""
    found = motion_figures(pool(delayed(dance_trial)(seed) for seed in seeds))
    yield at_least("dances without a fall", found["dances_without_a_fall"], len(seeds))
    yield at_most("worst dancer's mean pelvis error (mm)", found["pelvis_error_mean_mm"], 25)
    yield at_most("worst dancer's balance support force, rms (N)", found["tether_rms_n"], 20)
    yield at_least("least share of weight on the feet", found["feet_load_share"], 0.99)
    yield from start_and_stop_rows("dance", found)
    yield at_most("claps missing", found["claps_missing"], 0)
    yield at_most("hands meet, p95 (ms)", found["clap_p95_ms"], 20)
    yield at_most("rise from .05 to .25 m/s, p95 (s)", found["rise_p95_s"], 0.35)
    yield at_most("slip of a standing foot, median (mm)", found["slip_median_mm"], 5)


def move_rows(seeds: range, pool: Parallel) -> Iterator[Row]:
    """Yield figures of moves of given durations."""
    for duration_s in MOVES_S:
        found = motion_figures(pool(delayed(timed_moves_trial)(seed, duration_s) for seed in seeds))
        yield from start_and_stop_rows(f"moves of {duration_s:g} s", found)


def push_rows(seeds: range, pool: Parallel) -> Iterator[Row]:
    """Yield the number of falls after sideways pushes."""
    for walking in (False, True):
        falls = sum(pool(delayed(count_falls_after_push)(seed, PUSH_NS, walking=walking) for seed in seeds))
        state = "walking" if walking else "standing"
        yield at_most(f"falls of {3 * len(seeds)} {state} dancers after a push of {PUSH_NS:g} Ns", falls, 0)


def collision_rows(seeds: range, pool: Parallel) -> Iterator[Row]:
    """Yield figures of a robot that drives into a standing dancer at 0.5 m/s."""
    for side, direction_rad in DIRECTIONS_RAD.items():
        hits = pool(delayed(collision_trial)(seed, direction_rad) for seed in seeds)
        yield at_most(f"robot from {side}: peak force (N)", max(hit.peak_n for hit in hits), 300)
        yield at_most(f"robot from {side}: falls", sum(hit.falls for hit in hits), 0)
        yield at_most(f"robot from {side}: its speed after (m/s)", max(hit.speed_m_s for hit in hits), 0.25)
        yield at_least(f"robot from {side}: sway of the dancer (mm)", 1e3 * min(hit.sway_m for hit in hits), 0.5)


def unsupported_rows(seeds: range, pool: Parallel) -> Iterator[Row]:
    """Yield figures of whole dances without balance support, most of them without a target."""
    found = motion_figures(pool(delayed(dance_trial)(seed, body=UNSUPPORTED) for seed in seeds))
    yield at_least("free dances without a fall", found["dances_without_a_fall"], len(seeds) / 2)
    yield at_most("free: dancers who fell", found["falls"], math.inf)
    yield at_most("free: worst dancer's mean pelvis error (mm)", found["pelvis_error_mean_mm"], math.inf)
    yield at_most("free: slip, median (mm)", found["slip_median_mm"], math.inf)


PARTS: dict[str, Callable[[range, Parallel], Iterator[Row]]] = {
    "dances": dance_rows,
    "moves": move_rows,
    "pushes": push_rows,
    "robot": collision_rows,
    "free": unsupported_rows,
}
"""Part of the evaluation to the function that yields its rows."""


def print_rows(rows: list[Row], title: str) -> None:
    """Print the rows as a table."""
    table = Table("figure", "value", "target", "", title=title)
    for row in rows:
        target = row.target if "inf" not in row.target else ""
        table.add_row(row.figure, f"{row.value:.4g}", target, "" if row.met else "MISSED")
    Console(width=100).print(table)


def main() -> int:
    """Evaluate and print; return 1 if a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first-seed", type=int, default=9501, help="seed of the first group")
    parser.add_argument("--dances", type=int, default=30, help="number of seeds; each has three dancers of any build")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), help="parts of the evaluation")
    parser.add_argument("--jobs", type=int, default=1, help="number of processes")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    options = parser.parse_args()

    seeds = range(options.first_seed, options.first_seed + options.dances)
    pool = Parallel(n_jobs=options.jobs)
    rows = [row for part in options.only for row in PARTS[part](seeds, pool)]

    if options.json:
        # Figures may be numpy scalars, which only `float` makes writable.
        sys.stdout.write(json.dumps([row._asdict() for row in rows], indent=1, default=float) + "\n")
    else:
        print_rows(rows, f"seeds {seeds.start} to {seeds.stop - 1}")
    return 0 if all(row.met for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
