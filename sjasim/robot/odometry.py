"""What the robot believes about its own motion, and the events that follow from it.

The position comes from the wheels' encoders, the heading from the gyro.
"""

from __future__ import annotations

import math

import numpy as np

from ..config import RobotConfig
from ..types import Kind, RobotState, WheelReading
from .diff_drive import Pose, moved

MOVING_M_S = 0.002 * 50
"""The robot moves when it is faster than this. Source: iqbal2016, which compares successive samples with .002 m
and gives no rate; read at the Kobuki's 50 Hz and kept as a velocity, so that another rate means the same."""

TURNING_RAD_S = 0.4
"""The robot turns when its yaw rate is beyond this. Source: iqbal2016."""

CONFIRMING = 3
"""Samples in a row that a start or a stop needs. Source: iqbal2016."""

_STARTS = {1: Kind.START_FORWARD, -1: Kind.START_BACKWARD}
_STOPS = {1: Kind.STOP_FORWARD, -1: Kind.STOP_BACKWARD}


class Odometry:
    """Dead reckoning from counted encoder ticks and the integrated gyro.

    It believes in a wheel radius and a track that may be wrong by the configured errors; its true motion does not
    depend on them. The encoders bend the path inside a sample and the gyro then overwrites the heading, as in the
    Kobuki's driver; so with the gyro a wrong track hardly shows.

    Args:
        config: calibration, its errors, and the noise of the gyro.
        start_pose: x [m], y [m], heading [rad] at the first sample.
        rng: the gyro's noise; without it there is none.
        gyro: take the heading from the gyro, the driver's own choice, or from the encoders alone.
    """

    __slots__ = (
        "_bias", "_gyro", "_left", "_metres", "_noise", "_per_rad", "_pose", "_rate", "_right", "_rng", "_t", "_track",
    )  # fmt: skip

    def __init__(
        self,
        config: RobotConfig,
        start_pose: Pose,
        rng: np.random.Generator | None = None,
        *,
        gyro: bool = True,
    ) -> None:
        self._per_rad = config.ticks_per_rev / (2 * math.pi)
        self._metres = config.wheel_radius_m * (1 + config.wheel_radius_error) / self._per_rad
        self._track = config.track_m * (1 + config.track_error)
        self._bias = config.gyro_bias_rad_s
        self._noise = config.gyro_noise_rad_s if rng is not None else 0.0
        self._rng = rng
        self._gyro = gyro
        x, y, heading = start_pose
        self._pose: Pose = (float(x), float(y), float(heading))
        self._left = self._right = 0
        self._rate = 0.0
        self._t = math.nan

    def update(self, t_s: float, reading: WheelReading) -> RobotState:
        """Take one sample; the first one only fixes the encoders' zero and reports the start pose.

        Args:
            t_s: session time of the sample; the gyro is integrated over the interval since the last one.
            reading: the base's own sensors.
        """
        left = math.floor(reading.left_rad * self._per_rad)
        right = math.floor(reading.right_rad * self._per_rad)
        rate = float(reading.yaw_rate_rad_s) + self._bias
        if self._noise > 0.0 and self._rng is not None:
            rate += self._noise * float(self._rng.standard_normal())
        step = 0.0
        if not math.isnan(self._t):
            left_m = (left - self._left) * self._metres
            right_m = (right - self._right) * self._metres
            step = (left_m + right_m) / 2
            x, y, heading = moved(self._pose, left_m, right_m, self._track)
            if self._gyro:
                heading = self._pose[2] + (self._rate + rate) / 2 * (t_s - self._t)
            self._pose = (x, y, heading)
        self._left, self._right, self._rate, self._t = left, right, rate, t_s
        x, y, heading = self._pose
        return RobotState(t_s, x, y, heading, step, rate)


class RobotEventDetector:
    """Turns odometry into the robot's events.

    Starts and stops are the first of three samples on the other side of `MOVING_M_S`; a turn is the first sample
    beyond `TURNING_RAD_S`. While the robot turns nothing starts. A reversal quicker than three samples still gives
    its stop first and its start one sample later. Nothing is invented: a move too slow to cross gives no event.

    Args:
        config: the odometry's rate, for the first interval only; later ones are taken from the stamps.
    """

    __slots__ = ("_calm", "_direction", "_first", "_interval", "_rest", "_rest_t", "_run", "_sign", "_t", "_turning")

    def __init__(self, config: RobotConfig) -> None:
        self._interval = 1.0 / config.odometry_hz
        self._t = math.nan
        self._direction = 0  # +1 or -1 between a start and its stop
        self._sign = self._run = self._rest = self._calm = 0
        self._first = self._rest_t = 0.0
        self._turning = False

    def update(self, state: RobotState) -> tuple[Kind, float] | None:
        """Look at one sample.

        Returns:
            the event and the time of its first sample [s] (two samples ago for starts and stops), or None.
        """
        t = state.t_s
        interval = t - self._t if not math.isnan(self._t) else self._interval
        self._t = t
        if self._turn_begins(state.yaw_rate_rad_s):
            return Kind.TURN, t
        limit = MOVING_M_S * interval
        sign = 1 if state.step_m > limit else -1 if state.step_m < -limit else 0
        if self._turning and sign != self._direction:
            sign = 0
        self._count(sign, t)
        if self._direction and self._rest >= CONFIRMING:
            kind = _STOPS[self._direction]
            self._direction = self._rest = 0
            return kind, self._rest_t
        if not self._direction and self._sign and self._run >= CONFIRMING:
            self._direction, self._rest = self._sign, 0
            return _STARTS[self._sign], self._first
        return None

    def _turn_begins(self, yaw_rate: float) -> bool:
        if -TURNING_RAD_S <= yaw_rate <= TURNING_RAD_S:
            self._calm += 1
            if self._calm >= CONFIRMING:
                self._turning = False
            return False
        self._calm = 0
        begins = not self._turning
        self._turning = True
        return begins

    def _count(self, sign: int, t: float) -> None:
        if sign != self._sign:
            self._sign, self._run, self._first = sign, 0, t
        self._run += 1
        if sign == self._direction:
            self._rest = 0
            return
        if self._rest == 0:
            self._rest_t = t
        self._rest += 1
