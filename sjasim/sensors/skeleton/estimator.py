"""Skeleton estimation from depth frames: persons are segmented and tracked, and their joints found by random forests.

The estimator knows the sensor's height, its intrinsics and a trained model, and nothing of the true scene. The same
frames give the same skeletons in any process.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...config import MAX_TRACKED_PERSONS
from ...core import INFERRED, NOT_TRACKED, TRACKED, Array, Skeletons
from ...core.errors import SjasimError
from ..depth_camera import Intrinsics
from . import free_space, hand_localization, person_tracking, posture_prior, segmentation, surface_tracking
from .dropouts import TOUCH_M
from .foreground import Foreground, extract_foreground
from .forest import PERSON_COS, PERSON_SIN, PERSON_WIDTH
from .joint_groups import HAND_JOINTS, PALMS, TRUNK
from .joint_visibility import OCCLUDED, UNDECIDED, VISIBLE, joint_visibility
from .joint_voting import MIN_VOTES, JointVoter
from .person_measures import measure_persons
from .person_tracking import Person
from .posture_prior import JointMask
from .trained_model import MODEL_STATURE_M, SkeletonModel, default_model, runtime_model
from .yaw_voting import yaw_votes

JOINT_VOTE_POINTS = 240
"""Number of a person's points that vote for joints."""

YAW_VOTE_POINTS = 90
"""Number of a person's points that vote for the yaw."""

MIN_SURFACE_M2 = 0.02
"""Least visible surface of a person in sight (assumed)."""

MIN_NEW_SURFACE_M2 = 0.04
"""Least visible surface of a new person, at the height of the trunk (assumed)."""

MIN_OBJECT_SURFACE_M2 = 0.01
"""Least visible surface of a low object (assumed)."""

FULL_AGREEMENT = 0.25
"""Agreement of the leaves from which on the forest's yaw counts in full (assumed).

The agreement is 0 if the leaves point in all directions and 1 if all are certain of the same yaw. A person who is half
occluded may appear to have any yaw.
"""

BORDER_M = 0.12
"""A person whose visible surface has its middle this near to the left or right border is out of sight (assumed).

Half of such a person is cut off. The remaining half would be taken for the whole body, and would hold back a person who
leaves the image.
"""

MIN_TRUNK_JOINTS = 4
"""Fewest tracked trunk joints with which other joints may be inferred.

With fewer the inferred joints jump by decimetres. Measured: most false events of a session came from two or fewer.
"""

MAX_INTERVAL_S = 1.0
"""A longer gap between frames counts as this long."""


def scale_from_stature(stature_m: Array) -> Array:
    """Return stature over that of the model's person."""
    return stature_m / MODEL_STATURE_M


def person_features(measures: Array, scales: Array, yaws: Array) -> Array:
    """Return what the forests are told of each person, in the columns `forest.PERSON_X` and so on.

    Args:
        measures: (P, 5) from `person_measures.measure_persons`.
        scales: (P,) statures over 1.75 m.
        yaws: (P,) yaws relative to facing the sensor [rad].

    Returns:
        (P, 6) x and z of the trunk's surface, chest width over scale, scale, cosine and sine of the yaw.
    """
    return np.stack(
        [measures[:, 1], measures[:, 2], measures[:, 4] / scales, scales, np.cos(yaws), np.sin(yaws)], axis=1
    )  # fmt: skip


def yaw_confidence(votes: Array) -> Array:
    """Return how much the forest's yaw counts, (P,) from 0 to 1, by how well its leaves agree.

    Args:
        votes: (P, 3) from `yaw_voting.yaw_votes`.
    """
    agreement = np.hypot(votes[:, 0], votes[:, 1]) / np.maximum(votes[:, 2], 1.0)
    return np.asarray(np.minimum(agreement / FULL_AGREEMENT, 1.0) ** 2)


def sampling_fractions(counts: Array, wanted: int) -> Array:
    """Return the fraction of each person's points that gives about the wanted number; 1 if there are fewer."""
    return np.asarray(wanted / np.maximum(counts, wanted))


def _join_touching_hands(joints: Array, support: Array, agree: Array) -> None:
    """Give hands that touch their common support: each shows only half of its surface, so both are seen or none.

    Args:
        joints: (P, 25, 3) joints by the votes [m].
        support: (P, 25) weight of the votes, changed in place.
        agree: (P, 25) number of votes, changed in place.
    """
    left = HAND_JOINTS[:, 0]
    right = HAND_JOINTS[:, 1]
    x, y, z = np.moveaxis(joints[:, left] - joints[:, right], 2, 0)
    touching = x * x + y * y + z * z < TOUCH_M * TOUCH_M
    strongest = np.maximum(support[:, left], support[:, right])
    total = agree[:, left] + agree[:, right]
    for side in (left, right):
        support[:, side] = np.where(touching, strongest, support[:, side])
        agree[:, side] = np.where(touching, total, agree[:, side])


class SkeletonEstimator:
    """Estimates the skeletons of all persons from one sensor's depth frames.

    Args:
        intrinsics: pinhole model of the frames.
        height_m: height of the sensor above the floor; the sensor is level.
        far_m: joints farther away than this are inferred at best, never tracked.
        model: the trained model; by default the one that comes with the package.
    """

    def __init__(
        self, intrinsics: Intrinsics, height_m: float, far_m: float = math.inf, model: SkeletonModel | None = None
    ) -> None:
        self._intrinsics = intrinsics
        self._height_m = height_m
        self._far_m = far_m
        self._model = runtime_model(model or default_model())
        self._voter = JointVoter(self._model, MAX_TRACKED_PERSONS)
        self._foreground = Foreground.allocate(intrinsics)
        self._projection = hand_localization.image_projection(intrinsics, height_m)
        self._per_pixel = 1.0 / (intrinsics.fx * intrinsics.fy)
        self._persons: list[Person] = []
        self._low_object = np.full(2, np.nan)
        self._next_identity = 0
        self._t_s = math.nan

    def update(self, t_s: float, depth_mm: NDArray[np.uint16]) -> Skeletons:
        """Process a frame and return the skeletons of all tracked persons.

        Args:
            t_s: time of the frame, on any clock that does not jump.
            depth_mm: (H, W) depth in whole millimetres, 0 where there is none.

        Returns:
            the skeletons of all persons that are tracked, in sight or not.

        Raises:
            SjasimError: the frame has another shape or type than this sensor's frames.
        """
        self._check(depth_mm)
        interval_s = min(max(t_s - self._t_s, 0.0), MAX_INTERVAL_S) if math.isfinite(self._t_s) else 0.0
        self._t_s = t_s

        extract_foreground(depth_mm, self._intrinsics, self._height_m, self._foreground)
        for person in self._persons:
            person.predict(interval_s)
        self._segment()
        if self._persons:
            self._update_persons(interval_s)

        # A person who was never confirmed is forgotten at once.
        self._persons = [
            person
            for person in self._persons
            if person.lost_s <= (person_tracking.FORGET_S if person.confirmed else 0.0)
        ]
        self._persons = person_tracking.remove_duplicates(self._persons)
        return self._skeletons()

    def _check(self, depth_mm: NDArray[np.uint16]) -> None:
        shape = (self._intrinsics.height, self._intrinsics.width)
        if depth_mm.shape != shape or depth_mm.dtype != np.uint16:
            raise SjasimError(
                f"depth frame of shape {depth_mm.shape} and type {depth_mm.dtype}: "
                f"expected shape {shape} and type uint16, whole millimetres, 0 where there is no depth"
            )

    def _segment(self) -> None:
        """Assign the points to persons, and add or recover the persons that unassigned points show."""
        # Points that nobody claims show who is new; once they are known, the points are assigned again.
        self._assign_owners()
        places = segmentation.find_new_persons(
            self._foreground, self._intrinsics, MIN_NEW_SURFACE_M2, person_tracking.REACH_M
        )
        if places:
            for x, z in person_tracking.recover_lost(places, self._persons):
                if len(self._persons) < MAX_TRACKED_PERSONS and not self._at_border(x, z):
                    self._persons.append(Person(self._next_identity, np.array([x, z])))
                    self._next_identity += 1
            self._assign_owners()

        self._low_object = segmentation.locate_low_object(
            self._foreground, self._low_object, self._intrinsics, MIN_OBJECT_SURFACE_M2
        )

    def _assign_owners(self) -> None:
        positions = np.array([person.position for person in self._persons]).reshape(-1, 2)
        joints = np.array([self._expected_joints(person) for person in self._persons]).reshape(-1, len(JOINTS), 3)
        segmentation.assign_owners(self._foreground, positions, joints, self._low_object)

    def _expected_joints(self, person: Person) -> Array:
        """Return the predicted joints, or the mean posture for a person who is new."""
        if person.frames:
            return person.joints
        offset = np.array([person.position[0], 0.0, person.position[1]])
        return np.asarray(posture_prior.sensor_from_body(self._model.mean, 0.0) + offset)

    def _update_persons(self, interval_s: float) -> None:
        """Estimate the joints of all persons, of whom there is at least one, and update their states."""
        persons = self._persons
        positions = np.array([person.position for person in persons])
        measures = self._measure_sizes(positions, interval_s)
        scales = np.array([person.scale or 1.0 for person in persons])
        features = self._update_yaws(measures, scales, interval_s)

        prior = np.array([person.joints for person in persons])
        joints, seen, weak = self._find_joints(measures, features, prior)
        hand_localization.localize_hands(
            self._foreground, self._projection, positions[:, 1], scales, prior, joints, seen
        )
        cells = surface_tracking.measure_patches(self._foreground, prior, scales)

        pixel_m2 = self._per_pixel * positions[:, 1] ** 2
        surface_m2 = measures[:, 0] * pixel_m2
        for k, person in enumerate(persons):
            if surface_m2[k] < MIN_SURFACE_M2 or self._at_border(*measures[k, 1:3]):
                person.coast(interval_s)
                continue
            person.bridge_dropouts(joints[k], seen[k], weak[k], interval_s)
            person.update(joints[k], seen[k], self._model, interval_s, self._posture_likelihood(person, seen[k]))

            voted = np.where(seen[k][:, None], joints[k], np.nan)
            # The farther the person, the fewer pixels show the same surface.
            min_points = surface_tracking.MIN_AGREEING_M2 / pixel_m2[k]
            person.correct_depth(cells[k], prior[k], voted, min_points, interval_s)

        estimated = np.array([person.joints for person in persons])
        verdicts = joint_visibility(self._foreground.image, self._intrinsics, self._height_m, estimated, scales)
        for person, verdict in zip(persons, verdicts, strict=True):
            person.visibility = verdict

    def _measure_sizes(self, positions: Array, interval_s: float) -> Array:
        """Return the measures of all persons, see `person_measures.measure_persons`, and update their sizes."""
        # The scale of a new person is 0: unknown.
        scales = np.array([person.scale or 1.0 for person in self._persons])
        measures = measure_persons(self._foreground, positions, scales, self._per_pixel)
        for person, (count, _, _, crown_m, width_m) in zip(self._persons, measures, strict=True):
            if count:
                person.update_size(float(crown_m), float(width_m), interval_s)
        return measures

    def _update_yaws(self, measures: Array, scales: Array, interval_s: float) -> Array:
        """Return the features of all persons for the joints' forest, and update their yaws."""
        # The yaw's forest does not use the columns of the yaw, which is not known yet.
        features = person_features(measures, scales, np.zeros(len(scales)))
        fractions = sampling_fractions(measures[:, 0], YAW_VOTE_POINTS)
        votes = yaw_votes(self._foreground, self._model, fractions, self._intrinsics.fx, features)

        confidence = yaw_confidence(votes)
        for person, vote, row, sure in zip(self._persons, votes, features, confidence, strict=True):
            person.update_yaw(vote, interval_s * sure)
            row[:2] = person.smooth_surface(row[:2], interval_s)
            person.update_width(float(row[PERSON_WIDTH]))
            row[PERSON_WIDTH] = person.chest_width
            row[PERSON_COS] = math.cos(person.yaw_rad)
            row[PERSON_SIN] = math.sin(person.yaw_rad)
        return features

    def _find_joints(self, measures: Array, features: Array, prior: Array) -> tuple[Array, JointMask, JointMask]:
        """Return (P, 25, 3) joints by the votes [m], and which have sufficient support and any vote at all."""
        fractions = sampling_fractions(measures[:, 0], JOINT_VOTE_POINTS)
        joints, support, agree = self._voter.find_joints(
            self._foreground, fractions, self._intrinsics.fx, features, prior
        )
        _join_touching_hands(joints, support, agree)
        seen = (support > self._model.support) & (agree >= MIN_VOTES) & np.isfinite(joints[:, :, 0])
        return joints, seen, agree > 0.0

    def _posture_likelihood(self, person: Person, seen: JointMask) -> Array | None:
        """Return the weights of remembered postures for a person's hands; None if both hands are seen."""
        if seen[PALMS].all():
            return None
        return np.asarray(
            free_space.posture_likelihood(
                self._foreground.image, self._projection, person.position, person.yaw_rad, person.scale,
                self._model.memory, self._model.mean,
            )
        )  # fmt: skip

    def _at_border(self, x_m: float, z_m: float) -> bool:
        """Return whether the image cuts off half of a person whose visible surface has its middle there."""
        return abs(x_m) > self._intrinsics.width / (2.0 * self._intrinsics.fx) * z_m - BORDER_M

    def _skeletons(self) -> Skeletons:
        """Return the skeletons of the confirmed persons, read-only."""
        persons = [person for person in self._persons if person.confirmed]
        identities = np.array([person.identity for person in persons], dtype=np.int64)
        joints = np.array([person.joints for person in persons]).reshape(-1, len(JOINTS), 3)
        # Points have their height above the floor, skeletons relative to the sensor.
        joints[:, :, 1] -= self._height_m

        state = self._reported_states(persons, joints)
        joints[state == NOT_TRACKED] = np.nan
        for array in (identities, joints, state):
            array.flags.writeable = False
        return Skeletons(identities, joints, state)

    def _reported_states(self, persons: list[Person], joints: Array) -> NDArray[np.int8]:
        """Return the states to report: those of tracking, corrected by what the last image shows."""
        state = np.array([person.state for person in persons], dtype=np.int8).reshape(-1, len(JOINTS))
        in_sight = np.array([person.lost_s == 0.0 for person in persons], dtype=bool)
        verdict = np.array([person.visibility for person in persons]).reshape(-1, len(JOINTS))

        state[in_sight[:, None] & (state == TRACKED) & (verdict == OCCLUDED)] = INFERRED
        trunk_lost = in_sight & ((state[:, TRUNK] == TRACKED).sum(axis=1) < MIN_TRUNK_JOINTS)
        state[(in_sight & ~trunk_lost)[:, None] & (state == INFERRED) & (verdict == VISIBLE)] = TRACKED

        # Where the image does not tell, hand tips and thumbs are tracked if their hands are.
        for tips in HAND_JOINTS[2:]:
            undecided = (state[:, tips] == INFERRED) & (verdict[:, tips] == UNDECIDED)
            held = undecided & (state[:, PALMS] == TRACKED) & in_sight[:, None]
            state[:, tips] = np.where(held, TRACKED, state[:, tips])

        state[(joints[:, :, 2] > self._far_m) & (state == TRACKED)] = INFERRED
        state[trunk_lost[:, None] & (state == INFERRED)] = NOT_TRACKED
        return state
