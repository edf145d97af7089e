"""Event detection of the robot: starts, stops and turns from its odometry."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from ..config import RobotConfig
from ..core import Array, Kind, RobotState
from ..core.compiled import compiled_entry, compiled_inner
from .odometry import OdometryColumn

MOVING_M_S = 0.002 * 50
"""Speed above which the robot moves [m/s].

Source: iqbal2016, which compares successive samples with .002 m and gives no rate. It is read at the Kobuki's 50 Hz and
kept as a velocity, so that other rates have the same threshold.
"""

TURNING_RAD_S = 0.4
"""Yaw rate above which the robot turns [rad/s]. Source: iqbal2016."""

CONFIRMATION_SAMPLES = 3
"""Number of successive samples that confirm a start or a stop. Source: iqbal2016."""

EVENTS = (None, Kind.START_FORWARD, Kind.START_BACKWARD, Kind.STOP_FORWARD, Kind.STOP_BACKWARD, Kind.TURN)
"""Kinds by the numbers that `detect_event` returns."""

_START = 1
_STOP = 3
_TURN = 5


class DetectorColumn(IntEnum):
    """Places in the state of a `RobotEventDetector`."""

    LAST_T = 0
    """Time of the last sample [s]."""
    FIRST_INTERVAL = 1
    """Interval that the first sample stands for [s]."""
    DIRECTION = 2
    """+1 or -1 from a start to its stop, else 0."""
    SIGN = 3
    """Direction of the latest samples, which are alike: +1, -1 or 0."""
    RUN = 4
    """Number of these samples."""
    RUN_T = 5
    """Time of the first of them [s]."""
    REST = 6
    """Number of the latest samples against the present direction."""
    REST_T = 7
    """Time of the first of them [s]."""
    CALM = 8
    """Number of the latest samples without a turn."""
    TURNING = 9
    """1 during a turn, else 0."""
    EVENT_T = 10
    """Time of the last event [s]."""


@compiled_entry
def detect_event(estimate: Array, detector: Array) -> int:
    """Number in `EVENTS` of the event that a sample confirms, 0 for none; see `RobotEventDetector`.

    Args:
        estimate: odometry estimate of the sample, see `OdometryColumn`.
        detector: (11,) state of the detector, in and out; it holds the time of the event.
    """
    t = estimate[OdometryColumn.T]
    last_t = detector[DetectorColumn.LAST_T]
    interval = t - last_t if not math.isnan(last_t) else detector[DetectorColumn.FIRST_INTERVAL]
    detector[DetectorColumn.LAST_T] = t

    if _turn_begins(estimate[OdometryColumn.YAW_RATE], detector):
        detector[DetectorColumn.EVENT_T] = t
        return _TURN

    limit = MOVING_M_S * interval
    step = estimate[OdometryColumn.STEP]
    sign = 1.0 if step > limit else -1.0 if step < -limit else 0.0
    # Nothing starts during a turn; a move under way goes on.
    if detector[DetectorColumn.TURNING] > 0.0 and sign != detector[DetectorColumn.DIRECTION]:
        sign = 0.0
    _count_samples(sign, t, detector)

    direction = detector[DetectorColumn.DIRECTION]
    if direction != 0.0 and detector[DetectorColumn.REST] >= CONFIRMATION_SAMPLES:
        detector[DetectorColumn.DIRECTION] = 0.0
        detector[DetectorColumn.REST] = 0.0
        detector[DetectorColumn.EVENT_T] = detector[DetectorColumn.REST_T]
        return _STOP if direction > 0.0 else _STOP + 1

    sign = detector[DetectorColumn.SIGN]
    if direction == 0.0 and sign != 0.0 and detector[DetectorColumn.RUN] >= CONFIRMATION_SAMPLES:
        detector[DetectorColumn.DIRECTION] = sign
        detector[DetectorColumn.REST] = 0.0
        detector[DetectorColumn.EVENT_T] = detector[DetectorColumn.RUN_T]
        return _START if sign > 0.0 else _START + 1

    return 0


@compiled_inner
def _turn_begins(yaw_rate: float, detector: Array) -> bool:
    """Whether a turn begins with this sample; updates the state of the turn."""
    if -TURNING_RAD_S <= yaw_rate <= TURNING_RAD_S:
        detector[DetectorColumn.CALM] += 1.0
        if detector[DetectorColumn.CALM] >= CONFIRMATION_SAMPLES:
            detector[DetectorColumn.TURNING] = 0.0
        return False

    begins = bool(detector[DetectorColumn.TURNING] == 0.0)
    detector[DetectorColumn.CALM] = 0.0
    detector[DetectorColumn.TURNING] = 1.0
    return begins


@compiled_inner
def _count_samples(sign: float, t: float, detector: Array) -> None:
    """Update the counts of like samples and of samples against the present direction."""
    if sign != detector[DetectorColumn.SIGN]:
        detector[DetectorColumn.SIGN] = sign
        detector[DetectorColumn.RUN] = 0.0
        detector[DetectorColumn.RUN_T] = t
    detector[DetectorColumn.RUN] += 1.0

    if sign == detector[DetectorColumn.DIRECTION]:
        detector[DetectorColumn.REST] = 0.0
        return

    if detector[DetectorColumn.REST] == 0.0:
        detector[DetectorColumn.REST_T] = t
    detector[DetectorColumn.REST] += 1.0


class RobotEventDetector:
    """Detects the robot's events in its odometry.

    A start or stop is the first of `CONFIRMATION_SAMPLES` samples on the other side of `MOVING_M_S`, a turn the first
    sample beyond `TURNING_RAD_S`. Nothing starts while the robot turns. A reversal within fewer samples still gives the
    stop first, and the start one sample later. A move too slow to cross the threshold gives no event.

    Args:
        config: rate of the odometry, for the first interval; later intervals are differences of the samples' times.

    Attributes:
        memory: (11,) state of the detector, see `DetectorColumn`.
    """

    __slots__ = ("memory",)

    def __init__(self, config: RobotConfig) -> None:
        self.memory = np.zeros(len(DetectorColumn))
        self.memory[DetectorColumn.LAST_T] = math.nan
        self.memory[DetectorColumn.FIRST_INTERVAL] = 1.0 / config.odometry_hz

    def event(self, number: int) -> tuple[Kind, float] | None:
        """The event of a number that `detect_event` has just returned, and its time [s]."""
        kind = EVENTS[number]
        return None if kind is None else (kind, self.memory.item(DetectorColumn.EVENT_T))

    def update(self, state: RobotState) -> tuple[Kind, float] | None:
        """Process one sample.

        Returns:
            the event that it confirms and the event's time [s] (for starts and stops that of an earlier sample), or
            None.
        """
        return self.event(detect_event(np.array(state), self.memory))
