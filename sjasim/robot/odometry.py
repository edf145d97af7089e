"""Odometry: the robot's estimate of its own pose, from wheel encoders and the gyro."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from ..config import RobotConfig
from ..core import Array, RobotState, WheelReading
from ..core.compiled import compiled_entry
from .diff_drive import Pose, advance_pose


class OdometryColumn(IntEnum):
    """Places in an odometry estimate; the first `STATE_WIDTH` are the fields of `RobotState`, in its units."""

    T = 0
    X = 1
    Y = 2
    HEADING = 3
    STEP = 4
    """Distance since the sample before, forward positive [m]."""
    YAW_RATE = 5
    LEFT_TICKS = 6
    """Count of the left encoder."""
    RIGHT_TICKS = 7


STATE_WIDTH = 6
"""Number of leading values of an odometry estimate that make up a `RobotState`."""


class CalibrationColumn(IntEnum):
    """Places in the calibration of an odometry."""

    TICKS_PER_RAD = 0
    """Encoder ticks per radian of a wheel."""
    M_PER_TICK = 1
    """Distance per tick, with the radius that odometry assumes [m]."""
    WHEEL_SEPARATION = 2
    """The distance between the wheels that odometry assumes [m]."""
    GYRO_BIAS = 3
    """Constant error of the gyro [rad/s]."""
    HEADING_FROM_GYRO = 4
    """1 if the heading is the integrated yaw rate of the gyro, 0 if it comes from the encoders."""


_NOISE_BLOCK = 256
"""Number of noise values drawn at a time, which is cheaper than one by one."""


@compiled_entry
def update_estimate(
    t_s: float, left_rad: float, right_rad: float, yaw_rate_rad_s: float, noise_rad_s: float, calibration: Array,
    estimate: Array,
) -> None:  # fmt: skip
    """Update an odometry estimate with one sample of the sensors.

    Args:
        t_s: session time of the sample.
        left_rad: angle of the left wheel since power-up.
        right_rad: angle of the right wheel.
        yaw_rate_rad_s: true yaw rate.
        noise_rad_s: noise of the gyro in this sample.
        calibration: (5,) see `CalibrationColumn`.
        estimate: (8,) see `OdometryColumn`, in and out; its time is NaN before the first sample, which only sets the
            zero of the encoders.
    """
    # An encoder counts whole ticks.
    left = math.floor(left_rad * calibration[CalibrationColumn.TICKS_PER_RAD])
    right = math.floor(right_rad * calibration[CalibrationColumn.TICKS_PER_RAD])
    yaw_rate = yaw_rate_rad_s + calibration[CalibrationColumn.GYRO_BIAS] + noise_rad_s
    step = 0.0

    if not math.isnan(estimate[OdometryColumn.T]):
        left_m = (left - estimate[OdometryColumn.LEFT_TICKS]) * calibration[CalibrationColumn.M_PER_TICK]
        right_m = (right - estimate[OdometryColumn.RIGHT_TICKS]) * calibration[CalibrationColumn.M_PER_TICK]
        step = (left_m + right_m) / 2

        heading_before = estimate[OdometryColumn.HEADING]
        pose = (estimate[OdometryColumn.X], estimate[OdometryColumn.Y], heading_before)
        x, y, heading = advance_pose(pose, left_m, right_m, calibration[CalibrationColumn.WHEEL_SEPARATION])

        # The trapezoidal rule: the yaw rate between two samples is taken as the mean of both.
        if calibration[CalibrationColumn.HEADING_FROM_GYRO] > 0.0:
            mean_rate = (estimate[OdometryColumn.YAW_RATE] + yaw_rate) / 2
            heading = heading_before + mean_rate * (t_s - estimate[OdometryColumn.T])

        estimate[OdometryColumn.X] = x
        estimate[OdometryColumn.Y] = y
        estimate[OdometryColumn.HEADING] = heading

    estimate[OdometryColumn.T] = t_s
    estimate[OdometryColumn.STEP] = step
    estimate[OdometryColumn.YAW_RATE] = yaw_rate
    estimate[OdometryColumn.LEFT_TICKS] = left
    estimate[OdometryColumn.RIGHT_TICKS] = right


class Odometry:
    """Dead reckoning from encoder ticks and the integrated gyro.

    It assumes a wheel radius and a wheel separation that differ from the true ones by the configured errors; the true
    motion does not depend on them. Within a sample the encoders bend the path, and then the gyro sets the heading, as
    in the Kobuki's driver. With the gyro an error of the wheel separation therefore has little effect.

    Args:
        config: calibration, its errors, and the noise of the gyro.
        start_pose: x [m], y [m] and heading [rad] at the first sample.
        rng: generator of the gyro's noise; None leaves the noise out.
        gyro: whether the heading comes from the gyro, as in the driver, or from the encoders alone.

    Attributes:
        calibration: (5,) see `CalibrationColumn`.
        estimate: (8,) present estimate, see `OdometryColumn`.
    """

    __slots__ = ("_draws", "_noise_rad_s", "_rng", "calibration", "estimate")

    def __init__(
        self,
        config: RobotConfig,
        start_pose: Pose,
        rng: np.random.Generator | None = None,
        *,
        gyro: bool = True,
    ) -> None:
        ticks_per_rad = config.ticks_per_rev / (2 * math.pi)
        m_per_tick = config.wheel_radius_m * (1 + config.wheel_radius_error) / ticks_per_rad
        separation_m = config.wheel_separation_m * (1 + config.wheel_separation_error)
        self.calibration = np.array([ticks_per_rad, m_per_tick, separation_m, config.gyro_bias_rad_s, float(gyro)])
        self.estimate = np.array([math.nan, *start_pose, 0.0, 0.0, 0.0, 0.0])

        self._noise_rad_s = config.gyro_noise_rad_s if rng is not None else 0.0
        self._rng = rng
        self._draws: list[float] = []

    @property
    def state(self) -> RobotState:
        """The estimate of the last sample."""
        return RobotState(*self.estimate[:STATE_WIDTH].tolist())

    def noise_rad_s(self) -> float:
        """The gyro's noise in the next sample [rad/s]; each call uses one draw."""
        if self._noise_rad_s == 0.0 or self._rng is None:
            return 0.0

        if not self._draws:
            # Reversed, because pop takes the last.
            self._draws = self._rng.standard_normal(_NOISE_BLOCK)[::-1].tolist()
        return self._noise_rad_s * self._draws.pop()

    def update(self, t_s: float, reading: WheelReading) -> RobotState:
        """Update the estimate with one sample; the first sample gives the start pose.

        Args:
            t_s: session time of the sample; the gyro is integrated over the interval since the last one.
            reading: the sensors of the base.

        Returns:
            the new estimate.
        """
        update_estimate(t_s, *reading, self.noise_rad_s(), self.calibration, self.estimate)
        return self.state
