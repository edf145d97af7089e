"""Configuration of the four depth sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..core.errors import ConfigError
from .checks import within

MAX_TRACKED_PERSONS = 6
"""Largest number of persons that depth sensing tracks, as in a Kinect v2."""


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """The four Kinect v2 sensors.

    Attributes:
        rate_hz: frame rate [Hz].
        status_hz: rate of the clients' status reports [Hz].
        standby_hz: frame rate of a client that does not detect events [Hz]. Its status reports between frames contain
            no persons.
        latency_frames: time from the capture of a frame to the end of its processing, in frames (Kinect v2: about 2).
        horizontal_fov_rad: horizontal field of view [rad]; 70.6 degrees.
        vertical_fov_rad: vertical field of view [rad]; 60 degrees.
        min_range_m: smallest distance of a tracked person [m].
        max_range_m: largest distance of a tracked person [m]; joints beyond it are inferred.
        frame_loss: probability that a frame is lost.
        width_px: width of a depth image: 512 (512 x 424) or 256 (256 x 212).
    """

    rate_hz: int = 30
    status_hz: int = 5
    standby_hz: int = 2
    latency_frames: int = 2
    horizontal_fov_rad: float = math.radians(70.6)
    vertical_fov_rad: float = math.radians(60.0)
    min_range_m: float = 0.5
    max_range_m: float = 4.5
    frame_loss: float = 0.0
    width_px: int = 256

    def __post_init__(self) -> None:
        within("sensors.rate_hz", self.rate_hz, 5, 120)
        within("sensors.status_hz", self.status_hz, 1, self.rate_hz)
        within("sensors.standby_hz", self.standby_hz, 1, self.rate_hz)
        within("sensors.latency_frames", self.latency_frames, 0, 30)
        within("sensors.horizontal_fov_rad", self.horizontal_fov_rad, 0.2, 3.0)
        within("sensors.vertical_fov_rad", self.vertical_fov_rad, 0.2, 3.0)
        within("sensors.min_range_m", self.min_range_m, 0.0, 2.0)
        within("sensors.max_range_m", self.max_range_m, 2.0, 20.0)
        within("sensors.frame_loss", self.frame_loss, 0.0, 0.9)
        # The full width of a Kinect v2's depth image, or half of it.
        if self.width_px not in (256, 512):
            raise ConfigError("sensors.width_px", self.width_px, "256 or 512")
