"""Tests of the motion planner: pendulum, footsteps, postures, and rows before the present, which never change."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import ACTUATED_INDEX, JOINT_INDEX
from sjasim.core import Cue, Move
from sjasim.core.errors import ConfigError
from sjasim.humans.body.anatomy import Build
from sjasim.humans.body.kinematics import joint_positions
from sjasim.humans.body.proportions import scaled_anatomy
from sjasim.humans.motion.pendulum import bounded_com
from sjasim.humans.motion.planner import PREVIEW_S, Planner
from sjasim.humans.motion.reference_trajectory import ReferenceTrajectory

from ..dancing import HZ, NORTH, at_rest, builds, walk_cue

FIELDS = ("joints", "pelvis", "yaw", "dcm", "weight", "ankles", "foot_yaw", "landing", "torque")


class Plan:
    """A planner and the trajectory that it writes."""

    def __init__(self, body=None, seconds: float = 22.0) -> None:
        self.body = body or scaled_anatomy(Build())
        self._reference = ReferenceTrajectory.empty(1, round(seconds * HZ)).for_dancer(0)
        self.planner = Planner(self.body, np.zeros(2), NORTH, 0.5, NORTH, HZ, self._reference)

    @property
    def reference(self) -> ReferenceTrajectory:
        """The trajectory, at rest in every row that is not planned."""
        return at_rest(self._reference)

    def copy(self) -> dict[str, np.ndarray]:
        return {name: getattr(self.reference, name).copy() for name in FIELDS}


def phrase(start_s: float = 2.0, move_s: float = 2.0, hold_s: float = 0.8) -> list[Cue]:
    """Forward, backward, clap, turn."""
    back = start_s + move_s + hold_s
    clap = back + move_s + hold_s + 0.5
    return [
        walk_cue(Move.FORWARD, start_s, move_s),
        walk_cue(Move.BACKWARD, back, move_s),
        walk_cue(Move.CLAP, clap, 0.0),
        walk_cue(Move.TURN, clap + 0.25, 1.8),
    ]


def test_the_pendulum_obeys_its_equation():
    """Second differences of the centre of mass equal omega^2 (x - p), an equation that the solver does not use."""
    rate, omega = 2000.0, 3.2
    t = np.arange(0, 10, 1 / rate)
    inside = (t > 2) & (t < 8)
    zmp = np.stack([0.1 * np.sin(2 * t), 0.05 * np.cos(5 * t) * np.exp(-((t - 5) ** 2))], axis=1)
    com = bounded_com(zmp, omega / rate, zmp[0])
    acceleration = np.gradient(np.gradient(com, 1 / rate, axis=0), 1 / rate, axis=0)
    assert np.abs(acceleration - omega**2 * (com - zmp))[inside].max() < 2e-3


def test_the_pendulum_is_bounded_by_its_support():
    rng = np.random.default_rng(0)
    zmp = np.repeat(rng.uniform(-0.1, 0.1, (60, 2)), 30, axis=0)
    com = bounded_com(zmp, 3.2 / HZ, zmp[0])
    assert (com.max(axis=0) <= zmp.max(axis=0) + 1e-12).all()
    assert (com.min(axis=0) >= zmp.min(axis=0) - 1e-12).all()
    assert com[-1] == pytest.approx(zmp[-1], abs=0.1)


def test_a_dancer_without_cues_stands_over_its_feet():
    plan = Plan()
    r = plan.reference
    assert np.ptp(r.pelvis, axis=0).max() < 1e-9
    assert r.weight == pytest.approx(0.5)
    assert r.dcm[0] == pytest.approx([0.0, 0.026 * 1.75], abs=2e-3)


@pytest.mark.parametrize("duration", [0.8, 2.0, 3.0])
@pytest.mark.parametrize("move", [Move.FORWARD, Move.BACKWARD])
def test_the_planned_pelvis_ends_where_its_feet_end(duration, move):
    plan = Plan()
    plan.planner.extend([walk_cue(Move.FORWARD, 2.0, 2.0)], 0.0)
    if move is Move.BACKWARD:
        plan.planner.extend([walk_cue(move, 6.0, duration)], 4.0)
    r = plan.reference
    middle = r.ankles[-1, :, :2].mean(axis=0)
    before = r.pelvis[-1, 1] - middle[1]
    assert before == pytest.approx(r.pelvis[0, 1] - r.ankles[0, :, 1].mean(), abs=5e-3)
    assert np.abs(np.diff(r.pelvis, axis=0)).max() * HZ < 0.7


def test_a_phrase_ends_on_the_slot():
    plan = Plan()
    plan.planner.extend(phrase(), 0.0)
    assert np.linalg.norm(plan.reference.ankles[-1, :, :2].mean(axis=0)) < 0.12


def test_a_dancer_beside_the_slot_returns_during_moves_without_losing_time():
    """After a long move and a turn the dancer stands beside the slot; two moves lead back as fast as straight ones."""
    plan = Plan(seconds=24.0)
    plan.planner.extend([walk_cue(Move.FORWARD, 2.0, 3.5), walk_cue(Move.TURN, 7.0, 1.8)], 0.0)
    off_m = plan.reference.pelvis[round(11.0 * HZ), 1]
    assert off_m > 0.7

    plan.planner.extend([walk_cue(Move.FORWARD, 12.0, 2.0), walk_cue(Move.BACKWARD, 17.0, 2.0)], 0.0)
    assert plan.reference.pelvis[-1, 1] < off_m - 0.15

    straight = Plan(seconds=24.0)
    straight.planner.extend([walk_cue(Move.FORWARD, 12.0, 2.0)], 0.0)
    walk = slice(round(12.5 * HZ), round(13.5 * HZ))
    ahead = -np.diff(plan.reference.pelvis[walk, 0])  # the turn leads from north to west
    assert ahead == pytest.approx(np.diff(straight.reference.pelvis[walk, 1]), rel=0.1, abs=1e-4)


def test_planned_legs_reach_their_planned_ankles():
    plan = Plan(builds(1, 3)[0])
    plan.planner.extend(phrase(), 0.0)
    r, chains = plan.reference, plan.body.chains()
    ankles = [JOINT_INDEX["AnkleLeft"], JOINT_INDEX["AnkleRight"]]
    for t in range(0, len(r.yaw), 7):
        places = joint_positions(chains, r.joints[t], r.pelvis[t], r.yaw[t])[ankles]
        assert np.abs(places - r.ankles[t]).max() < 0.012


@pytest.mark.parametrize("late", [PREVIEW_S, 0.6])
def test_rows_before_the_present_do_not_change(late):
    plan = Plan()
    cues = phrase()
    plan.planner.extend(cues[:1], 0.0)
    before = plan.copy()
    now = cues[1].t_s - late
    plan.planner.extend(cues[1:], now)
    past = slice(0, int(now * HZ))
    for name in FIELDS:
        assert np.array_equal(getattr(plan.reference, name)[past], before[name][past]), name
    assert not np.array_equal(plan.reference.joints, before["joints"])


def test_planning_in_parts_equals_planning_at_once():
    parts, whole = Plan(), Plan()
    whole.planner.extend(phrase(), 0.0)
    for cue in phrase():
        parts.planner.extend([cue], max(0.0, cue.t_s - PREVIEW_S))
    assert np.abs(parts.reference.pelvis - whole.reference.pelvis).max() < 0.025
    assert np.array_equal(parts.reference.ankles, whole.reference.ankles)


@pytest.mark.parametrize(
    ("cues", "field", "allowed"),
    [
        ([(Move.FORWARD, 2.0, 2.0), (Move.BACKWARD, 3.0, 2.0)], "t_s", "4.000 s or later"),
        ([(Move.FORWARD, 0.5, 2.0)], "t_s", "1.000 s or later"),
        ([(Move.FORWARD, float("nan"), 2.0)], "t_s", "1.000 s or later"),
        ([(Move.FORWARD, 2.0, 0.3)], "duration_s", "0.5 s or longer"),
        ([(Move.BACKWARD, 2.0, -1.0)], "duration_s", "0.5 s or longer"),
        ([(Move.TURN, 2.0, 0.5)], "duration_s", "1 s or longer"),
    ],
)
def test_impossible_cues_are_refused(cues, field, allowed):
    plan = Plan()
    with pytest.raises(ConfigError, match=allowed) as caught:
        plan.planner.extend([walk_cue(*cue) for cue in cues], 1.0)
    assert caught.value.field.endswith(f"cue.{field}")


def test_steps_of_a_late_cue_wait_for_the_present():
    plan = Plan()
    before = plan.copy()
    plan.planner.extend([walk_cue(Move.FORWARD, 3.0, 2.0)], 2.95)
    past = slice(0, int(2.95 * HZ))
    for name in FIELDS:
        assert np.array_equal(getattr(plan.reference, name)[past], before[name][past]), name


def test_a_turn_ends_at_the_new_heading():
    plan = Plan()
    plan.planner.extend(phrase(), 0.0)
    assert plan.reference.yaw[-1] == pytest.approx(np.pi)
    assert plan.reference.foot_yaw[-1] == pytest.approx([np.pi, np.pi])


def test_arms_swing_against_the_legs():
    plan = Plan()
    plan.planner.extend(phrase()[:1], 0.0)
    r = plan.reference
    left, right = (r.joints[:, ACTUATED_INDEX[f"shoulder_y_{side}"]] for side in "LR")
    assert np.ptp(left) > 0.3
    walking = slice(int(2.2 * HZ), int(3.8 * HZ))
    legs = r.ankles[walking, 0, 1] - r.ankles[walking, 1, 1]
    assert np.corrcoef(left[walking] - right[walking], legs)[0, 1] > 0.3


@pytest.mark.parametrize("build", [Build(1.5, 50), Build(), Build(1.95, 100)], ids=str)
def test_hands_meet_at_the_clap(build):
    plan = Plan(scaled_anatomy(build))
    plan.planner.extend([walk_cue(Move.CLAP, 2.0, 0.0)], 0.0)
    r, chains = plan.reference, plan.body.chains()
    hands = [JOINT_INDEX["HandLeft"], JOINT_INDEX["HandRight"]]
    rows = range(round(1.2 * HZ), round(2.1 * HZ))
    gaps = []
    for t in rows:
        places = joint_positions(chains, r.joints[t], r.pelvis[t], r.yaw[t])[hands]
        gaps.append(np.linalg.norm(places[0] - places[1]))
    touch = next(t for t, gap in zip(rows, gaps, strict=True) if gap < 2 * plan.body.hand_half_m) / HZ
    assert touch == pytest.approx(2.0, abs=0.035)
