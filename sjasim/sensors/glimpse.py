"""What the detectors look at: a few numbers per person from each frame.

Two gathers take what matters out of a frame for all persons at once; the few dozen sums that follow are plain
floats, which for three persons costs a third of what array operations do.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from ..assets.names import JOINT_INDEX
from ..config import DetectorConfig
from ..types import TRACKED, Array, SkeletonFrame


class Glimpse(NamedTuple):
    """One person in one frame.

    Attributes:
        speed_m_s: SpineBase's speed towards the sensor over the last ``difference_frames`` frames; NaN before that.
        towards: how many of SpineMid, Neck and both shoulders moved towards the sensor by more than the floor.
        away: the same away from the sensor.
        tracked: how many of the four are tracked; the others are not counted above.
        hand_ratio: hand distance over shoulder distance in the sensor's x-y plane; NaN unless both hands are tracked.
            The shoulders are its scale only, and may be inferred: raised forearms hide them.
        yaw_rad: heading relative to facing the sensor, counter-clockwise from above; NaN if a hip is missing.
        yaw_rate_rad_s: its rate over the same frames as the speed.
    """

    speed_m_s: float
    towards: int
    away: int
    tracked: int
    hand_ratio: float
    yaw_rad: float
    yaw_rate_rad_s: float


class Places(NamedTuple):
    """Coordinates of one person that the detectors need, in the sensor's frame [m]."""

    base_z: float
    mid_z: float
    neck_z: float
    left_z: float
    right_z: float
    left_x: float
    right_x: float
    left_y: float
    right_y: float
    left_hand_x: float
    right_hand_x: float
    left_hand_y: float
    right_hand_y: float
    left_hip_x: float
    right_hip_x: float
    left_hip_z: float
    right_hip_z: float

    def yaw_rad(self) -> float:
        """Heading relative to facing the sensor, from the lines across shoulders and hips.

        From the hips alone where a shoulder is missing (it leaves the range first); NaN where a hip is.
        """
        hips_x, hips_z = self.left_hip_x - self.right_hip_x, self.left_hip_z - self.right_hip_z
        x, z = hips_x + self.left_x - self.right_x, hips_z + self.left_z - self.right_z
        return math.atan2(hips_z, -hips_x) if math.isnan(x + z) else math.atan2(z, -x)

    def hand_ratio(self) -> float:
        """Hand distance over shoulder distance, both as the sensor sees them; NaN if the shoulders coincide."""
        shoulders = math.hypot(self.left_x - self.right_x, self.left_y - self.right_y)
        hands = math.hypot(self.left_hand_x - self.right_hand_x, self.left_hand_y - self.right_hand_y)
        return hands / shoulders if shoulders > 0.0 else math.nan


_PLACES = np.array(
    [
        3 * JOINT_INDEX[joint] + "xyz".index(axis)
        for joint, axis in (
            ("SpineBase", "z"), ("SpineMid", "z"), ("Neck", "z"), ("ShoulderLeft", "z"), ("ShoulderRight", "z"),
            ("ShoulderLeft", "x"), ("ShoulderRight", "x"), ("ShoulderLeft", "y"), ("ShoulderRight", "y"),
            ("HandLeft", "x"), ("HandRight", "x"), ("HandLeft", "y"), ("HandRight", "y"),
            ("HipLeft", "x"), ("HipRight", "x"), ("HipLeft", "z"), ("HipRight", "z"),
        )
    ]
)  # fmt: skip
"""Columns of a flattened skeleton, in the order of `Places`."""

_STATES = np.array(
    [JOINT_INDEX[name] for name in ("SpineMid", "Neck", "ShoulderLeft", "ShoulderRight", "HandLeft", "HandRight")]
)

_HANDS_TRACKED = [TRACKED] * 2
"""The last two of `_STATES` when a clap can be seen."""


def places(joints: Array) -> list[Places]:
    """Take out what the detectors need.

    Args:
        joints: (P, 25, 3) in the sensor's frame [m].

    Returns:
        one value for each of the P persons.
    """
    rows = joints.reshape(len(joints), 3 * len(JOINT_INDEX)).take(_PLACES, axis=1).tolist()
    return [Places._make(row) for row in rows]


class _Past(NamedTuple):
    t_s: float
    places: list[Places]
    yaws: list[float]


class Glimpses:
    """Turns frames into glimpses; remembers as many frames as a speed needs.

    A lost frame only widens the intervals: every difference is divided by the time that really passed between its
    two frames. Joints that are not tracked are NaN and make every figure they enter NaN.

    Args:
        config: frames per speed and the early events' floor.
        rate_hz: nominal frame rate, which turns the floor per frame into a speed.

    Attributes:
        span_s: time over which the last frame's speeds were taken [s].
    """

    def __init__(self, config: DetectorConfig, rate_hz: int) -> None:
        self._floor_m_s = config.early_step_m * rate_hz
        self._frames = config.difference_frames
        self._past: deque[_Past] = deque(maxlen=self._frames)
        self.span_s = 0.0

    def reset(self) -> None:
        """Forget the frames."""
        self._past.clear()

    def update(self, frame: SkeletonFrame) -> list[Glimpse]:
        """Look at a frame.

        Args:
            frame: the newest frame, with the same persons as the frames before it.

        Returns:
            one glimpse for each of its P persons.
        """
        t_s = frame.t_sensor_s
        now = places(frame.skeletons.joints)
        states = frame.skeletons.state.take(_STATES, axis=1).tolist()
        before = self._past[-1] if self._past else _Past(t_s, now, [])
        floor_m = self._floor_m_s * (t_s - before.t_s)
        oldest = self._past[0] if len(self._past) == self._frames else None
        self.span_s = t_s - oldest.t_s if oldest else 0.0
        seen = []
        for row, place in enumerate(now):
            yaw = place.yaw_rad()
            speed = turned = math.nan
            if oldest:
                speed = (oldest.places[row].base_z - place.base_z) / self.span_s
                turned = math.remainder(yaw - oldest.yaws[row], math.tau) / self.span_s
            towards, away, tracked = _compare(place, before.places[row], states[row], floor_m)
            ratio = place.hand_ratio() if states[row][4:] == _HANDS_TRACKED else math.nan
            seen.append(Glimpse(speed, towards, away, tracked, ratio, yaw, turned))
        self._past.append(_Past(t_s, now, [glimpse.yaw_rad for glimpse in seen]))
        return seen


def _compare(now: Places, before: Places, states: list[int], floor_m: float) -> tuple[int, int, int]:
    """Counts of upper joints going towards the sensor, going away from it, and tracked."""
    mid_state, neck_state, left_state, right_state, *_ = states
    mid_ok, neck_ok = mid_state == TRACKED, neck_state == TRACKED
    left_ok, right_ok = left_state == TRACKED, right_state == TRACKED
    mid, neck = before.mid_z - now.mid_z, before.neck_z - now.neck_z
    left, right = before.left_z - now.left_z, before.right_z - now.right_z
    towards = (mid_ok and mid > floor_m) + (neck_ok and neck > floor_m)
    towards += (left_ok and left > floor_m) + (right_ok and right > floor_m)
    away = (mid_ok and mid < -floor_m) + (neck_ok and neck < -floor_m)
    away += (left_ok and left < -floor_m) + (right_ok and right < -floor_m)
    return towards, away, mid_ok + neck_ok + left_ok + right_ok
