"""Measure depth sensing on bodies, seeds and layouts that its training never saw; a table, or JSON.

python scripts/evaluate_skeleton.py --dances 4
python scripts/evaluate_skeleton.py --only facing yaw_90 --json
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from typing import Any

import numpy as np

from sjasim.skeleton_training import report, trials
from sjasim.skeleton_training.crossings import crossing_errors, occlusion_errors
from sjasim.skeleton_training.trials import Trial

CONDITIONS: dict[str, dict[str, Any]] = {
    "facing": {},
    "extreme_builds": {"edge": True},
    "yaw_45": {"facing_rad": math.radians(45)},
    "yaw_-45": {"facing_rad": math.radians(-45)},
    "yaw_90": {"facing_rad": math.radians(90)},
    "yaw_-90": {"facing_rad": math.radians(-90)},
    "behind": {"facing_rad": math.pi},
    "turning": {"turns": True},
    "aligned_rows": {"aligned": True},
    "512_columns": {"width_px": 512},
}
"""Name -> what is special about its trials."""

TARGETS_CM = {
    "facing": (1.7, 5.0), "extreme_builds": (3.0, 8.0), "yaw_45": (2.2, 8.0), "yaw_-45": (2.2, 8.0),
    "yaw_90": (4.0, 15.0), "yaw_-90": (4.0, 15.0),
}  # fmt: skip
"""Name -> median and p95 error of visible joints to reach [cm]; with them 98 % tracked, no swap, a SpineBase that
shakes by .05 cm, 6 ms a frame, no event missed, 1 % false, and 33 ms."""


def figures(name: str, dances: int, seed: int) -> dict[str, Any]:
    """All figures of one condition."""
    outcomes = [trials.run_trial(Trial(seed + index, **CONDITIONS[name])) for index in range(dances)]
    base, upper = report.depth_noise_cm(outcomes)
    tallies = {group: (t.expected, t.missed, t.false, t.p95_ms) for group, t in report.event_counts(outcomes).items()}
    hidden = report.event_counts(outcomes, hidden=True)["claps"]
    return {
        **report.joint_errors(outcomes),
        "cpu_ms": 1000 * float(np.median(np.concatenate([one.cpu_s for one in outcomes]))),
        "jitter_base_cm": base,
        "jitter_upper_cm": upper,
        "events": {group: dict(zip(("expected", "missed", "false", "p95_ms"), row, strict=True))
                   for group, row in tallies.items()},
        "hidden_claps": {"expected": hidden.expected, "missed": hidden.missed},
        **report.identity_errors(outcomes),
    }  # fmt: skip


def show(name: str, row: dict[str, Any]) -> None:
    """One condition, in two lines; what is to be reached is in brackets.

    Of dancers who stand aslant no events are shown: along the sensor's axis they move at the detectors' threshold.
    """
    median_cm, p95_cm = TARGETS_CM.get(name, (math.nan, math.nan))
    print(
        f"{name:15s} median {row['median_cm']:.2f} ({median_cm}) p95 {row['p95_cm']:.1f} ({p95_cm}) cm, "
        f"tracked {row['tracked']:.1%} (98), of these {row['astray']:.2%} astray, swapped {row['swapped']:.2%} (0), "
        f"SpineBase {row['jitter_base_cm']:.3f} (.05) cm, {row['cpu_ms']:.1f} (6) ms"
    )
    if math.sin(CONDITIONS[name].get("facing_rad", 0.0)) ** 2 > 0.1:
        return
    parts = [f"{group} {t['missed']} missed {t['false']} false of {t['expected']} (p95 {t['p95_ms']} (33) ms)"
             for group, t in row["events"].items()]  # fmt: skip
    hidden = row["hidden_claps"]
    print(f"{'':15s} {'; '.join(parts)}; hidden claps missed {hidden['missed']} of {hidden['expected']}")


def main() -> int:
    parser = argparse.ArgumentParser(description="Figures of depth sensing.")
    parser.add_argument("--dances", type=int, default=4, help="per condition")
    parser.add_argument(
        "--seed",
        type=int,
        default=8654,
        help="of the first dance; 5000, 6101, 7700-7707, 8600-8649 and 8700-8799 chose settings, 8650-8699 none",
    )
    parser.add_argument("--only", nargs="*", choices=[*CONDITIONS, "crossings"], help="some conditions")
    parser.add_argument("--json", action="store_true", help="JSON, and nothing else, on stdout")
    options = parser.parse_args()
    wanted = options.only or [*CONDITIONS, "crossings"]
    rows: dict[str, Any] = {}
    for name in wanted:
        if name == "crossings":
            rows[name] = {"crossings": crossing_errors(options.seed), "eclipses": occlusion_errors(options.seed)}
        else:
            rows[name] = figures(name, options.dances, options.seed)
        if not options.json:
            print(f"{name:15s} {rows[name]}") if name == "crossings" else show(name, rows[name])
    if options.json:
        print(json.dumps({"schema": 1, "seed": options.seed, "dances": options.dances, "figures": rows}, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
