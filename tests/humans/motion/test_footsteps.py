"""Tests of footsteps, weight shift and zero-moment point."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from sjasim.humans.body.anatomy import Build
from sjasim.humans.body.proportions import scaled_anatomy
from sjasim.humans.motion.footsteps import (
    SHIFT_S,
    FootTrajectories,
    pelvis_height,
    plan_turn,
    plan_walk,
    smoothing_kernel,
)
from sjasim.humans.motion.reference_trajectory import ReferenceTrajectory
from sjasim.humans.motion.speed_profile import minimum_jerk, speed_profile

DT = 1 / 60
BODY = scaled_anatomy(Build())


def feet(seconds: float = 14.0, heading: float = np.pi / 2):
    ticks = round(seconds / DT)
    reference = ReferenceTrajectory.empty(1, ticks).for_dancer(0)
    reference.planned_rows[:] = ticks
    return FootTrajectories(np.zeros(2), heading, BODY.hip_m, BODY.ankle_m, np.arange(ticks) * DT, reference)


def moves(durations, hold_s: float):
    """Walks one after another, with the same hold between them, starting at 2 s."""
    t = 2.0
    last = 1
    free = 0.0
    out = []
    for duration in durations:
        plan = plan_walk(speed_profile(0.5, duration), t, last, free)
        out.append(plan)
        last, free = plan.steps[-1].side, plan.steps[-1].land_s
        t += duration + hold_s
    return out


@pytest.mark.parametrize("hold", [0.15, 0.3, 2.0])
@pytest.mark.parametrize("duration", [0.8, 1.1, 2.0, 3.0])
def test_steps_alternate_and_never_overlap(duration, hold):
    steps = [step for plan in moves([duration] * 3, hold) for step in plan.steps]
    for before, after in pairwise(steps):
        assert after.side == 1 - before.side
        assert before.lift_s < before.land_s <= after.lift_s
    assert all(0.15 < step.land_s - step.lift_s < 0.6 for step in steps)


@pytest.mark.parametrize("duration", [0.8, 2.0, 3.0])
def test_both_last_steps_end_at_the_whole_distance(duration):
    profile = speed_profile(0.5, duration)
    plan = plan_walk(profile, 2.0, 1, 0.0)
    assert [step.along for step in plan.steps[-2:]] == pytest.approx([profile.distance_m] * 2)
    places = [step.along for step in plan.steps]
    assert places == sorted(places)


def test_feet_end_beside_each_other():
    ground = feet()
    for step in plan_walk(speed_profile(0.5, 2.0), 2.0, 1, 0.0).steps:
        ground.swing(step, np.array([0.0, step.along]), np.pi / 2)
    gap = ground.ankles[-1, 0] - ground.ankles[-1, 1]
    assert gap == pytest.approx([-2 * BODY.hip_m, 0.0, 0.0], abs=1e-12)


def test_a_turn_brings_both_feet_to_the_new_heading():
    ground = feet(heading=0.0)
    steps = plan_turn(2.0, 1.8, 0.0)
    assert [step.side for step in steps] == [0, 1, 0, 1]
    for step in steps:
        ground.swing(step, np.zeros(2), np.pi / 2 * step.along)
    assert ground.yaw[-1] == pytest.approx([np.pi / 2] * 2)
    assert ground.ankles[-1, 0, :2] == pytest.approx([-BODY.hip_m, 0.0], abs=1e-12)
    assert not (ground.landing > 0).all(axis=1).any()


def test_a_turn_waits_for_the_step_before_it():
    steps = plan_turn(2.0, 1.8, 2.12)
    assert steps[0].lift_s > 2.12
    assert steps[-1].land_s < 3.8


@pytest.mark.parametrize("hold", [0.15, 1.0])
def test_weight_is_on_the_standing_foot(hold):
    ground = feet()
    plans = moves([0.8, 2.0, 1.2], hold)
    for plan in plans:
        for step in plan.steps:
            ground.swing(step, np.array([0.0, step.along]), np.pi / 2)

    weight = ground.weight(slice(0, len(ground.landing)))
    assert weight.min() >= 0.0
    assert weight.max() <= 1.0

    times = np.arange(len(weight)) * DT
    for step in (step for plan in plans for step in plan.steps):
        inside = (times > step.lift_s + SHIFT_S / 2 + DT) & (times < step.land_s - SHIFT_S / 2 - DT)
        assert inside.any()
        assert weight[inside] == pytest.approx(float(step.side), abs=1e-9)


def test_the_zero_moment_point_stays_inside_the_feet():
    ground = feet()
    for plan in moves([0.8, 2.0, 1.2], 0.15):
        for step in plan.steps:
            ground.swing(step, np.array([0.0, step.along]), np.pi / 2)
    span = slice(0, len(ground.landing))
    weight = ground.weight(span)
    ahead = 0.026 * BODY.build.stature_m
    zmp = ground.zero_moment_point(span, weight, ahead)
    soles = ground.ankles[:, :, :2] + [0.0, ahead]
    lines = weight[:, None] * soles[:, 0] + (1 - weight[:, None]) * soles[:, 1]
    assert zmp == pytest.approx(lines)

    alone = (weight < 1e-6) | (weight > 1 - 1e-6)
    under = np.where(weight[:, None] > 0.5, ground.ankles[:, 0, :2], ground.ankles[:, 1, :2])
    along = (zmp - under)[alone, 1]
    assert (along > -BODY.sole_m[0]).all()
    assert (along < BODY.sole_m[1]).all()
    assert np.abs((zmp - under)[alone, 0]).max() < 0.017 * BODY.build.stature_m


def test_swinging_feet_lift_and_land_softly():
    ground = feet()
    step = plan_walk(speed_profile(0.5, 2.0), 2.0, 1, 0.0).steps[0]
    ground.swing(step, np.array([0.0, step.along]), np.pi / 2)
    height = ground.ankles[:, step.side, 2] - BODY.ankle_m
    assert height.max() == pytest.approx(0.05, abs=0.003)
    assert np.abs(np.diff(ground.ankles[:, step.side], axis=0)).max() / DT < 2.0
    assert (height >= 0).all()


def test_the_pelvis_goes_down_where_a_leg_would_not_reach():
    ticks = 120
    pelvis = np.zeros((ticks, 3))
    ankles = np.zeros((ticks, 2, 3))
    ankles[:, :, 1] = [BODY.hip_m, -BODY.hip_m]
    ankles[:, :, 2] = BODY.ankle_m
    ankles[:, 0, 0] = 0.4 * minimum_jerk(np.linspace(-1, 2, ticks))
    height = pelvis_height(
        pelvis, np.zeros(ticks), ankles, BODY.chains().leg, BODY.standing_m, smoothing_kernel(0.12, DT)
    )
    assert height[0] == pytest.approx(BODY.standing_m)
    assert height[-1] < BODY.standing_m - 0.02
    assert np.abs(np.diff(height)).max() < 0.008
