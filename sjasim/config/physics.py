"""Rates of the physics simulation."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class PhysicsConfig:
    """Rates of the physics simulation.

    Attributes:
        rate_hz: physics steps per second [Hz]; 150 is a multiple of the rates of cameras, odometry and balance control.
        control_hz: rate of the balance controller and of the joint targets [Hz].
        ground_truth_hz: lowest rate at which the ground truth is recorded [Hz]. The rate is increased to ``control_hz``
            divided by a whole number: without balance support (240 Hz), 50 becomes 60.
    """

    rate_hz: int = 150
    control_hz: int = 50
    ground_truth_hz: int = 50

    def __post_init__(self) -> None:
        within("physics.rate_hz", self.rate_hz, 120, 2000)
        within("physics.control_hz", self.control_hz, 20, self.rate_hz)
        within("physics.ground_truth_hz", self.ground_truth_hz, 10, self.rate_hz)
