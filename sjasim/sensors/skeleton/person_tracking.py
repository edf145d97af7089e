"""Persons over time: who is where, how tall, which way turned, and what is known of each joint.

Times are in seconds everywhere, so that a sensor that takes five frames a second and one that takes thirty follow
the same rules.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...assets.names import JOINT_INDEX, JOINTS
from ...core import INFERRED, NOT_TRACKED, TRACKED, Array
from ...core.memory import put
from . import joint_filter, posture_prior, surface_tracking
from .trained_model import RuntimeModel

CONFIRM_FRAMES = 3
"""Frames in which somebody must have been seen before there is a person."""
INFER_S, FORGET_S = 0.6, 3.0
"""A person out of sight is inferred so long, and remembered so long (assumed)."""
COAST_S = 1.0
"""Time constant with which the speed of somebody out of sight is believed (assumed)."""
REACH_M, REACH_M_S = 0.5, 1.0
"""How far from where they were lost somebody is looked for, and how that grows (assumed)."""
SAME_M = 0.30
"""Two persons cannot stand closer than this; the younger is a mistake (assumed)."""
SPEED_S, SPIN_S = 0.10, 0.15
"""Time constants of the trunk's velocity, and of the rate at which it turns (assumed)."""
YAW_S, YAW_ASTRAY_RAD, YAW_ASTRAY_S = 0.25, math.radians(60.0), 0.08
"""Time constant with which the forest's yaw corrects the tracked one, and the time constant beyond an angle at which
only one of them can be right: the forest, which does not remember its mistakes (assumed)."""
OWN_YAW_RAD, OWN_YAW_S = math.radians(40.0), 0.08
"""The skeleton's own heading counts if it is so near, with this time constant (assumed)."""
SURFACE_S = 0.15
"""Time constant of where the trunk's surface lies before its joints (assumed)."""
FRONTAL = (0.70, 0.90)
"""Cosines of the yaw from which on the trunk's surface says anything of its motion along the view, and all: what a
sensor sees at the side are arms that swing and flanks that pass (assumed)."""
ANCHOR_S = 0.03
"""Time constant with which a joint leaves its predicted motion for its patch's (assumed)."""
LEARN_S, LEARN_SPIN_RAD_S = 1.5, 0.4
"""Time constant with which votes correct a patch: shorter the faster the person turns, who shows another side of
them; at this rate a patch counts half (assumed)."""
TOUCH_M, CLASP_S = 0.16, 0.4
"""Hands that were seen closer than this hide each other, and are known for so long all the same (assumed)."""
ASIDE_M = 0.17
"""Hands do not meet so far beside the trunk's middle: what looks like both is the hand of that side (assumed)."""
MEET_M, CLOSING_RATIO = 0.22, 0.7
"""Tracked hands so near are about to touch; of what lies between them so much is left a frame later (assumed)."""
HOLD_S, WEAK_S, HOLD_M = 0.08, 0.15, 0.15
"""A joint that was tracked is for so long without a vote, and for so long with too few, while it is found this near to
its prediction (assumed)."""
LEAP_S, LEAP_M = 0.12, 0.25
"""A joint that leaps farther than this in a frame is not believed for so long (assumed)."""
CROWN = 0.959
"""Height of the crown over stature, as its pixels show it in a dance (measured on dances of unknown builds)."""
STATURE_M = (1.35, 2.10)
"""Statures that are believed."""
RISE_S, SINK_S, HIDDEN_SHARE = 0.3, 4.0, 0.93
"""How fast a larger and a smaller crown is believed; a crown below this share of it is a hidden one (assumed)."""

HAND_JOINTS = np.array([[JOINT_INDEX[f"{name}{side}"] for side in ("Left", "Right")]
                  for name in ("Wrist", "Hand", "HandTip", "Thumb")])  # fmt: skip
"""(4, 2) wrists, hands, tips and thumbs, left and right."""
ELBOWS = np.array([JOINT_INDEX["ElbowLeft"], JOINT_INDEX["ElbowRight"]])
FOREARM_M, LINK_M = (0.34, 0.42), 0.16
"""No wrist and no hand is so far from its elbow, and no hand so far from its wrist, over the scale: a quarter more than
a forearm's length, and twice that of half a hand (assumed)."""
_BASE, _MID = JOINT_INDEX["SpineBase"], JOINT_INDEX["SpineMid"]


def filter_gain(interval_s: float, constant_s: float) -> float:
    """Share of the way to go in an interval."""
    return 1.0 - math.exp(-interval_s / constant_s)


@njit(cache=True)
def closer_than(one: Array, other: Array, limit_m: float) -> bool:
    """Whether two points (3,) are closer than a limit; not so where either is unknown."""
    x, y, z = one[0] - other[0], one[1] - other[1], one[2] - other[2]
    return bool(x * x + y * y + z * z < limit_m * limit_m)


@njit(cache=True)
def _reach(joints: Array, before: Array, scale: float, unseen_s: Array, seen: posture_prior.JointMask) -> None:
    """See no wrist and no hand beyond a forearm's reach, and no hand held where its wrist is not, or the reverse."""
    for side in range(2):
        wrist, fist, elbow = HAND_JOINTS[0, side], HAND_JOINTS[1, side], ELBOWS[side]
        place = joints[elbow] if seen[elbow] else before[elbow]
        for j, limit_m in ((wrist, FOREARM_M[0]), (fist, FOREARM_M[1])):
            if seen[j] and not math.isnan(place[0]) and not closer_than(joints[j], place, limit_m * scale):
                seen[j] = False
        held = wrist if unseen_s[wrist] > unseen_s[fist] else fist
        if (
            seen[wrist]
            and seen[fist]
            and unseen_s[held] > 0.0
            and not closer_than(joints[wrist], joints[fist], LINK_M * scale)
        ):
            seen[held] = False


@njit(cache=True)
def _hold(
    joints: Array, before: Array, state: NDArray[np.int8], weak: posture_prior.JointMask, yaw_rad: float, scale: float,
    interval_s: float, unseen_s: Array, seen: posture_prior.JointMask,
) -> None:  # fmt: skip
    """See `Person.hold`; ``before`` are the joints as predicted."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    limit_s, twin = np.full(len(seen), HOLD_S), np.full(len(seen), -1)
    for left, right in HAND_JOINTS:
        known = state[left] == state[right] == TRACKED
        middle = 0.5 * (joints[left] + joints[right]) - before[_MID]
        aside = sin * middle[2] - cos * middle[0]
        if abs(aside) > ASIDE_M and closer_than(joints[left], joints[right], TOUCH_M):
            seen[right if aside > 0.0 else left] = weak[right if aside > 0.0 else left] = False
        elif closer_than(joints[left], joints[right], TOUCH_M) or (
            known and closer_than(before[left], before[right], MEET_M)
        ):
            limit_s[left] = limit_s[right] = CLASP_S
            twin[left], twin[right] = right, left
    for j in range(len(seen)):
        if (
            seen[j]
            and unseen_s[j] < LEAP_S
            and state[j] != NOT_TRACKED
            and not closer_than(joints[j], before[j], LEAP_M)
        ):
            seen[j] = False
        unseen_s[j] = 0.0 if seen[j] else unseen_s[j] + interval_s
    for j in range(len(seen)):
        if seen[j] or state[j] != TRACKED or unseen_s[j] >= max(limit_s[j], WEAK_S * weak[j]):
            continue
        if closer_than(joints[j], before[j], HOLD_M):
            seen[j] = True
        elif twin[j] >= 0 and unseen_s[twin[j]] == 0.0:
            put(joints[j], joints[twin[j]] + CLOSING_RATIO * (before[j] - before[twin[j]]))
            seen[j] = True
    _reach(joints, before, scale, unseen_s, seen)


def wrap_angle(angle_rad: float) -> float:
    """The same angle from -pi to pi."""
    return math.remainder(angle_rad, math.tau)


@dataclass(slots=True)
class Person:
    """One person as a sensor remembers them; lengths are points: x, height, z [m].

    Attributes:
        name: identity, never given twice.
        place: (2,) x and z of the trunk.
        velocity: (2,) its rate [m/s].
        yaw_rad: heading relative to facing the sensor; NaN while it is not known.
        facing_rad: the yaw at the end of the last frame; NaN before the first.
        spin: its smoothed rate [rad/s].
        scale: stature over 1.75 m; 0 while it is not known.
        width: of the chest, over the scale [m].
        surface: (2,) from the place to the middle of the trunk's surface, steadied [m].
        frames: in how many frames the person was seen.
        missing_s: since when not.
        joints: (25, 3) last joints, NaN before the first.
        state: (25,) how they are known.
        carry: (25, 3) what is left of the way of joints that came back into sight.
        unseen_s: (25,) for how long joints have lacked support.
        patches: what is remembered of the trunk's surface, see `surface_tracking.nothing_known`.
        shown: (25,) what the last image says of the limbs, see `showing.shown`.
    """

    name: int
    place: Array
    velocity: Array = field(default_factory=lambda: np.zeros(2))
    yaw_rad: float = math.nan
    facing_rad: float = math.nan
    spin: float = 0.0
    scale: float = 0.0
    width: float = 0.0
    surface: Array = field(default_factory=lambda: np.full(2, np.nan))
    frames: int = 0
    missing_s: float = 0.0
    joints: Array = field(default_factory=lambda: np.full((len(JOINTS), 3), np.nan))
    state: NDArray[np.int8] = field(default_factory=lambda: np.zeros(len(JOINTS), np.int8))
    carry: Array = field(default_factory=lambda: np.zeros((len(JOINTS), 3)))
    unseen_s: Array = field(default_factory=lambda: np.zeros(len(JOINTS)))
    patches: Array = field(default_factory=surface_tracking.initial_patches)
    shown: NDArray[np.int8] = field(default_factory=lambda: np.zeros(len(JOINTS), np.int8))

    @property
    def confirmed(self) -> bool:
        """Whether this is a person, not a passing shape."""
        return self.frames >= CONFIRM_FRAMES

    def predict(self, interval_s: float) -> None:
        """Go on as before for a while."""
        step = self.velocity * interval_s
        self.place = self.place + step
        self.joints[:, 0] += step[0]
        self.joints[:, 2] += step[1]

    def update_size(self, crown_m: float, width_m: float, interval_s: float) -> None:
        """Take in how tall and how wide the person looks."""
        seen = min(max(crown_m / CROWN, STATURE_M[0]), STATURE_M[1]) / 1.75
        if self.scale == 0.0:
            self.scale, self.width = seen, width_m / seen
            return
        if seen > self.scale:
            self.scale += filter_gain(interval_s, RISE_S) * (seen - self.scale)
        elif seen > HIDDEN_SHARE * self.scale:
            self.scale += filter_gain(interval_s, SINK_S) * (seen - self.scale)

    def smooth_surface(self, middle: Array, interval_s: float) -> Array:
        """Where the forests are told that the trunk's surface (2,) is: a middle that shook would shake every joint."""
        off = middle - self.place
        if math.isnan(self.surface[0]):
            self.surface = off
        self.surface = self.surface + filter_gain(interval_s, SURFACE_S) * (off - self.surface)
        return np.asarray(self.place + self.surface)

    def update_yaw(self, votes: Array, interval_s: float) -> None:
        """Take in what the forest says of the yaw: sums of cosine and sine."""
        if votes[0] == votes[1] == 0.0:
            self.yaw_rad = 0.0 if math.isnan(self.yaw_rad) else self.yaw_rad
            return
        said = math.atan2(votes[1], votes[0])
        if math.isnan(self.yaw_rad):
            self.yaw_rad = said
        else:
            off = wrap_angle(said - self.yaw_rad)
            constant_s = YAW_ASTRAY_S if abs(off) > YAW_ASTRAY_RAD else YAW_S
            self.yaw_rad = wrap_angle(self.yaw_rad + filter_gain(interval_s, constant_s) * off)

    def coast(self, interval_s: float) -> None:
        """Out of sight: coast, and after a while admit it."""
        self.missing_s += interval_s
        self.velocity = self.velocity * (1.0 - filter_gain(interval_s, COAST_S))
        self.carry[:] = 0.0
        state = INFERRED if self.missing_s <= INFER_S else NOT_TRACKED
        self.state = np.where(np.isnan(self.joints[:, 0]), NOT_TRACKED, state).astype(np.int8)

    def bridge_dropouts(
        self, joints: Array, seen: posture_prior.JointMask, weak: posture_prior.JointMask, interval_s: float
    ) -> None:
        """Count joints as seen that lack support for a moment only, and hands that touch for longer; none that leaps.

        Hands that touch hide each other's surface, and neither goes far: one that is not found is beside the other.
        None meets the other beside a hip. What was here a moment ago and is found somewhere else altogether is not
        there, but hidden, and something else looks like it.

        Args:
            joints: (25, 3) where votes agree.
            seen: (25,) which of them are supported; changed in place.
            weak: (25,) for which of them there is a vote at all; changed in place.
            interval_s: since the last frame.
        """
        _hold(joints, self.joints, self.state, weak, self.yaw_rad, self.scale, interval_s, self.unseen_s, seen)

    def update(
        self,
        joints: Array,
        seen: posture_prior.JointMask,
        model: RuntimeModel,
        interval_s: float,
        believed: Array | None = None,
    ) -> None:
        """Take in a frame's joints.

        Args:
            joints: (25, 3) where votes agree, NaN where there are none.
            seen: (25,) which of them are supported.
            model: its regression and memory of postures count.
            interval_s: since the last frame.
            believed: (N, 2) how far each remembered posture counts for the hands, see `free_space.posture_likelihood`.
        """
        before_rad = self.facing_rad
        self._face(posture_prior.estimate_yaw(joints, seen), interval_s)
        self._spin(before_rad, interval_s)
        likely = np.empty_like(joints)
        known = model.posture, model.memory, model.mean
        counts = np.ones((len(model.memory), 2)) if believed is None else believed
        if not posture_prior.estimate_posture(
            joints, seen, *known, self.yaw_rad, self.scale, self.width, counts, likely
        ):
            self.coast(interval_s)
            return
        mine = self.joints, self.state, self.carry
        joint_filter.filter_joints(joints, seen, likely, self.yaw_rad, self.spin, interval_s, *mine)
        self._go(interval_s)

    def correct_depth(self, cells: Array, predicted: Array, voted: Array, least: float, interval_s: float) -> None:
        """Correct the frame's joints by the trunk's surface.

        Args:
            cells: (A, C, 2) from `surface_tracking.gathered`.
            predicted: (25, 3) joints that they were gathered for.
            voted: (25, 3) where votes agree; NaN where they do not count.
            least: points of a patch that must agree.
            interval_s: since the last frame.
        """
        learn_s = LEARN_S / (1.0 + (self.spin / LEARN_SPIN_RAD_S) ** 2)
        frontal = (abs(math.cos(self.yaw_rad)) - FRONTAL[0]) / (FRONTAL[1] - FRONTAL[0])
        counts = min(max(frontal, 0.0), 1.0)
        shares = np.array([filter_gain(interval_s, ANCHOR_S), filter_gain(interval_s, learn_s), counts])
        surface_tracking.correct_depth_from_surface(
            cells, self.patches, predicted, voted, least, shares, interval_s, self.joints
        )

    def _face(self, yaw_rad: float, interval_s: float) -> None:
        """Believe the skeleton's own heading, unless it contradicts the tracked one."""
        off = wrap_angle(yaw_rad - self.yaw_rad) if not math.isnan(yaw_rad) else math.inf
        if abs(off) < OWN_YAW_RAD:
            self.yaw_rad = wrap_angle(self.yaw_rad + filter_gain(interval_s, OWN_YAW_S) * off)

    def _spin(self, before_rad: float, interval_s: float) -> None:
        self.facing_rad = self.yaw_rad
        if interval_s > 0.0 and not math.isnan(before_rad):
            rate = wrap_angle(self.yaw_rad - before_rad) / interval_s
            self.spin += filter_gain(interval_s, SPIN_S) * (rate - self.spin)

    def _go(self, interval_s: float) -> None:
        place = 0.5 * (self.joints[_BASE, ::2] + self.joints[_MID, ::2])
        if self.frames and interval_s > 0.0:
            step = (place - self.place) / interval_s
            steadier = 1.0 + joint_filter.SIDEWAYS * math.sin(self.yaw_rad) ** 2
            self.velocity = self.velocity + filter_gain(interval_s, SPEED_S * steadier) * step
        self.place = place
        self.frames += 1
        self.missing_s = 0.0


def remove_duplicates(persons: list[Person]) -> list[Person]:
    """Those who remain where two stand in one place: the ones seen longer."""
    kept: list[Person] = []
    for person in sorted(persons, key=lambda one: -one.frames):
        doubles = (math.dist(person.place, other.place) < SAME_M for other in kept if other.missing_s == 0.0)
        if person.missing_s > 0.0 or not any(doubles):
            kept.append(person)
    return [person for person in persons if any(person is one for one in kept)]


def recover_lost(places: list[tuple[float, float]], persons: list[Person]) -> list[tuple[float, float]]:
    """Give places where strangers stand to persons out of sight; the places that are left are new persons'."""
    lost = [person for person in persons if person.missing_s > 0.0]
    left = list(places)
    pairs = sorted(
        (float(np.hypot(*(person.place - place))) - REACH_M_S * person.missing_s, index, row)
        for index, person in enumerate(lost)
        for row, place in enumerate(places)
    )
    taken: set[int] = set()
    for beyond_m, index, row in pairs:
        if beyond_m > REACH_M or index in taken or places[row] not in left:
            continue
        taken.add(index)
        left.remove(places[row])
        shift = np.array(places[row]) - lost[index].place
        lost[index].place = np.array(places[row])
        lost[index].joints[:, [0, 2]] += shift
    return left
