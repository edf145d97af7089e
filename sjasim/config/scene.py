"""Configuration of the positions of dancers, robot and sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..core.errors import ConfigError
from .checks import within


@dataclass(frozen=True, slots=True)
class SceneConfig:
    """Positions of dancers, robot and sensors.

    Attributes:
        side_m: side of the square of four slots (layout ``square``), or distance between rows and columns (layout
            ``rows``) [m].
        turn_rad: angle by which the square is rotated [rad]. At the default of 31.5 degrees every sensor sees all four
            bodies.
        slots_m: slots of layout ``custom``: x and y of each dancer, then of the robot [m].
        sensor_distance_m: distance of each sensor from the centre [m].
        sensor_height_m: height of the sensors' optical centres above the floor [m] (iqbal2016: .91 m).
    """

    side_m: float = 1.40
    turn_rad: float = math.radians(31.5)
    slots_m: tuple[tuple[float, float], ...] = ()
    sensor_distance_m: float = 3.40
    sensor_height_m: float = 0.91

    def __post_init__(self) -> None:
        within("scene.side_m", self.side_m, 0.8, 4.0)
        within("scene.turn_rad", self.turn_rad, -math.pi, math.pi)
        within("scene.sensor_distance_m", self.sensor_distance_m, 1.0, 8.0)
        within("scene.sensor_height_m", self.sensor_height_m, 0.2, 2.5)
        for slot in self.slots_m:
            if len(slot) != 2:
                raise ConfigError("scene.slots_m", slot, "pairs of x and y")
