"""What the robot believes about its own motion, and the events that follow from it.

The position comes from the wheels' encoders, the heading from the gyro. The rules are compiled functions over small
arrays, which a turn of the robot calls one after the other (`turns`); the classes hold these arrays.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ..config import RobotConfig
from ..core import Array, Kind, RobotState, WheelReading
from .diff_drive import Pose, moved

MOVING_M_S = 0.002 * 50
"""The robot moves when it is faster than this. Source: iqbal2016, which compares successive samples with .002 m
and gives no rate; read at the Kobuki's 50 Hz and kept as a velocity, so that another rate means the same."""

TURNING_RAD_S = 0.4
"""The robot turns when its yaw rate is beyond this. Source: iqbal2016."""

CONFIRMING = 3
"""Samples in a row that a start or a stop needs. Source: iqbal2016."""

EVENTS = (None, Kind.START_FORWARD, Kind.START_BACKWARD, Kind.STOP_FORWARD, Kind.STOP_BACKWARD, Kind.TURN)
"""What `detect` numbers."""
_START, _STOP, _TURN = 1, 3, 5

T, X, Y, HEADING, STEP, RATE, LEFT, RIGHT = range(8)
"""A belief: the columns of `types.RobotState`, and behind them the encoders' counts."""

PER_RAD, METRES, TRACK, BIAS, BY_GYRO = range(5)
"""A base: ticks per radian, way per tick [m], track [m], the gyro's bias [rad/s], whether it gives the heading."""

SEEN_T, INTERVAL, WAY, SIGN, RUN, FIRST_T, REST, REST_T, CALM, TURNING, EVENT_T = range(11)
"""What a detector remembers: time of the last sample and the interval before the first one [s]; the way it goes, +1 or
-1 between a start and its stop; sign, number and first time of the latest samples that are alike; number and first
time of those that go another way; number of those without a turn; whether it turns; when the last event was."""

_BLOCK = 256


@njit(cache=True)
def reckon(
    t_s: float, left_rad: float, right_rad: float, yaw_rate_rad_s: float, noise_rad_s: float, base: Array,
    belief: Array,
) -> None:  # fmt: skip
    """Bring a belief up to date with one sample; see `Odometry`."""
    left, right = math.floor(left_rad * base[PER_RAD]), math.floor(right_rad * base[PER_RAD])
    rate, step = yaw_rate_rad_s + base[BIAS] + noise_rad_s, 0.0
    if not math.isnan(belief[T]):
        left_m, right_m = (left - belief[LEFT]) * base[METRES], (right - belief[RIGHT]) * base[METRES]
        step = (left_m + right_m) / 2
        x, y, heading = moved((belief[X], belief[Y], belief[HEADING]), left_m, right_m, base[TRACK])
        if base[BY_GYRO] > 0.0:
            heading = belief[HEADING] + (belief[RATE] + rate) / 2 * (t_s - belief[T])
        belief[X], belief[Y], belief[HEADING] = x, y, heading
    belief[T], belief[STEP], belief[RATE] = t_s, step, rate
    belief[LEFT], belief[RIGHT] = left, right


@njit(cache=True)
def detect(belief: Array, seen: Array) -> int:
    """Look at one sample; see `RobotEventDetector`.

    Returns:
        which of `EVENTS` it shows, 0 for none; its time is in ``seen``.
    """
    t = belief[T]
    interval = t - seen[SEEN_T] if not math.isnan(seen[SEEN_T]) else seen[INTERVAL]
    seen[SEEN_T] = t
    if _turn_begins(belief[RATE], seen):
        seen[EVENT_T] = t
        return _TURN
    limit = MOVING_M_S * interval
    sign = 1.0 if belief[STEP] > limit else -1.0 if belief[STEP] < -limit else 0.0
    if seen[TURNING] > 0.0 and sign != seen[WAY]:
        sign = 0.0
    _count(sign, t, seen)
    if seen[WAY] != 0.0 and seen[REST] >= CONFIRMING:
        event = _STOP if seen[WAY] > 0.0 else _STOP + 1
        seen[WAY] = seen[REST] = 0.0
        seen[EVENT_T] = seen[REST_T]
        return event
    if seen[WAY] == 0.0 and seen[SIGN] != 0.0 and seen[RUN] >= CONFIRMING:
        seen[WAY], seen[REST], seen[EVENT_T] = seen[SIGN], 0.0, seen[FIRST_T]
        return _START if seen[WAY] > 0.0 else _START + 1
    return 0


@njit(cache=True)
def _turn_begins(yaw_rate: float, seen: Array) -> bool:
    if -TURNING_RAD_S <= yaw_rate <= TURNING_RAD_S:
        seen[CALM] += 1.0
        if seen[CALM] >= CONFIRMING:
            seen[TURNING] = 0.0
        return False
    begins = bool(seen[TURNING] == 0.0)
    seen[CALM], seen[TURNING] = 0.0, 1.0
    return begins


@njit(cache=True)
def _count(sign: float, t: float, seen: Array) -> None:
    if sign != seen[SIGN]:
        seen[SIGN], seen[RUN], seen[FIRST_T] = sign, 0.0, t
    seen[RUN] += 1.0
    if sign == seen[WAY]:
        seen[REST] = 0.0
        return
    if seen[REST] == 0.0:
        seen[REST_T] = t
    seen[REST] += 1.0


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

    Attributes:
        base: what `reckon` knows of the robot.
        belief: where it believes to be.
    """

    __slots__ = ("_draws", "_noise", "_rng", "base", "belief")

    def __init__(
        self,
        config: RobotConfig,
        start_pose: Pose,
        rng: np.random.Generator | None = None,
        *,
        gyro: bool = True,
    ) -> None:
        per_rad = config.ticks_per_rev / (2 * math.pi)
        metres = config.wheel_radius_m * (1 + config.wheel_radius_error) / per_rad
        track = config.wheel_separation_m * (1 + config.wheel_separation_error)
        self.base = np.array([per_rad, metres, track, config.gyro_bias_rad_s, float(gyro)])
        self.belief = np.array([math.nan, *start_pose, 0.0, 0.0, 0.0, 0.0])
        self._noise = config.gyro_noise_rad_s if rng is not None else 0.0
        self._rng = rng
        self._draws: list[float] = []

    @property
    def state(self) -> RobotState:
        """The last sample."""
        return RobotState(*self.belief[: RATE + 1].tolist())

    def noise_rad_s(self) -> float:
        """The gyro's noise in the next sample; drawn for many at a time, which is cheaper [rad/s]."""
        if self._noise == 0.0 or self._rng is None:
            return 0.0
        if not self._draws:
            self._draws = self._rng.standard_normal(_BLOCK)[::-1].tolist()
        return self._noise * self._draws.pop()

    def update(self, t_s: float, reading: WheelReading) -> RobotState:
        """Take one sample; the first one only fixes the encoders' zero and reports the start pose.

        Args:
            t_s: session time of the sample; the gyro is integrated over the interval since the last one.
            reading: the base's own sensors.
        """
        reckon(
            t_s, reading.left_rad, reading.right_rad, reading.yaw_rate_rad_s, self.noise_rad_s(), self.base, self.belief
        )
        return self.state


class RobotEventDetector:
    """Turns odometry into the robot's events.

    Starts and stops are the first of three samples on the other side of `MOVING_M_S`; a turn is the first sample
    beyond `TURNING_RAD_S`. While the robot turns nothing starts. A reversal quicker than three samples still gives
    its stop first and its start one sample later. Nothing is invented: a move too slow to cross gives no event.

    Args:
        config: the odometry's rate, for the first interval only; later ones are taken from the stamps.

    Attributes:
        seen: what `detect` remembers.
    """

    __slots__ = ("seen",)

    def __init__(self, config: RobotConfig) -> None:
        self.seen = np.zeros(11)
        self.seen[SEEN_T], self.seen[INTERVAL] = math.nan, 1.0 / config.odometry_hz

    def event(self, number: int) -> tuple[Kind, float] | None:
        """The event that `detect` has just numbered, and the time of its first sample [s]."""
        kind = EVENTS[number]
        return None if kind is None else (kind, self.seen.item(EVENT_T))

    def update(self, state: RobotState) -> tuple[Kind, float] | None:
        """Look at one sample.

        Returns:
            the event and the time of its first sample [s] (two samples ago for starts and stops), or None.
        """
        return self.event(detect(np.array(state), self.seen))
