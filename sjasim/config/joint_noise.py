"""Error model of the skeletons of joint sensing."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class JointNoiseConfig:
    """Errors that ``joints`` sensing adds to the true joints; ``depth`` sensing does not use them.

    ``scripts/fit_joint_errors.py`` fits the defaults to the errors of ``depth`` sensing (seeds 8760 to 8769).

    Attributes:
        bias_m: standard deviation of a joint's constant error, per axis [m].
        drift_m: standard deviation of the slowly varying error of a visible joint of trunk or head, per axis [m].
        drift_correlation: correlation of the slowly varying error between successive frames. With the default values
            the error changes by .035 cm from frame to frame.
        limb_drift_m: standard deviation of the slowly varying error of a visible joint of arms and legs, per axis [m].
        limb_drift_correlation: correlation of that error between successive frames.
        occluded_factor: factor on both errors while a joint is occluded.
        occluded_factor_hand: factor on both errors while an elbow, wrist or hand is occluded.
    """

    bias_m: float = 0.0103
    drift_m: float = 0.0037
    drift_correlation: float = 0.9954
    limb_drift_m: float = 0.0110
    limb_drift_correlation: float = 0.9300
    occluded_factor: float = 2.13
    occluded_factor_hand: float = 2.49

    def __post_init__(self) -> None:
        within("joint_noise.bias_m", self.bias_m, 0.0, 0.2)
        within("joint_noise.drift_m", self.drift_m, 0.0, 0.2)
        within("joint_noise.drift_correlation", self.drift_correlation, 0.0, 0.9999)
        within("joint_noise.limb_drift_m", self.limb_drift_m, 0.0, 0.2)
        within("joint_noise.limb_drift_correlation", self.limb_drift_correlation, 0.0, 0.9999)
        within("joint_noise.occluded_factor", self.occluded_factor, 1.0, 50.0)
        within("joint_noise.occluded_factor_hand", self.occluded_factor_hand, 1.0, 50.0)
