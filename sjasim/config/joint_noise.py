"""Errors of the skeletons of joint sensing."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class JointNoiseConfig:
    """Errors of the skeletons that ``joints`` sensing makes from true joints; ``depth`` sensing does not use them.

    The defaults are fitted to the errors of ``depth`` sensing by ``scripts/fit_joint_errors.py`` (seeds 8760 to 8769).

    Attributes:
        bias_m: standard deviation of a joint's constant error, per axis [m].
        drift_m: standard deviation of the slowly varying error of a visible joint of trunk or head, per axis [m].
        drift_correlation: correlation of that error between successive frames; with ``drift_m`` it changes by .035 cm
            from frame to frame.
        limb_drift_m: the same as ``drift_m`` for joints of arms and legs [m].
        limb_drift_correlation: the same as ``drift_correlation`` for them.
        occluded_factor: factor by which both errors are larger while the joint is occluded.
        occluded_factor_hand: the same factor for elbows, wrists and hands.
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
