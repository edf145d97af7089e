"""Sensors and the event detectors behind them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..core.errors import ConfigError
from .checks import within

MOST_SEEN = 6
"""So many people depth sensing follows, as a Kinect v2 does."""


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """Four Kinect v2 sensors; their images under ``depth`` sensing, the error of their skeletons under ``joints``.

    Attributes:
        rate_hz: frame rate.
        status_hz: rate of client status reports.
        idle_hz: frame rate of a client that idles, at most that of its reports; those between say only that it lives.
        latency_frames: frames between capture and the moment the client has processed it (Kinect v2: about 2).
        horizontal_fov_rad: field of view, 70.6 degrees.
        vertical_fov_rad: 60 degrees.
        min_range_m: nearest tracked person.
        max_range_m: farthest tracked person; who sways out of it is inferred.
        frame_loss: probability that a frame is never delivered.
        width_px: columns of a depth image: 512 (512 x 424) or 256 (256 x 212).
        bias_m: standard deviation of a joint's constant error, per axis. This and the next six are fitted to what
            ``depth`` sensing gets wrong, by ``scripts/fit_joint_errors.py`` (seeds 8760 to 8769).
        drift_m: standard deviation of the slowly varying error of a visible joint of trunk or head, per axis.
        drift_correlation: correlation of that error between frames; with ``drift_m`` gives .035 cm from frame to frame.
        limb_drift_m: the same as ``drift_m`` for joints of arms and legs.
        limb_drift_correlation: of that error.
        hidden_factor: how much larger both errors are where the joint is hidden.
        hidden_factor_hand: the same for elbows, wrists and hands.
    """

    rate_hz: int = 30
    status_hz: int = 5
    idle_hz: int = 2
    latency_frames: int = 2
    horizontal_fov_rad: float = math.radians(70.6)
    vertical_fov_rad: float = math.radians(60.0)
    min_range_m: float = 0.5
    max_range_m: float = 4.5
    frame_loss: float = 0.0
    width_px: int = 256
    bias_m: float = 0.0103
    drift_m: float = 0.0037
    drift_correlation: float = 0.9954
    limb_drift_m: float = 0.0110
    limb_drift_correlation: float = 0.9300
    hidden_factor: float = 2.13
    hidden_factor_hand: float = 2.49

    def __post_init__(self) -> None:
        within("sensors.rate_hz", self.rate_hz, 5, 120)
        within("sensors.status_hz", self.status_hz, 1, self.rate_hz)
        within("sensors.idle_hz", self.idle_hz, 1, self.rate_hz)
        within("sensors.latency_frames", self.latency_frames, 0, 30)
        within("sensors.horizontal_fov_rad", self.horizontal_fov_rad, 0.2, 3.0)
        within("sensors.vertical_fov_rad", self.vertical_fov_rad, 0.2, 3.0)
        within("sensors.min_range_m", self.min_range_m, 0.0, 2.0)
        within("sensors.max_range_m", self.max_range_m, 2.0, 20.0)
        within("sensors.frame_loss", self.frame_loss, 0.0, 0.9)
        if self.width_px not in (256, 512):
            raise ConfigError("sensors.width_px", self.width_px, "256 or 512")
        within("sensors.bias_m", self.bias_m, 0.0, 0.2)
        within("sensors.drift_m", self.drift_m, 0.0, 0.2)
        within("sensors.drift_correlation", self.drift_correlation, 0.0, 0.9999)
        within("sensors.limb_drift_m", self.limb_drift_m, 0.0, 0.2)
        within("sensors.limb_drift_correlation", self.limb_drift_correlation, 0.0, 0.9999)
        within("sensors.hidden_factor", self.hidden_factor, 1.0, 50.0)
        within("sensors.hidden_factor_hand", self.hidden_factor_hand, 1.0, 50.0)


@dataclass(frozen=True, slots=True)
class DetectorConfig:
    """Thresholds of the clients' event detectors; each says what a larger value does. Frames are those of 30 Hz.

    Attributes:
        difference_frames: frames over which SpineBase's velocity is taken; more is smoother and later.
        on_m_s: speed that starts a move; higher starts later and misses slow moves.
        off_m_s: speed below which a move stops; higher stops earlier.
        min_move_s: shortest move; a stop cannot come earlier.
        min_hold_s: shortest hold; a start cannot come earlier after a stop.
        early_step_m: floor of a joint's displacement in one frame; at least 3.5 x the one-frame noise.
        early_joints: how many of SpineMid, both shoulders and Neck must exceed it.
        early_frames: for how many consecutive frames.
        early_rest_s: an early start is armed so long after the regular stop.
        early_move_share: an early stop is armed after this share of the duration of the dancer's last move of that kind
            (assumed: iqbal2016 says only "half of the joint positions changed").
        clap_ratio: hand distance over shoulder distance below which a local minimum is a clap.
        clap_rest_s: shortest time between two claps.
        assist_s: for so long before and after the beat of a clap other sensors look out for claps of people whose
            hands the active client does not see; 0: the active client alone, as in iqbal2016.
    """

    difference_frames: int = 4
    on_m_s: float = 0.20
    off_m_s: float = 0.10
    min_move_s: float = 0.8
    min_hold_s: float = 0.15
    early_step_m: float = 0.005
    early_joints: int = 2
    early_frames: int = 2
    early_rest_s: float = 0.5
    early_move_share: float = 0.7
    clap_ratio: float = 0.6
    clap_rest_s: float = 1.0
    assist_s: float = 2.0

    def __post_init__(self) -> None:
        within("detectors.difference_frames", self.difference_frames, 1, 30)
        within("detectors.on_m_s", self.on_m_s, 0.02, 1.0)
        within("detectors.off_m_s", self.off_m_s, 0.01, self.on_m_s)
        within("detectors.min_move_s", self.min_move_s, 0.0, 5.0)
        within("detectors.min_hold_s", self.min_hold_s, 0.0, 5.0)
        within("detectors.early_step_m", self.early_step_m, 0.0005, 0.1)
        within("detectors.early_joints", self.early_joints, 1, 4)
        within("detectors.early_frames", self.early_frames, 1, 30)
        within("detectors.early_rest_s", self.early_rest_s, 0.0, 5.0)
        within("detectors.early_move_share", self.early_move_share, 0.0, 1.5)
        within("detectors.clap_ratio", self.clap_ratio, 0.1, 2.0)
        within("detectors.clap_rest_s", self.clap_rest_s, 0.1, 10.0)
        within("detectors.assist_s", self.assist_s, 0.0, 10.0)
