"""Fit the error model of ``joints`` sensing to what ``depth`` sensing gets wrong; prints SensorConfig's fields.

python scripts/fit_joint_errors.py
python scripts/fit_joint_errors.py --dances 8 --json
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sjasim.assets.names import JOINTS
from sjasim.sensors.sight import TORSO
from sjasim.training import trials
from sjasim.training.trials import WARM_FRAMES, Outcome, Trial
from sjasim.types import INFERRED, TRACKED

SEED = 8100
"""Of the first dance; the evaluations' seeds are others."""

OUTLIER = 4.0
"""Residuals farther from the median than so many robust s.d. are left out: a hand taken for another's is no drift."""

LEAST_FRAMES = 60
"""A joint known for fewer frames says nothing about its own bias."""

ARMS = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb")) for name in JOINTS])
TRUNK = np.isin(np.arange(len(JOINTS)), TORSO)


def spread(values: NDArray[np.float64]) -> float:
    """Standard deviation about 0 of the values that are no outliers."""
    scale = 1.4826 * float(np.median(np.abs(values)))
    return float(np.sqrt(np.mean(values[np.abs(values) <= OUTLIER * scale] ** 2)))


def series(outcomes: Sequence[Outcome], chosen: NDArray[np.bool_], state: int) -> list[NDArray[np.float64]]:
    """Residuals (N, 3) of every chosen joint of every dancer while it was in a state; gaps are closed."""
    rows = []
    for one in outcomes:
        error = (one.found - one.true)[WARM_FRAMES:]
        usable = (one.state[WARM_FRAMES:] == state) & np.isfinite(error[..., 0])
        for dancer in range(error.shape[1]):
            for joint in np.flatnonzero(chosen):
                kept = error[usable[:, dancer, joint], dancer, joint]
                if len(kept) >= LEAST_FRAMES:
                    rows.append(kept)
    return rows


def fitted(outcomes: Sequence[Outcome]) -> dict[str, float]:
    """The fields of SensorConfig, from dances seen by depth sensing.

    Bias: r.m.s. of the torso joints' mean errors. Drift: r.m.s. about each mean; its correlation such that it makes
    the usual step between frames. Hidden factors: error of inferred joints over both, torso and arms apart. Arms have
    the same errors as the torso while they are tracked; their steps, which no motion event looks at, are larger.
    """
    torso = series(outcomes, TRUNK, TRACKED)
    bias = root_mean_square(np.concatenate([rows.mean(axis=0) for rows in torso]))
    drift = root_mean_square(np.concatenate([(rows - rows.mean(axis=0)).ravel() for rows in torso]))
    step = spread(np.concatenate([np.diff(rows, axis=0).ravel() for rows in torso]))
    factors = {}
    for name, chosen in (("hidden_factor", TRUNK), ("hidden_factor_hand", ARMS)):
        inferred = np.concatenate([rows.ravel() for rows in series(outcomes, chosen, INFERRED)])
        factors[name] = spread(inferred) / np.hypot(bias, drift)
    correlation = max(0.0, 1.0 - step**2 / (2.0 * drift**2))
    return {"bias_m": bias, "drift_m": drift, "drift_correlation": correlation, **factors}


def root_mean_square(values: NDArray[np.float64]) -> float:
    """Of all values, outliers too."""
    return float(np.sqrt(np.mean(values**2)))


def known(outcomes: Sequence[Outcome]) -> dict[str, float]:
    """How often visible joints are tracked, and hidden ones taken for tracked: what `joints` sensing simplifies."""
    visible = np.concatenate([one.visible[WARM_FRAMES:].reshape(-1, len(JOINTS)) for one in outcomes])
    state = np.concatenate([one.state[WARM_FRAMES:].reshape(-1, len(JOINTS)) for one in outcomes])
    rows = {"torso": TRUNK, "arms": ARMS}
    seen = {
        f"tracked_if_visible_{name}": float((state[:, c][visible[:, c]] == TRACKED).mean()) for name, c in rows.items()
    }
    unseen = {
        f"tracked_if_hidden_{name}": float((state[:, c][~visible[:, c]] == TRACKED).mean()) for name, c in rows.items()
    }
    return seen | unseen


def main() -> int:
    parser = argparse.ArgumentParser(description="Errors of joints sensing, fitted to depth sensing.")
    parser.add_argument("--dances", type=int, default=6, help="half of them in aligned rows")
    parser.add_argument("--seed", type=int, default=SEED, help="of the first dance")
    parser.add_argument("--json", action="store_true", help="JSON instead of TOML")
    options = parser.parse_args()
    outcomes = []
    for index in range(options.dances):
        sys.stderr.write(f"dance {index + 1} of {options.dances}\n")
        outcomes.append(trials.run(Trial(options.seed + index, length_s=20.0, aligned=index % 2 == 1)))
    values, shares = fitted(outcomes), known(outcomes)
    if options.json:
        print(json.dumps({"schema": 1, "seed": options.seed, "sensors": values, "known": shares}, indent=1))
        return 0
    print("[sensors]")
    print("\n".join(f"{name} = {value:.4f}" for name, value in values.items()))
    print("\n".join(f"# {name}: {value:.3f}" for name, value in shares.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
