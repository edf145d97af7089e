"""Tests of whole dances in physics: no falls, motion as planned, and little force of the balance support."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from sjasim.core import Kind, Move

from ..dancing import HZ, Floor, builds, paper_floor, walk_cue


@cache
def performed():
    """One iteration by three dancers of random build."""
    return paper_floor(builds(3, 11), seed=11).run()


def test_no_dancer_falls():
    assert not performed().fell


def test_the_pelvis_follows_its_plan():
    errors = performed().pelvis_errors()
    assert errors.mean(axis=0).max() <= 0.025
    assert errors.max() <= 0.10


def test_balance_support_needs_little_force():
    force = performed().support_n()
    assert np.sqrt((force**2).mean(axis=0)).max() <= 20.0


def test_feet_carry_the_weight():
    floor = performed()
    share = floor.column("loads").mean(axis=0) / floor.physics.servos.weight
    assert share.min() >= 0.99


@pytest.mark.parametrize("dancer", range(3))
def test_moves_start_and_stop_when_planned(dancer):
    errors = [error for kind, error, _ in performed().event_errors(dancer) if kind is not Kind.CLAP]
    assert len(errors) == 8
    assert np.abs(errors).max() <= 0.033
    assert abs(np.mean(errors)) <= 0.010


def test_hands_meet_within_a_frame_of_the_planned_clap():
    errors = [error for dancer in range(3) for kind, error, _ in performed().event_errors(dancer) if kind is Kind.CLAP]
    assert len(errors) == 3
    assert np.abs(errors).max() <= 0.020


def test_the_same_dance_twice_gives_equal_states():
    first, second = (paper_floor(builds(2, 5), seed=5).run(4.0) for _ in range(2))
    assert np.array_equal(first.column("roots"), second.column("roots"))


@pytest.mark.parametrize("walking", [False, True], ids=["standing", "walking"])
def test_no_dancer_falls_after_a_sideways_push(walking):
    slots = np.array([[0.0, 0.0], [2.5, 0.0], [-2.5, 0.0]])
    floor = Floor(builds(3, 21), 5.5, slots=slots)
    for dancer in range(3 * walking):
        cues = [walk_cue(Move.FORWARD, 1.5, 1.5, dancer), walk_cue(Move.BACKWARD, 3.2, 1.5, dancer)]
        floor.plan(dancer, cues, 0.0)
    floor.run(1.8)
    for dancer in range(3):
        floor.physics.push(dancer, np.array([100.0 * (-1) ** dancer, 0.0, 0.0]))
        floor.run(0.2)
        floor.physics.push(dancer, np.zeros(3))
        floor.run(0.15)
    assert not floor.run(5.5 - floor.tick / HZ).fell
