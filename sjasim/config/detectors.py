"""Thresholds of the event detectors."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class DetectorConfig:
    """Thresholds of the event detectors of the sensor clients. Numbers of frames refer to a frame rate of 30 Hz.

    Attributes:
        difference_frames: number of frames over which the velocity of SpineBase is computed. A larger value gives less
            noise and more delay.
        start_speed_m_s: speed above which a move starts [m/s]. A larger value detects starts later and misses slow
            moves.
        stop_speed_m_s: speed below which a move stops [m/s]. A larger value detects stops earlier.
        min_move_s: shortest duration of a move [s]; no stop is detected earlier.
        min_hold_s: shortest time between a stop and the next start [s].
        early_displacement_m: displacement from frame to frame above which a joint is moving, for early events [m]. It
            should be at least 3.5 times the noise from frame to frame.
        early_joints: smallest number of moving joints among SpineMid, both shoulders and Neck for an early start.
        early_frames: number of consecutive frames in which the condition of an early event must hold.
        early_refractory_s: time after a regular stop in which no early start is detected [s].
        early_move_share: fraction of the duration of the person's last move of the same kind in which no early stop is
            detected (assumed: iqbal2016 says only "half of the joint positions changed").
        clap_ratio: ratio of hand distance to shoulder distance below which a local minimum is a clap.
        clap_refractory_s: shortest time between two claps [s].
        side_clap_window_s: time before and after the beat of a clap in which claps of dancers whose hands the active
            client does not see are accepted from other clients [s]. With 0, as in iqbal2016, only the active client
            reports claps.
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
