"""Fit the error model of ``joints`` sensing to the errors of ``depth`` sensing; prints the section of a TOML file.

python scripts/fit_joint_errors.py
python scripts/fit_joint_errors.py --dances 4 --json

``python -m sjasim.characterise`` compares both ways of sensing over whole sessions with other seeds.
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
"""Seed of the first dance; the evaluation uses other seeds."""

OUTLIER_DEVIATIONS = 4.0
"""Residuals beyond this number of robust standard deviations are left out.

They are confusions, such as one hand taken for the other, and not the slow errors that the model describes.
"""

MIN_FRAMES = 60
"""Smallest number of frames from which the bias of a joint is estimated."""

ARMS = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb")) for name in JOINTS])
TRUNK = np.isin(np.arange(len(JOINTS)), TORSO)

Residuals = list[NDArray[np.float64]]
"""(N, 3) residuals of one joint of one dancer over N frames [m], for several of them."""


def joint_residuals(results: Sequence[TrialResult], chosen: NDArray[np.bool_], *, visible: bool) -> Residuals:
    """Return the residuals of each chosen joint of each dancer, one frame after the other, without gaps.

    Args:
        results: results of trials.
        chosen: (25,) joints to use.
        visible: use frames in which the joint is visible and tracked; otherwise those in which it is occluded and has a
            position.
    """
    rows = []
    for result in results:
        error = (result.found - result.true)[WARM_FRAMES:]
        seen = result.visible[WARM_FRAMES:]
        state = result.state[WARM_FRAMES:]
        wanted = (seen & (state == TRACKED)) if visible else (~seen & (state != NOT_TRACKED))
        usable = wanted & ~np.isnan(error[..., 0])
        for dancer in range(error.shape[1]):
            for joint in np.flatnonzero(chosen):
                residuals = error[usable[:, dancer, joint], dancer, joint]
                if len(residuals) >= MIN_FRAMES:
                    rows.append(residuals)
    return rows


def fit_drift(residuals: Residuals) -> tuple[float, float]:
    """Fit a first-order autoregression.

    Returns:
        the standard deviation of the drift, which is the root mean square about each joint's mean [m]; and the
        correlation of successive frames, from the standard deviation of their differences.
    """
    drift_m = root_mean_square(np.concatenate([(own - own.mean(axis=0)).ravel() for own in residuals]))
    step_m = robust_deviation(np.concatenate([np.diff(own, axis=0).ravel() for own in residuals]))
    return drift_m, max(0.0, 1.0 - step_m**2 / (2.0 * drift_m**2))


def fit_noise(results: Sequence[TrialResult]) -> dict[str, float]:
    """Return the fitted fields of `JointNoiseConfig`.

    The bias is the root mean square of the mean errors of visible torso joints; limbs are assumed to have the same one.
    The factors of occluded joints are their errors over the errors of visible ones, for the torso and for the arms.
    """
    torso = joint_residuals(results, TRUNK, visible=True)
    bias_m = root_mean_square(np.concatenate([rows.mean(axis=0) for rows in torso]))
    drift_m, correlation = fit_drift(torso)
    limb_drift_m, limb_correlation = fit_drift(joint_residuals(results, LIMBS, visible=True))

    occluded_torso = joint_residuals(results, TRUNK, visible=False)
    occluded_arms = joint_residuals(results, ARMS, visible=False)
    torso_error_m = robust_deviation(np.concatenate([rows.ravel() for rows in occluded_torso]))
    arm_error_m = robust_deviation(np.concatenate([rows.ravel() for rows in occluded_arms]))
    return {
        "bias_m": bias_m,
        "drift_m": drift_m,
        "drift_correlation": correlation,
        "limb_drift_m": limb_drift_m,
        "limb_drift_correlation": limb_correlation,
        "occluded_factor": torso_error_m / float(np.hypot(bias_m, drift_m)),
        "occluded_factor_hand": arm_error_m / float(np.hypot(bias_m, limb_drift_m)),
    }


def robust_deviation(values: NDArray[np.float64]) -> float:
    """Return the standard deviation about 0 without outliers."""
    # 1.4826 makes the median absolute value of a normal variable its standard deviation.
    scale = 1.4826 * float(np.median(np.abs(values)))
    return root_mean_square(values[np.abs(values) <= OUTLIER_DEVIATIONS * scale])


def root_mean_square(values: NDArray[np.float64]) -> float:
    """Return the root mean square of all values."""
    return float(np.sqrt(np.mean(values**2)))


def tracked_shares(results: Sequence[TrialResult]) -> dict[str, float]:
    """Return how often visible and occluded joints are tracked, which ``joints`` sensing simplifies."""
    visible = np.concatenate([result.visible[WARM_FRAMES:].reshape(-1, len(JOINTS)) for result in results])
    state = np.concatenate([result.state[WARM_FRAMES:].reshape(-1, len(JOINTS)) for result in results])
    parts = {"torso": TRUNK, "legs": LIMBS & ~ARMS, "arms": ARMS}
    return {
        f"tracked_if_{word}_{name}": float((state[:, chosen][mask[:, chosen]] == TRACKED).mean())
        for word, mask in (("visible", visible), ("hidden", ~visible))
        for name, chosen in parts.items()
    }


def main() -> int:
    """Run the trials, fit, and print."""
    parser = argparse.ArgumentParser(description="Fit the errors of joints sensing to those of depth sensing.")
    parser.add_argument("--dances", type=int, default=10, help="number of dances; half of them in aligned rows")
    parser.add_argument("--seed", type=int, default=SEED, help="seed of the first dance")
    parser.add_argument("--json", action="store_true", help="print JSON instead of TOML")
    options = parser.parse_args()

    results = []
    for index in range(options.dances):
        sys.stderr.write(f"dance {index + 1} of {options.dances}\n")
        results.append(trials.run_trial(Trial(options.seed + index, length_s=20.0, aligned=index % 2 == 1)))

    values = fit_noise(results)
    shares = tracked_shares(results)
    if options.json:
        print(json.dumps({"schema": 1, "seed": options.seed, "joint_noise": values, "tracked": shares}, indent=1))
        return 0
    print("[joint_noise]")
    print("\n".join(f"{name} = {value:.4f}" for name, value in values.items()))
    print("\n".join(f"# {name}: {value:.3f}" for name, value in shares.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
