#!/usr/bin/env python3
"""How well dancers move, on people who never served for tuning: a table of figures, targets and verdicts.

python scripts/evaluate_dancers.py --first-seed 9501 --dances 30
python scripts/evaluate_dancers.py --first-seed 9411 --dances 10 --only free
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator

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

FREE = BodyConfig(FULL_RANGE.model, FULL_RANGE.stature_m, FULL_RANGE.mass_kg, balance_support="none")
PUSH_NS = 20.0
SIDES = {"ahead": 0.0, "the left": math.pi / 2, "behind": math.pi, "the right": -math.pi / 2}
MOVES_S = (0.8, 2.0, 3.0)
Row = tuple[str, float, str, bool]


def at_most(name: str, value: float, limit: float) -> Row:
    """A row of the table."""
    return name, value, f"at most {limit:g}", value <= limit


def at_least(name: str, value: float, limit: float) -> Row:
    """A row of the table."""
    return name, value, f"at least {limit:g}", value >= limit


def crossings(name: str, found: dict[str, float]) -> Iterator[Row]:
    """Whether bodies start and stop when they planned to."""
    yield at_most(f"{name}: starts and stops missing", found["crossings_missing"], 0)
    yield at_most(f"{name}: starts and stops, |bias| (ms)", abs(found["crossing_bias_ms"]), 10)
    yield at_most(f"{name}: starts and stops, p95 (ms)", found["crossing_p95_ms"], 33)


def dances(seeds: range, pool: Parallel) -> Iterator[Row]:
    """Whole dances with the weak tether."""
    found = motion_figures(pool(delayed(dance_trial)(seed) for seed in seeds))
    yield at_least("dances without a fall", found["dances_without_a_fall"], len(seeds))
    yield at_most("worst dancer's mean pelvis error (mm)", found["pelvis_error_mean_mm"], 25)
    yield at_most("worst dancer's tether rms (N)", found["tether_rms_n"], 20)
    yield at_least("least share of weight on the feet", found["feet_load_share"], 0.99)
    yield from crossings("dance", found)
    yield at_most("claps missing", found["claps_missing"], 0)
    yield at_most("hands meet, p95 (ms)", found["clap_p95_ms"], 20)
    yield at_most("rise from .05 to .25 m/s, p95 (s)", found["rise_p95_s"], 0.35)
    yield at_most("slip of a standing foot, median (mm)", found["slip_median_mm"], 5)


def moves(seeds: range, pool: Parallel) -> Iterator[Row]:
    """Moves of given times."""
    for duration_s in MOVES_S:
        found = motion_figures(pool(delayed(timed_moves_trial)(seed, duration_s) for seed in seeds))
        yield from crossings(f"moves of {duration_s:g} s", found)


def pushes(seeds: range, pool: Parallel) -> Iterator[Row]:
    """Sideways pushes."""
    for walking in (False, True):
        falls = sum(pool(delayed(count_falls_after_push)(seed, PUSH_NS, walking=walking) for seed in seeds))
        what = "walking" if walking else "standing"
        yield at_most(f"falls of {3 * len(seeds)} {what}, pushed by {PUSH_NS:g} Ns", falls, 0)


def robot(seeds: range, pool: Parallel) -> Iterator[Row]:
    """A robot at .5 m/s into a standing dancer."""
    for side, bearing in SIDES.items():
        hits = pool(delayed(collision_trial)(seed, bearing) for seed in seeds)
        yield at_most(f"robot from {side}: peak force (N)", max(hit.peak_n for hit in hits), 300)
        yield at_most(f"robot from {side}: falls", sum(hit.falls for hit in hits), 0)
        yield at_most(f"robot from {side}: its speed after (m/s)", max(hit.speed_m_s for hit in hits), 0.25)
        yield at_least(f"robot from {side}: sway of the dancer (mm)", 1e3 * min(hit.sway_m for hit in hits), 0.5)


def free(seeds: range, pool: Parallel) -> Iterator[Row]:
    """Whole dances without a tether."""
    found = motion_figures(pool(delayed(dance_trial)(seed, body=FREE) for seed in seeds))
    yield at_least("free dances without a fall", found["dances_without_a_fall"], len(seeds) / 2)
    yield at_most("free: dancers who fell", found["falls"], math.inf)
    yield at_most("free: worst dancer's mean pelvis error (mm)", found["pelvis_error_mean_mm"], math.inf)
    yield at_most("free: slip, median (mm)", found["slip_median_mm"], math.inf)


PARTS: dict[str, Callable[[range, Parallel], Iterator[Row]]] = {
    "dances": dances, "moves": moves, "pushes": pushes, "robot": robot, "free": free,
}  # fmt: skip


def main() -> int:
    """Dance, push, drive, print; 1 if a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first-seed", type=int, default=9501)
    parser.add_argument("--dances", type=int, default=30, help="how many seeds, each with three people of any build")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds = range(options.first_seed, options.first_seed + options.dances)
    pool = Parallel(n_jobs=options.jobs)
    rows = [row for part in options.only for row in PARTS[part](seeds, pool)]
    if options.json:
        keys = ("figure", "value", "target", "met")
        sys.stdout.write(
            json.dumps([dict(zip(keys, row, strict=True)) for row in rows], indent=1, default=float) + "\n"
        )
    else:
        table = Table("figure", "value", "target", "", title=f"seeds {seeds.start} to {seeds.stop - 1}")
        for name, value, target, met in rows:
            table.add_row(name, f"{value:.4g}", target if "inf" not in target else "", "" if met else "MISSED")
        Console(width=100).print(table)
    return 0 if all(met for *_, met in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
