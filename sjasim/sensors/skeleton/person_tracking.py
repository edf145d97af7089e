"""Tracked persons: position, stature, yaw and joints of each person over time.

All rules are in seconds, so that a sensor with five frames a second and one with thirty follow the same ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...core import INFERRED, NOT_TRACKED, Array
from . import dropouts, joint_filter, posture_prior, surface_tracking
from .joint_groups import SPINE_BASE, SPINE_MID
from .posture_prior import JointMask
from .trained_model import MODEL_STATURE_M, RuntimeModel

CONFIRM_FRAMES = 3
"""Number of frames in which a person must be detected before it is reported."""

INFER_S = 0.6
"""How long the joints of a person out of sight are inferred (assumed)."""

FORGET_S = 3.0
"""Time after which a person out of sight is removed (assumed)."""

COAST_S = 1.0
"""Time constant with which the velocity of a person out of sight decays (assumed)."""

REACH_M = 0.5
"""Distance from where a person was lost within which the person is recovered at once (assumed)."""

REACH_M_S = 1.0
"""Rate at which this distance grows (assumed)."""

MIN_DISTANCE_M = 0.30
"""Smallest distance between two persons; of two that are closer, the one detected later is removed (assumed)."""

SPEED_S = 0.10
"""Time constant of the trunk's velocity (assumed)."""

SPIN_S = 0.15
"""Time constant of the turning rate (assumed)."""

YAW_S = 0.25
"""Time constant with which the forest's yaw corrects the tracked one (assumed)."""

YAW_WRONG_RAD = math.radians(60.0)
"""Difference of the two yaws beyond which the tracked one is assumed to be wrong (assumed).

The forest is trusted then, because it estimates each frame independently and does not carry errors over.
"""

YAW_WRONG_S = 0.08
"""Time constant of the correction beyond `YAW_WRONG_RAD` (assumed)."""

SKELETON_YAW_RAD = math.radians(40.0)
"""The yaw of the skeleton's own shoulders and hips counts if it is this near to the tracked one (assumed)."""

SKELETON_YAW_S = 0.08
"""Time constant with which it corrects the tracked one (assumed)."""

SURFACE_S = 0.15
"""Time constant of the offset from the trunk's joints to its surface (assumed)."""

FRONTAL_COS = (0.70, 0.90)
"""Cosine of the yaw below which the trunk's surface is ignored, and above which it counts in full (assumed).

From the side a sensor sees arms that swing and flanks that pass.
"""

PATCH_MOTION_S = 0.03
"""Time constant with which a joint leaves its predicted motion for its patch's (assumed)."""

PATCH_LEARNING_S = 1.5
"""Time constant with which votes correct a patch (assumed)."""

PATCH_SPIN_RAD_S = 0.4
"""Turning rate at which `PATCH_LEARNING_S` is halved, because another side comes into view (assumed)."""

CROWN = 0.959
"""Height of the crown over stature, as its pixels show it during a dance (measured on dances of unknown builds)."""

STATURE_M = (1.35, 2.10)
"""Smallest and largest plausible stature (assumed)."""

GROW_S = 0.3
"""Time constant with which a higher crown is believed (assumed)."""

SHRINK_S = 4.0
"""Time constant with which a lower crown is believed (assumed)."""

OCCLUDED_CROWN = 0.93
"""A crown below this share of the estimated one is occluded (assumed)."""

WIDTH_GAIN = 0.1
"""Share by which the chest width follows the measured one in each frame (assumed)."""


def filter_gain(interval_s: float, constant_s: float) -> float:
    """Return the gain of a first-order low-pass filter over an interval."""
    return 1.0 - math.exp(-interval_s / constant_s)


def wrap_angle(angle_rad: float) -> float:
    """Return the equivalent angle from -pi to pi."""
    return math.remainder(angle_rad, math.tau)


@dataclass(slots=True)
class Person:
    """State of one person that a sensor tracks; positions are points: x, height, z [m].

    Attributes:
        identity: number of the person, never used twice.
        position: (2,) x and z of the trunk [m].
        velocity: (2,) its rate [m/s].
        yaw_rad: yaw relative to facing the sensor; NaN while unknown.
        last_yaw_rad: yaw at the end of the last frame; NaN before the first.
        spin_rad_s: smoothed turning rate.
        scale: stature over `MODEL_STATURE_M`; 0 while unknown.
        chest_width: width of the chest over scale [m].
        surface_offset: (2,) smoothed offset from the position to the middle of the trunk's surface [m].
        frames: number of frames in which the person was seen.
        lost_s: time since the person was last seen.
        joints: (25, 3) latest joints, NaN before the first frame [m].
        state: (25,) tracking states.
        offset: (25, 3) remaining distance of joints that reappeared, see `joint_filter.filter_joints` [m].
        unseen_s: (25,) how long joints have lacked support.
        patches: remembered surface of the trunk, see `surface_tracking.initial_patches`.
        visibility: (25,) verdicts of the last image, see `joint_visibility.joint_visibility`.
    """

    identity: int
    position: Array
    velocity: Array = field(default_factory=lambda: np.zeros(2))
    yaw_rad: float = math.nan
    last_yaw_rad: float = math.nan
    spin_rad_s: float = 0.0
    scale: float = 0.0
    chest_width: float = 0.0
    surface_offset: Array = field(default_factory=lambda: np.full(2, np.nan))
    frames: int = 0
    lost_s: float = 0.0
    joints: Array = field(default_factory=lambda: np.full((len(JOINTS), 3), np.nan))
    state: NDArray[np.int8] = field(default_factory=lambda: np.zeros(len(JOINTS), np.int8))
    offset: Array = field(default_factory=lambda: np.zeros((len(JOINTS), 3)))
    unseen_s: Array = field(default_factory=lambda: np.zeros(len(JOINTS)))
    patches: Array = field(default_factory=surface_tracking.initial_patches)
    visibility: NDArray[np.int8] = field(default_factory=lambda: np.zeros(len(JOINTS), np.int8))

    @property
    def confirmed(self) -> bool:
        """Whether the person was seen often enough to be reported."""
        return self.frames >= CONFIRM_FRAMES

    def predict(self, interval_s: float) -> None:
        """Move the person on at constant velocity."""
        step = self.velocity * interval_s
        self.position = self.position + step
        # Heights do not change: persons move over the floor.
        self.joints[:, 0] += step[0]
        self.joints[:, 2] += step[1]

    def update_size(self, crown_m: float, width_m: float, interval_s: float) -> None:
        """Correct the scale by the measured height of the crown; the first call sets the chest width as well."""
        stature_m = min(max(crown_m / CROWN, STATURE_M[0]), STATURE_M[1])
        measured = stature_m / MODEL_STATURE_M
        if self.scale == 0.0:
            self.scale = measured
            self.chest_width = width_m / measured
            return

        if measured > self.scale:
            self.scale += filter_gain(interval_s, GROW_S) * (measured - self.scale)
        elif measured > OCCLUDED_CROWN * self.scale:
            self.scale += filter_gain(interval_s, SHRINK_S) * (measured - self.scale)

    def update_width(self, width: float) -> None:
        """Correct the chest width by the measured one, over scale [m]."""
        self.chest_width += WIDTH_GAIN * (width - self.chest_width)

    def smooth_surface(self, middle: Array, interval_s: float) -> Array:
        """Return the smoothed position (2,) of the trunk's surface: jitter of it would move every joint."""
        offset = middle - self.position
        if math.isnan(self.surface_offset[0]):
            self.surface_offset = offset
        self.surface_offset = self.surface_offset + filter_gain(interval_s, SURFACE_S) * (offset - self.surface_offset)
        return np.asarray(self.position + self.surface_offset)

    def update_yaw(self, votes: Array, interval_s: float) -> None:
        """Correct the yaw by the forest's votes; without votes an unknown yaw becomes 0.

        Args:
            votes: sums of cosines and sines, from `yaw_voting.yaw_votes`.
            interval_s: time since the last frame, times the confidence in the votes.
        """
        if votes[0] == votes[1] == 0.0:
            self.yaw_rad = 0.0 if math.isnan(self.yaw_rad) else self.yaw_rad
            return

        voted_rad = math.atan2(votes[1], votes[0])
        if math.isnan(self.yaw_rad):
            self.yaw_rad = voted_rad
            return
        error_rad = wrap_angle(voted_rad - self.yaw_rad)
        constant_s = YAW_WRONG_S if abs(error_rad) > YAW_WRONG_RAD else YAW_S
        self.yaw_rad = wrap_angle(self.yaw_rad + filter_gain(interval_s, constant_s) * error_rad)

    def coast(self, interval_s: float) -> None:
        """Account for a frame without the person: the velocity decays, and after `INFER_S` nothing is tracked."""
        self.lost_s += interval_s
        self.velocity = self.velocity * (1.0 - filter_gain(interval_s, COAST_S))
        self.offset[:] = 0.0
        state = INFERRED if self.lost_s <= INFER_S else NOT_TRACKED
        self.state = np.where(np.isnan(self.joints[:, 0]), NOT_TRACKED, state).astype(np.int8)

    def bridge_dropouts(self, joints: Array, seen: JointMask, weak: JointMask, interval_s: float) -> None:
        """Decide which joints count as seen in this frame, see `dropouts.bridge_dropouts`.

        Args:
            joints: (25, 3) joints by the votes [m]; a hand that the other one hides is moved beside it.
            seen: (25,) joints with sufficient support; changed in place.
            weak: (25,) joints with a vote at all; changed in place.
            interval_s: time since the last frame.
        """
        dropouts.bridge_dropouts(
            joints, self.joints, self.state, weak, self.yaw_rad, self.scale, interval_s, self.unseen_s, seen
        )  # fmt: skip

    def update(
        self, joints: Array, seen: JointMask, model: RuntimeModel, interval_s: float, likelihood: Array | None = None
    ) -> None:
        """Update the person by a frame's joints; without a joint of the trunk the person coasts.

        Args:
            joints: (25, 3) joints by the votes, NaN where there are none [m].
            seen: (25,) which of them count.
            model: its regression and its remembered postures are used.
            interval_s: time since the last frame.
            likelihood: (N, 2) weights of the remembered postures for the hands, see `free_space.posture_likelihood`;
                all are 1 by default.
        """
        self._correct_yaw(posture_prior.estimate_yaw(joints, seen), interval_s)
        if likelihood is None:
            likelihood = np.ones((len(model.memory), 2))

        posture = np.empty_like(joints)
        found = posture_prior.estimate_posture(
            joints, seen, model.posture, model.memory, model.mean, self.yaw_rad, self.scale, self.chest_width,
            likelihood, posture,
        )  # fmt: skip
        if not found:
            self.coast(interval_s)
            return

        joint_filter.filter_joints(
            joints, seen, posture, self.yaw_rad, self.spin_rad_s, interval_s, self.joints, self.state, self.offset
        )  # fmt: skip
        self._update_motion(interval_s)

    def correct_depth(
        self, cells: Array, predicted: Array, voted: Array, min_points: float, interval_s: float
    ) -> None:  # fmt: skip
        """Correct the frame's joints by the trunk's surface, see `surface_tracking.correct_depth_from_surface`.

        Args:
            cells: (A, C, 2) from `surface_tracking.measure_patches`.
            predicted: (25, 3) joints that they were measured for [m].
            voted: (25, 3) joints by the votes; NaN where they do not count [m].
            min_points: least number of points of a patch that must agree.
            interval_s: time since the last frame.
        """
        learning_s = PATCH_LEARNING_S / (1.0 + (self.spin_rad_s / PATCH_SPIN_RAD_S) ** 2)
        frontal = (abs(math.cos(self.yaw_rad)) - FRONTAL_COS[0]) / (FRONTAL_COS[1] - FRONTAL_COS[0])
        gains = surface_tracking.PatchGains(
            motion=filter_gain(interval_s, PATCH_MOTION_S),
            learning=filter_gain(interval_s, learning_s),
            correction=min(max(frontal, 0.0), 1.0),
        )
        surface_tracking.correct_depth_from_surface(
            cells, self.patches, predicted, voted, min_points, gains, interval_s, self.joints
        )  # fmt: skip

    def _correct_yaw(self, skeleton_yaw_rad: float, interval_s: float) -> None:
        """Correct the yaw by the skeleton's own, unless the two contradict each other, and update the turning rate."""
        before_rad = self.last_yaw_rad
        error_rad = math.inf if math.isnan(skeleton_yaw_rad) else wrap_angle(skeleton_yaw_rad - self.yaw_rad)
        if abs(error_rad) < SKELETON_YAW_RAD:
            self.yaw_rad = wrap_angle(self.yaw_rad + filter_gain(interval_s, SKELETON_YAW_S) * error_rad)

        self.last_yaw_rad = self.yaw_rad
        if interval_s > 0.0 and not math.isnan(before_rad):
            rate_rad_s = wrap_angle(self.yaw_rad - before_rad) / interval_s
            self.spin_rad_s += filter_gain(interval_s, SPIN_S) * (rate_rad_s - self.spin_rad_s)

    def _update_motion(self, interval_s: float) -> None:
        """Set position and velocity from the joints of this frame."""
        position = 0.5 * (self.joints[SPINE_BASE, ::2] + self.joints[SPINE_MID, ::2])
        if self.frames and interval_s > 0.0:
            error = (position - self.position) / interval_s
            # Along the view the joints of a person who stands sideways are less certain.
            constant_s = SPEED_S * (1.0 + joint_filter.SIDEWAYS * math.sin(self.yaw_rad) ** 2)
            self.velocity = self.velocity + filter_gain(interval_s, constant_s) * error
        self.position = position
        self.frames += 1
        self.lost_s = 0.0


def remove_duplicates(persons: list[Person]) -> list[Person]:
    """Return the persons without those that stand in the place of another one who was seen in more frames."""
    kept: list[Person] = []
    for person in sorted(persons, key=lambda one: -one.frames):
        duplicates = (
            math.dist(person.position, other.position) < MIN_DISTANCE_M for other in kept if other.lost_s == 0.0
        )
        if person.lost_s > 0.0 or not any(duplicates):
            kept.append(person)
    return [person for person in persons if any(person is one for one in kept)]


def recover_lost(places: list[tuple[float, float]], persons: list[Person]) -> list[tuple[float, float]]:
    """Assign places of new persons to persons out of sight, and return the places that remain.

    A lost person moves to the nearest place within reach; the reach grows with the time since the loss.

    Args:
        places: x and z of each [m].
        persons: all persons; those who are recovered are moved.
    """
    # All pairs in order of their distance beyond the reach that has grown since the loss.
    lost = [person for person in persons if person.lost_s > 0.0]
    pairs = sorted(
        (float(np.hypot(*(person.position - place))) - REACH_M_S * person.lost_s, index, row)
        for index, person in enumerate(lost)
        for row, place in enumerate(places)
    )

    remaining = list(places)
    recovered: set[int] = set()
    for beyond_m, index, row in pairs:
        if beyond_m > REACH_M or index in recovered or places[row] not in remaining:
            continue
        recovered.add(index)
        remaining.remove(places[row])
        shift = np.array(places[row]) - lost[index].position
        lost[index].position = np.array(places[row])
        lost[index].joints[:, [0, 2]] += shift
    return remaining
