"""Depth frames to skeletons: persons found, told apart and followed, their joints voted for by a forest's leaves.

Knows the sensor's height, its pinhole and a trained model; nothing else. The same frames give the same skeletons in
any process.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...config import MAX_TRACKED_PERSONS
from ...core import INFERRED, NOT_TRACKED, TRACKED, Array, Skeletons
from ...core.errors import SjasimError
from ..depth_camera import Intrinsics
from . import (
    free_space,
    hand_localization,
    joint_visibility,
    person_tracking,
    posture_prior,
    segmentation,
    surface_tracking,
)
from .joint_voting import MIN_VOTES, JointVoter, yaw_votes
from .person_tracking import Person
from .segmentation import Foreground
from .trained_model import SkeletonModel, default_model, runtime_model

JOINT_VOTE_POINTS, YAW_VOTE_POINTS = 240, 90
"""Points of a person that vote for joints and for the yaw."""
MIN_SURFACE_M2 = 0.02
"""Surface of a person that must be seen (assumed)."""
AGREED = 0.25
"""Agreement of the leaves from which on the forest's yaw counts in full: 0 where they point everywhere, 1 where all are
certain of one yaw. Who is half hidden may look anywhere (assumed)."""
STRANGER_M2 = 0.04
"""The same at the height of the trunk for somebody new (assumed)."""
OBJECT_M2 = 0.01
"""The same for a low object (assumed)."""
EDGE_M = 0.12
"""Somebody whose visible surface has its middle this near to the picture's left or right edge is half out of it, and
out of sight: what is left would be taken for all of the body, and hold back who leaves (assumed)."""
MIN_TRUNK_JOINTS = 4
"""With fewer joints of the trunk tracked, where the others are is a guess that jumps by decimetres: they are not
tracked (measured: most false events of a session came from two or fewer)."""
LONGEST_S = 1.0
"""A longer gap between frames counts as this long."""


def scale_from_stature(stature_m: Array) -> Array:
    """Stature over that of the model's person, 1.75 m."""
    return stature_m / 1.75


def person_features(body: Array, scales: Array, yaws: Array) -> Array:
    """(P, 6) what the forests are told of each person: x, z, width over scale, scale, cosine and sine of the yaw.

    Args:
        body: (P, 5) from `segmentation.measured`.
        scales: (P,) stature over 1.75 m.
        yaws: (P,) headings relative to facing the sensor [rad].
    """
    return np.stack([body[:, 1], body[:, 2], body[:, 4] / scales, scales, np.cos(yaws), np.sin(yaws)], axis=1)


def yaw_confidence(votes: Array) -> Array:
    """(P,) how much the forest's yaw counts, 0 to 1, by how well its leaves agree; of (P, 3) from `yaw_votes`."""
    agreed = np.hypot(votes[:, 0], votes[:, 1]) / np.maximum(votes[:, 2], 1.0)
    return np.asarray(np.minimum(agreed / AGREED, 1.0) ** 2)


def sampling_fractions(counts: Array, wanted: int) -> Array:
    """The part of a person's points that makes about as many as are wanted."""
    return np.asarray(wanted / np.maximum(counts, wanted))


@njit(cache=True)
def _join_hands(joints: Array, support: Array, agree: Array) -> None:
    """Hands that touch show each only half of their surface: where one is seen, so is the other."""
    for k in range(len(joints)):
        for left, right in person_tracking.HAND_JOINTS:
            if person_tracking.closer_than(joints[k, left], joints[k, right], person_tracking.TOUCH_M):
                support[k, left] = support[k, right] = max(support[k, left], support[k, right])
                agree[k, left] = agree[k, right] = agree[k, left] + agree[k, right]


class SkeletonEstimator:
    """One sensor's skeletons from its depth frames.

    Args:
        intrinsics: the frames' pinhole.
        height_m: of the sensor above the floor; it stands level.
        far_m: joints farther away than this are inferred at best: nobody is tracked there.
        model: the trained model; the package's own by default.
    """

    def __init__(
        self, intrinsics: Intrinsics, height_m: float, far_m: float = math.inf, model: SkeletonModel | None = None
    ) -> None:
        self._intrinsics = intrinsics
        self._height_m, self._far_m = height_m, far_m
        self._model = runtime_model(model or default_model())
        self._votes = JointVoter(self._model, MAX_TRACKED_PERSONS)
        self._scene = Foreground.allocate(intrinsics)
        self._lens = hand_localization.image_projection(intrinsics, height_m)
        self._per_pixel = 1.0 / (intrinsics.fx * intrinsics.fy)
        self._persons: list[Person] = []
        self._low = np.full(2, np.nan)
        self._next = 0
        self._t_s = math.nan

    def update(self, t_s: float, depth_mm: NDArray[np.uint16]) -> Skeletons:
        """Take a frame.

        Args:
            t_s: time of the frame on any clock that does not jump.
            depth_mm: (H, W) depth in whole millimetres, 0 where there is none.

        Returns:
            everybody who is followed, whether in sight or not; joints of nobody are ever made up.

        Raises:
            SjasimError: the frame is not what this sensor delivers.
        """
        self._check(depth_mm)
        interval_s = min(max(t_s - self._t_s, 0.0), LONGEST_S) if math.isfinite(self._t_s) else 0.0
        self._t_s = t_s
        segmentation.extract_foreground(depth_mm, self._intrinsics, self._height_m, self._scene)
        for person in self._persons:
            person.predict(interval_s)
        self._separate()
        self._recognise(interval_s)
        gone = person_tracking.FORGET_S
        self._persons = [one for one in self._persons if one.missing_s <= (gone if one.confirmed else 0.0)]
        self._persons = person_tracking.remove_duplicates(self._persons)
        return self._skeletons()

    def _check(self, depth_mm: NDArray[np.uint16]) -> None:
        shape = (self._intrinsics.height, self._intrinsics.width)
        if depth_mm.shape != shape or depth_mm.dtype != np.uint16:
            raise SjasimError(
                f"depth frame of shape {depth_mm.shape} and type {depth_mm.dtype}: "
                f"wanted {shape} whole millimetres, uint16, 0 where there is none"
            )

    def _separate(self) -> None:
        """Share the points out, and meet whoever is new."""
        self._share()
        area = STRANGER_M2
        strange = segmentation.find_new_persons(self._scene, self._intrinsics, area, person_tracking.REACH_M)
        if strange:
            for x, z in person_tracking.recover_lost(strange, self._persons):
                if len(self._persons) < MAX_TRACKED_PERSONS and not self._half_out(x, z):
                    self._persons.append(Person(self._next, np.array([x, z])))
                    self._next += 1
            self._share()
        self._low = segmentation.locate_low_object(self._scene, self._low, self._intrinsics, OBJECT_M2)

    def _share(self) -> None:
        places = np.array([person.place for person in self._persons]).reshape(-1, 2)
        joints = np.array([self._expected(person) for person in self._persons]).reshape(-1, len(JOINTS), 3)
        segmentation.assign_owners(self._scene, places, joints, self._low)

    def _expected(self, person: Person) -> Array:
        """Predicted joints, or those of anybody for somebody new."""
        if person.frames:
            return person.joints
        offset = np.array([person.place[0], 0.0, person.place[1]])
        return np.asarray(posture_prior.sensor_from_body(self._model.mean, 0.0) + offset)

    def _recognise(self, interval_s: float) -> None:
        persons, fx = self._persons, self._intrinsics.fx
        if not persons:
            return
        places = np.array([person.place for person in persons])
        known = np.array([person.scale or 1.0 for person in persons])
        body = segmentation.measure_persons(self._scene, places, known, self._per_pixel)
        for person, (count, _, _, crown, width) in zip(persons, body, strict=True):
            if count:
                person.update_size(float(crown), float(width), interval_s)
        scales = np.array([person.scale or 1.0 for person in persons])
        rows = person_features(body, scales, np.zeros(len(persons)))
        pixel_m2 = self._per_pixel * places[:, 1] ** 2
        surface = body[:, 0] * pixel_m2
        turned = yaw_votes(self._scene, self._model, sampling_fractions(body[:, 0], YAW_VOTE_POINTS), fx, rows)
        sure = yaw_confidence(turned)
        for person, votes, row, share in zip(persons, turned, rows, sure, strict=True):
            person.update_yaw(votes, interval_s * share)
            row[:2] = person.smooth_surface(row[:2], interval_s)
            person.width += 0.1 * (float(row[2]) - person.width)
            row[2], row[4], row[5] = person.width, math.cos(person.yaw_rad), math.sin(person.yaw_rad)
        prior = np.array([person.joints for person in persons])
        taken = sampling_fractions(body[:, 0], JOINT_VOTE_POINTS)
        joints, support, agree = self._votes.find_joints(self._scene, taken, fx, rows, prior)
        _join_hands(joints, support, agree)
        seen = (support > self._model.support) & (agree >= MIN_VOTES) & np.isfinite(joints[:, :, 0])
        hand_localization.localize_hands(self._scene, self._lens, places[:, 1], scales, prior, joints, seen)
        cells = surface_tracking.measure_patches(self._scene, prior, scales)
        for k, person in enumerate(persons):
            if surface[k] < MIN_SURFACE_M2 or self._half_out(*body[k, 1:3]):
                person.coast(interval_s)
                continue
            person.bridge_dropouts(joints[k], seen[k], agree[k] > 0.0, interval_s)
            person.update(joints[k], seen[k], self._model, interval_s, self._believed(person, seen[k]))
            voted = np.where(seen[k][:, None], joints[k], np.nan)
            person.correct_depth(cells[k], prior[k], voted, surface_tracking.MIN_AGREEING_M2 / pixel_m2[k], interval_s)
        joints = np.array([person.joints for person in persons])
        shown = joint_visibility.joint_visibility(self._scene.image, self._intrinsics, self._height_m, joints, scales)
        for person, limbs in zip(persons, shown, strict=True):
            person.shown = limbs

    def _believed(self, person: Person, seen: posture_prior.JointMask) -> Array | None:
        """How far remembered postures count for a person's hands; asked only while one is not seen."""
        if seen[hand_localization.PALMS].all():
            return None
        of = person.place, person.yaw_rad, person.scale, self._model.memory, self._model.mean
        return np.asarray(free_space.posture_likelihood(self._scene.image, self._lens, *of))

    def _half_out(self, x_m: float, z_m: float) -> bool:
        """Whether the picture cuts off half of somebody whose visible surface has its middle there."""
        return abs(x_m) > self._intrinsics.width / (2.0 * self._intrinsics.fx) * z_m - EDGE_M

    def _skeletons(self) -> Skeletons:
        persons = [person for person in self._persons if person.confirmed]
        names = np.array([person.name for person in persons], dtype=np.int64)
        joints = np.array([person.joints for person in persons]).reshape(-1, len(JOINTS), 3)
        state = np.array([person.state for person in persons], dtype=np.int8).reshape(-1, len(JOINTS))
        joints[:, :, 1] -= self._height_m
        in_sight = np.array([person.missing_s == 0.0 for person in persons], dtype=bool)
        shown = np.array([person.shown for person in persons]).reshape(-1, len(JOINTS))
        state[in_sight[:, None] & (state == TRACKED) & (shown == joint_visibility.OCCLUDED)] = INFERRED
        guessed = in_sight & ((state[:, posture_prior.TRUNK] == TRACKED).sum(axis=1) < MIN_TRUNK_JOINTS)
        state[(in_sight & ~guessed)[:, None] & (state == INFERRED) & (shown == joint_visibility.VISIBLE)] = TRACKED
        for tips in person_tracking.HAND_JOINTS[2:]:  # where the image does not tell, the hand that they sit on does
            held = (state[:, tips] == INFERRED) & (shown[:, tips] == 0) & (state[:, hand_localization.PALMS] == TRACKED)
            state[:, tips] = np.where(held & in_sight[:, None], TRACKED, state[:, tips])
        state[(joints[:, :, 2] > self._far_m) & (state == TRACKED)] = INFERRED
        state[guessed[:, None] & (state == INFERRED)] = NOT_TRACKED
        joints[state == NOT_TRACKED] = np.nan
        for array in (names, joints, state):
            array.flags.writeable = False
        return Skeletons(names, joints, state)
