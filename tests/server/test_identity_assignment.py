"""Names follow places on the floor."""

import numpy as np

from sjasim.core import PersonStatus
from sjasim.server.identity_assignment import IdentityAssigner

SLOTS = np.array([[0.0, 1.0], [1.0, 0.0], [-1.0, 0.0]])
NAMES = ("dancer_1", "dancer_2", "dancer_3")


def seen(places):
    return [PersonStatus(person, x, y, 0.0, 1.0, 1.0) for person, (x, y) in places.items()]


def names(persons, sensor, *ids):
    return [persons.name(sensor, person) for person in ids]


def test_at_the_start_everyone_is_known_by_their_slot_in_every_sensor():
    persons = IdentityAssigner(NAMES, SLOTS)
    persons.update("north", 0.2, seen({7: (0.98, 0.05), 3: (0.1, 0.9), 5: (-1.1, 0.1)}))
    persons.update("west", 0.2, seen({1: (-1.0, 0.0)}))
    assert names(persons, "north", 7, 3, 5) == ["dancer_2", "dancer_1", "dancer_3"]
    assert names(persons, "west", 1, 2) == ["dancer_3", None]


def test_names_follow_a_walk_to_somebody_elses_slot():
    persons = IdentityAssigner(NAMES, SLOTS)
    for k in range(40):
        share = k / 39
        places = {1: (0.0 + share, 1.0 - share), 2: (1.0 - share, -share), 3: (-1.0, 0.0)}
        persons.update("north" if k % 2 else "west", 0.1 * k, seen(places))
    assert names(persons, "north", 1, 2, 3) == list(NAMES)


def test_a_lost_and_returned_identity_is_matched_by_place():
    persons = IdentityAssigner(NAMES, SLOTS)
    persons.update("north", 0.2, seen({0: (0.0, 1.0), 1: (1.0, 0.0), 2: (-1.0, 0.0)}))
    for k in range(5):
        persons.update("north", 0.4 + 0.2 * k, seen({0: (0.0, 1.0), 2: (-1.0, 0.0)}))
    assert persons.name("north", 1) == "dancer_2"  # an event of theirs may still be under way
    persons.update("north", 2.0, seen({0: (0.0, 1.0), 2: (-1.0, 0.0), 9: (1.4, 0.2)}))
    assert persons.name("north", 9) == "dancer_2"
    assert persons.name("north", 1) is None


def test_swapped_identities_keep_their_names():
    persons = IdentityAssigner(NAMES, SLOTS)
    persons.update("north", 0.2, seen({0: (0.0, 1.0), 1: (1.0, 0.0), 2: (-1.0, 0.0)}))
    persons.update("north", 0.4, seen({1: (0.0, 1.0), 0: (1.0, 0.0), 2: (-1.0, 0.0)}))
    assert names(persons, "north", 1, 0, 2) == list(NAMES)


def test_a_stranger_stays_nameless():
    persons = IdentityAssigner(NAMES, SLOTS)
    persons.update("north", 0.2, seen({0: (0.0, 1.0), 1: (1.0, 0.0), 2: (-1.0, 0.0), 8: (2.5, 2.5)}))
    assert names(persons, "north", 0, 1, 2, 8) == [*NAMES, None]


def test_a_place_that_is_not_finite_loses_nobody():
    persons = IdentityAssigner(NAMES, SLOTS)
    persons.update("north", 0.2, seen({0: (0.0, 1.0), 1: (1.0, 0.0)}))
    persons.update("north", 0.4, seen({0: (float("nan"), 1.0), 1: (1.05, 0.0)}))
    persons.update("north", 0.6, seen({0: (0.0, 1.1), 1: (1.1, 0.0)}))
    assert names(persons, "north", 0, 1) == ["dancer_1", "dancer_2"]
