"""The event detectors behind the sensors."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class DetectorConfig:
    """Thresholds of the clients' event detectors; each says what a larger value does. Frames are those of 30 Hz.

    Attributes:
        difference_frames: frames over which SpineBase's velocity is taken; more is smoother and later.
        start_speed_m_s: speed that starts a move; higher starts later and misses slow moves.
        stop_speed_m_s: speed below which a move stops; higher stops earlier.
        min_move_s: shortest move; a stop cannot come earlier.
        min_hold_s: shortest hold; a start cannot come earlier after a stop.
        early_displacement_m: floor of a joint's displacement in one frame; at least 3.5 x the one-frame noise.
        early_joints: how many of SpineMid, both shoulders and Neck must exceed it.
        early_frames: for how many consecutive frames.
        early_refractory_s: an early start is armed so long after the regular stop.
        early_move_share: an early stop is armed after this share of the duration of the dancer's last move of that kind
            (assumed: iqbal2016 says only "half of the joint positions changed").
        clap_ratio: hand distance over shoulder distance below which a local minimum is a clap.
        clap_refractory_s: shortest time between two claps.
        side_clap_window_s: for so long before and after the beat of a clap other sensors look out for claps of people whose
            hands the active client does not see; 0: the active client alone, as in iqbal2016.
    """

    difference_frames: int = 4
    start_speed_m_s: float = 0.20
    stop_speed_m_s: float = 0.10
    min_move_s: float = 0.8
    min_hold_s: float = 0.15
    early_displacement_m: float = 0.005
    early_joints: int = 2
    early_frames: int = 2
    early_refractory_s: float = 0.5
    early_move_share: float = 0.7
    clap_ratio: float = 0.6
    clap_refractory_s: float = 1.0
    side_clap_window_s: float = 2.0

    def __post_init__(self) -> None:
        within("detectors.difference_frames", self.difference_frames, 1, 30)
        within("detectors.start_speed_m_s", self.start_speed_m_s, 0.02, 1.0)
        within("detectors.stop_speed_m_s", self.stop_speed_m_s, 0.01, self.start_speed_m_s)
        within("detectors.min_move_s", self.min_move_s, 0.0, 5.0)
        within("detectors.min_hold_s", self.min_hold_s, 0.0, 5.0)
        within("detectors.early_displacement_m", self.early_displacement_m, 0.0005, 0.1)
        within("detectors.early_joints", self.early_joints, 1, 4)
        within("detectors.early_frames", self.early_frames, 1, 30)
        within("detectors.early_refractory_s", self.early_refractory_s, 0.0, 5.0)
        within("detectors.early_move_share", self.early_move_share, 0.0, 1.5)
        within("detectors.clap_ratio", self.clap_ratio, 0.1, 2.0)
        within("detectors.clap_refractory_s", self.clap_refractory_s, 0.1, 10.0)
        within("detectors.side_clap_window_s", self.side_clap_window_s, 0.0, 10.0)
