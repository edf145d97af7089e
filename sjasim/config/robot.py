"""Configuration of the robot, a TurtleBot 2."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class RobotConfig:
    """A TurtleBot 2 on a Kobuki base.

    Attributes:
        wheel_separation_m: distance between the wheels [m] (Kobuki: .230 m).
        wheel_radius_m: radius of a wheel [m] (Kobuki: .035 m).
        mass_kg: mass of the whole robot [kg] (TurtleBot 2: 6.3 kg).
        max_speed_m_s: largest speed [m/s] (TurtleBot 2: .65 m/s).
        max_yaw_rate_rad_s: largest yaw rate [rad/s] (Kobuki: 180 degrees/s).
        ticks_per_rev: encoder ticks per revolution of a wheel (Kobuki: 2578.33).
        odometry_hz: rate of encoders, gyro and wheel commands [Hz] (Kobuki: 50 Hz).
        cruise_m_s: speed of a forward or backward move [m/s]. The server adjusts it to return the robot to its slot.
        turn_rate_rad_s: largest yaw rate of a commanded turn [rad/s]; above 110 degrees/s the gyro is less accurate.
        acceleration_m_s2: largest acceleration of the velocity smoother [m/s^2].
        yaw_acceleration_rad_s2: largest yaw acceleration of the velocity smoother [rad/s^2].
        command_latency_s: time from the arrival of a command to the first wheel command [s] (total latency of real
            bases: .16 to .22 s).
        cmd_timeout_s: time without a received message after which the base stops [s].
        wheel_radius_error: relative error of the wheel radius that odometry uses.
        wheel_separation_error: relative error of the wheel separation that odometry uses.
        gyro_bias_rad_s: constant error of the gyro [rad/s].
        gyro_noise_rad_s: standard deviation of one gyro sample [rad/s].
    """

    wheel_separation_m: float = 0.230
    wheel_radius_m: float = 0.035
    mass_kg: float = 6.3
    max_speed_m_s: float = 0.65
    max_yaw_rate_rad_s: float = math.pi
    ticks_per_rev: float = 2578.33
    odometry_hz: int = 50
    cruise_m_s: float = 0.25
    turn_rate_rad_s: float = 1.6
    acceleration_m_s2: float = 1.0
    yaw_acceleration_rad_s2: float = 3.5
    command_latency_s: float = 0.15
    cmd_timeout_s: float = 0.6
    wheel_radius_error: float = 0.0
    wheel_separation_error: float = 0.0
    gyro_bias_rad_s: float = 0.0
    gyro_noise_rad_s: float = 0.0

    def __post_init__(self) -> None:
        within("robot.wheel_separation_m", self.wheel_separation_m, 0.1, 1.0)
        within("robot.wheel_radius_m", self.wheel_radius_m, 0.02, 0.2)
        within("robot.mass_kg", self.mass_kg, 2.0, 60.0)
        within("robot.max_speed_m_s", self.max_speed_m_s, 0.1, 2.0)
        within("robot.max_yaw_rate_rad_s", self.max_yaw_rate_rad_s, 0.5, 10.0)
        within("robot.ticks_per_rev", self.ticks_per_rev, 10.0, 1e6)
        within("robot.odometry_hz", self.odometry_hz, 10, 200)
        within("robot.cruise_m_s", self.cruise_m_s, 0.15, self.max_speed_m_s)
        within("robot.turn_rate_rad_s", self.turn_rate_rad_s, 0.5, self.max_yaw_rate_rad_s)
        within("robot.acceleration_m_s2", self.acceleration_m_s2, 0.1, 5.0)
        within("robot.yaw_acceleration_rad_s2", self.yaw_acceleration_rad_s2, 0.5, 20.0)
        within("robot.command_latency_s", self.command_latency_s, 0.0, 2.0)
        within("robot.cmd_timeout_s", self.cmd_timeout_s, 0.1, 10.0)
        within("robot.wheel_radius_error", self.wheel_radius_error, -0.1, 0.1)
        within("robot.wheel_separation_error", self.wheel_separation_error, -0.1, 0.1)
        within("robot.gyro_bias_rad_s", self.gyro_bias_rad_s, -0.1, 0.1)
        within("robot.gyro_noise_rad_s", self.gyro_noise_rad_s, 0.0, 0.1)
