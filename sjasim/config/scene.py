"""Where dancers, robot and sensors stand."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..core.errors import ConfigError
from .checks import within


@dataclass(frozen=True, slots=True)
class SceneConfig:
    """Where people, robot and sensors stand.

    Attributes:
        side_m: side of the square of four slots (layout ``square``) or distance between rows and columns (``rows``).
        turn_rad: how far the square is turned; 31.5 degrees lets every cardinal sensor see all four bodies.
        slots_m: own slots for layout ``custom``: x, y of each dancer, then of the robot.
        sensor_distance_m: from the centre to each cardinal sensor.
        sensor_height_m: optical centre above the floor (iqbal2016: .91 m).
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
