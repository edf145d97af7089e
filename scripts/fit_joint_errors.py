"""Fit the error model of ``joints`` sensing to what ``depth`` sensing gets wrong; prints SensorConfig's fields.

python scripts/fit_joint_errors.py
python scripts/fit_joint_errors.py --dances 4 --json

``python -m sjasim.characterise`` shows both side by side, over whole sessions of other seeds.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sjasim.assets.names import JOINTS
from sjasim.core import NOT_TRACKED, TRACKED
from sjasim.sensors.joint_occlusion import LIMBS, TORSO
from sjasim.skeleton_training import trials
from sjasim.skeleton_training.trials import WARM_FRAMES, Trial, TrialResult

SEED = 8760
"""Of the first dance; the evaluations' seeds are others."""

OUTLIER = 4.0
"""Residuals farther from the median than so many robust s.d. are left out: a hand taken for another's is no drift."""

LEAST_FRAMES = 60
"""A joint known for fewer frames says nothing about its own bias."""

ARMS = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb")) for name in JOINTS])
TRUNK = np.isin(np.arange(len(JOINTS)), TORSO)

Rows = list[NDArray[np.float64]]


def series(outcomes: Sequence[TrialResult], chosen: NDArray[np.bool_], *, visible: bool) -> Rows:
    """Residuals (N, 3) of every chosen joint of every dancer: tracked while visible, or known while hidden.

    Gaps are closed.
    """
    rows = []
    for one in outcomes:
        error, seen = (one.found - one.true)[WARM_FRAMES:], one.visible[WARM_FRAMES:]
        state = one.state[WARM_FRAMES:]
        usable = ((seen & (state == TRACKED)) if visible else (~seen & (state != NOT_TRACKED))) & ~np.isnan(
            error[..., 0]
        )
        for dancer in range(error.shape[1]):
            for joint in np.flatnonzero(chosen):
                kept = error[usable[:, dancer, joint], dancer, joint]
                if len(kept) >= LEAST_FRAMES:
                    rows.append(kept)
    return rows


def drift_of(rows: Rows) -> tuple[float, float]:
    """Drift: r.m.s. about each joint's mean [m]; and its correlation such that it makes the usual step of a frame."""
    drift = root_mean_square(np.concatenate([(own - own.mean(axis=0)).ravel() for own in rows]))
    step = spread(np.concatenate([np.diff(own, axis=0).ravel() for own in rows]))
    return drift, max(0.0, 1.0 - step**2 / (2.0 * drift**2))


def fitted(outcomes: Sequence[TrialResult]) -> dict[str, float]:
    """The fields of SensorConfig, from dances seen by depth sensing.

    Bias: r.m.s. of the mean errors of the torso's visible joints; the limbs' is taken to be the same. Hidden factors:
    error of hidden joints over both errors of visible ones, torso and arms apart.
    """
    torso = series(outcomes, TRUNK, visible=True)
    bias = root_mean_square(np.concatenate([rows.mean(axis=0) for rows in torso]))
    drift, correlation = drift_of(torso)
    limb_drift, limb_correlation = drift_of(series(outcomes, LIMBS, visible=True))
    hidden = {
        name: spread(np.concatenate([rows.ravel() for rows in series(outcomes, chosen, visible=False)]))
        for name, chosen in (("torso", TRUNK), ("arms", ARMS))
    }
    return {
        "bias_m": bias,
        "drift_m": drift,
        "drift_correlation": correlation,
        "limb_drift_m": limb_drift,
        "limb_drift_correlation": limb_correlation,
        "occluded_factor": hidden["torso"] / float(np.hypot(bias, drift)),
        "occluded_factor_hand": hidden["arms"] / float(np.hypot(bias, limb_drift)),
    }


def spread(values: NDArray[np.float64]) -> float:
    """Standard deviation about 0 of the values that are no outliers."""
    scale = 1.4826 * float(np.median(np.abs(values)))
    return root_mean_square(values[np.abs(values) <= OUTLIER * scale])


def root_mean_square(values: NDArray[np.float64]) -> float:
    """Of all values, outliers too."""
    return float(np.sqrt(np.mean(values**2)))


def known(outcomes: Sequence[TrialResult]) -> dict[str, float]:
    """How often visible joints are tracked, and hidden ones taken for tracked: what `joints` sensing simplifies."""
    visible = np.concatenate([one.visible[WARM_FRAMES:].reshape(-1, len(JOINTS)) for one in outcomes])
    state = np.concatenate([one.state[WARM_FRAMES:].reshape(-1, len(JOINTS)) for one in outcomes])
    rows = {"torso": TRUNK, "legs": LIMBS & ~ARMS, "arms": ARMS}
    return {
        f"tracked_if_{word}_{name}": float((state[:, chosen][mask[:, chosen]] == TRACKED).mean())
        for word, mask in (("visible", visible), ("hidden", ~visible))
        for name, chosen in rows.items()
    }


def main() -> int:
    parser = argparse.ArgumentParser(description="Errors of joints sensing, fitted to depth sensing.")
    parser.add_argument("--dances", type=int, default=10, help="half of them in aligned rows")
    parser.add_argument("--seed", type=int, default=SEED, help="of the first dance")
    parser.add_argument("--json", action="store_true", help="JSON instead of TOML")
    options = parser.parse_args()
    outcomes = []
    for index in range(options.dances):
        sys.stderr.write(f"dance {index + 1} of {options.dances}\n")
        outcomes.append(trials.run_trial(Trial(options.seed + index, length_s=20.0, aligned=index % 2 == 1)))
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
