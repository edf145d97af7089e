"""Dancers' names follow positions on the floor."""

import numpy as np
import pytest

from sjasim.core import PersonStatus
from sjasim.server.identity_assignment import IdentityAssigner

SLOTS = np.array([[0.0, 1.0], [1.0, 0.0], [-1.0, 0.0]])
NAMES = ("dancer_1", "dancer_2", "dancer_3")


@pytest.fixture
def identities():
    return IdentityAssigner(NAMES, SLOTS)


def persons_at(positions):
    """Status of persons from sensor's identity -> position [m]."""
    return [PersonStatus(person, x, y, 0.0, 1.0, 1.0) for person, (x, y) in positions.items()]


def names(identities, sensor, *persons):
    return [identities.name(sensor, person) for person in persons]


def test_at_the_start_everyone_is_known_by_their_slot_in_every_sensor(identities):
    identities.update("north", 0.2, persons_at({7: (0.98, 0.05), 3: (0.1, 0.9), 5: (-1.1, 0.1)}))
    identities.update("west", 0.2, persons_at({1: (-1.0, 0.0)}))
    assert names(identities, "north", 7, 3, 5) == ["dancer_2", "dancer_1", "dancer_3"]
    assert names(identities, "west", 1, 2) == ["dancer_3", None]


def test_names_follow_a_walk_to_another_dancers_slot(identities):
    for k in range(40):
        share = k / 39
        positions = {1: (0.0 + share, 1.0 - share), 2: (1.0 - share, -share), 3: (-1.0, 0.0)}
        identities.update("north" if k % 2 else "west", 0.1 * k, persons_at(positions))
    assert names(identities, "north", 1, 2, 3) == list(NAMES)


def test_a_lost_person_who_returns_is_recognised_by_position(identities):
    identities.update("north", 0.2, persons_at({0: (0.0, 1.0), 1: (1.0, 0.0), 2: (-1.0, 0.0)}))
    for k in range(5):
        identities.update("north", 0.4 + 0.2 * k, persons_at({0: (0.0, 1.0), 2: (-1.0, 0.0)}))
    # One of their events may still be under way.
    assert identities.name("north", 1) == "dancer_2"

    identities.update("north", 2.0, persons_at({0: (0.0, 1.0), 2: (-1.0, 0.0), 9: (1.4, 0.2)}))
    assert identities.name("north", 9) == "dancer_2"
    assert identities.name("north", 1) is None


def test_the_search_radius_grows_with_the_time_since_a_dancer_was_seen(identities):
    """A dancer who walks 1.2 m unseen in two seconds is recognised; after .2 s the same place is out of reach."""
    others = {0: (0.0, 1.0), 2: (-1.0, 0.0)}
    identities.update("north", 0.2, persons_at({**others, 1: (1.0, 0.0)}))

    identities.update("north", 0.4, persons_at({**others, 8: (1.0, -1.2)}))
    assert identities.name("north", 8) is None

    identities.update("north", 2.2, persons_at({**others, 9: (1.0, -1.2)}))
    assert identities.name("north", 9) == "dancer_2"


def test_swapped_identities_keep_their_names(identities):
    identities.update("north", 0.2, persons_at({0: (0.0, 1.0), 1: (1.0, 0.0), 2: (-1.0, 0.0)}))
    identities.update("north", 0.4, persons_at({1: (0.0, 1.0), 0: (1.0, 0.0), 2: (-1.0, 0.0)}))
    assert names(identities, "north", 1, 0, 2) == list(NAMES)


def test_a_person_beyond_every_dancers_reach_has_no_name(identities):
    identities.update("north", 0.2, persons_at({0: (0.0, 1.0), 1: (1.0, 0.0), 2: (-1.0, 0.0), 8: (2.5, 2.5)}))
    assert names(identities, "north", 0, 1, 2, 8) == [*NAMES, None]


def test_a_position_that_is_not_finite_loses_nobody(identities):
    identities.update("north", 0.2, persons_at({0: (0.0, 1.0), 1: (1.0, 0.0)}))
    identities.update("north", 0.4, persons_at({0: (float("nan"), 1.0), 1: (1.05, 0.0)}))
    identities.update("north", 0.6, persons_at({0: (0.0, 1.1), 1: (1.1, 0.0)}))
    assert names(identities, "north", 0, 1) == ["dancer_1", "dancer_2"]
