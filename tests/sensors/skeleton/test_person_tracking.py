"""Persons over time: coasting, recovery, size and yaw."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.core import INFERRED, NOT_TRACKED
from sjasim.sensors.skeleton import person_tracking
from sjasim.sensors.skeleton.person_tracking import Person, recover_lost, remove_duplicates

from .standing import DT_S, standing, track, tracked_person


def test_a_person_out_of_sight_coasts_is_inferred_and_then_not_tracked():
    person = tracked_person()
    for tick in range(1, 30):
        track(person, standing(0.5 * tick * DT_S, 3.0))
    x_m = float(person.position[0])

    for _ in range(15):
        person.predict(DT_S)
        person.coast(DT_S)
    assert person.position[0] == pytest.approx(x_m + 0.5 * 0.5 * 0.8, abs=0.06)
    assert (person.state == INFERRED).all()

    for _ in range(10):
        person.coast(DT_S)
    assert (person.state == NOT_TRACKED).all()


def test_a_lost_person_is_recovered_at_a_near_place_and_other_places_are_new():
    lost = tracked_person(0.0, 3.0)
    lost.lost_s = 0.2
    near = (0.3, 3.2)
    assert recover_lost([near, (2.0, 3.0)], [lost]) == [(2.0, 3.0)]
    assert lost.position == pytest.approx(near)

    in_sight = tracked_person(0.0, 3.0)
    assert recover_lost([near], [in_sight]) == [near]


def test_of_two_persons_in_one_place_the_one_seen_longer_remains():
    old = tracked_person(frames=9)
    new = tracked_person(0.1, 3.0, frames=3)
    other = tracked_person(1.0, 3.0)
    assert remove_duplicates([new, old, other]) == [old, other]


def test_an_occluded_crown_does_not_shrink_a_person():
    person = Person(0, np.zeros(2))
    person.update_size(1.70, 0.4, DT_S)
    scale = person.scale
    assert scale == pytest.approx(1.70 / person_tracking.CROWN / 1.75)

    for _ in range(300):
        person.update_size(1.20, 0.4, DT_S)
    assert person.scale == scale

    for _ in range(60):
        person.update_size(1.80, 0.4, DT_S)
    assert person.scale == pytest.approx(1.80 / person_tracking.CROWN / 1.75, rel=0.01)


def test_the_forest_corrects_a_wrong_yaw_quickly():
    person = Person(0, np.zeros(2), yaw_rad=0.0)
    votes = np.array([math.cos(3.0), math.sin(3.0), 90.0])
    for _ in range(15):
        person.update_yaw(votes, DT_S)
    assert abs(person_tracking.wrap_angle(person.yaw_rad - 3.0)) < 0.6


def test_without_votes_a_known_yaw_stays_and_an_unknown_one_becomes_zero():
    known = Person(0, np.zeros(2), yaw_rad=0.7)
    known.update_yaw(np.zeros(3), DT_S)
    assert known.yaw_rad == 0.7

    unknown = Person(1, np.zeros(2))
    unknown.update_yaw(np.zeros(3), DT_S)
    assert unknown.yaw_rad == 0.0
