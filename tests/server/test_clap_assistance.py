"""Claps that the active client cannot see: which clients are asked to help, and which of their claps count."""

import pytest

from sjasim.core import Kind
from sjasim.server.clap_assistance import UNSEEN_S, ClapAssistance

CAST = ("dancer_1", "dancer_2", "dancer_3")


@pytest.fixture
def behind(hall):
    """A hall where the north sensor sees no hands of dancer 3, who stands behind dancer 1."""
    hall.hands = lambda sensor, t_s, dancer: 0.5 if (sensor, dancer) == ("north", 2) else 1.0
    return hall


def assistants(hall, since_s=0.0):
    """Sensors that were asked to help, in the orders since a time."""
    return {order.sensor for t_s, order in hall.orders if order.assist and t_s >= since_s}


def test_a_clap_hidden_behind_another_dancer_counts_from_the_side(behind, world):
    at = world.timetable.time_s(1, 32.0)
    behind.detect("west", at, 2, Kind.CLAP)
    (event,) = behind.run(at + 0.2)
    assert (event.person, event.kind, event.sensor) == ("dancer_3", Kind.CLAP, "west")
    assert event.t_s == pytest.approx(at, abs=1e-3)


def test_no_clap_is_counted_twice_however_many_clients_report_it(behind, world):
    at = world.timetable.time_s(1, 32.0)
    for late, sensor in enumerate(("west", "north", "east", "west")):
        behind.detect(sensor, at + 0.2 * late, 2, Kind.CLAP)
    assert len(behind.run(at + 2.0)) == 1


def test_a_clap_of_visible_hands_counts_from_the_active_client_only(behind, world):
    at = world.timetable.time_s(1, 32.0)
    behind.detect("west", at, 0, Kind.CLAP)
    behind.detect("north", at + 0.1, 0, Kind.CLAP)
    assert [event.sensor for event in behind.run(at + 0.5)] == ["north"]


def test_nothing_but_claps_counts_from_the_side(behind, world):
    at = world.timetable.time_s(1, 32.0)
    behind.detect("west", at, 2, Kind.START_BACKWARD)
    assert behind.run(at + 0.5) == []


@pytest.mark.parametrize("beat", [16.0, 26.0])
def test_away_from_the_beat_no_clap_counts_from_the_side(behind, world, beat):
    at = world.timetable.time_s(1, beat)
    behind.detect("west", at, 2, Kind.CLAP)
    assert behind.run(at + 0.5) == []


def test_the_side_clients_are_asked_around_the_beat_only(behind, world):
    table = world.timetable
    behind.run(table.time_s(1, 27.5))
    begun = table.start_s(1)
    assert assistants(behind, begun) == set()
    behind.run(table.time_s(1, 32.0))
    assert assistants(behind, begun) == {"west", "east"}
    over = table.time_s(1, 36.5)
    behind.run(over + 2.0)
    assert assistants(behind, over) == set()


def test_no_client_is_asked_while_all_hands_are_visible(hall, world):
    hall.run(world.timetable.time_s(2, 4.0))
    assert assistants(hall) == set()


def test_a_clap_at_the_hand_over_is_neither_lost_nor_counted_twice(behind, world):
    """Late, with the active client already changing; the hall's next sensor, west, sees it from the side and then
    from the front."""
    at = world.timetable.time_s(1, 34.4)
    for late, sensor in ((0.0, "north"), (0.03, "west"), (0.07, "east")):
        behind.detect(sensor, at + late, 2, Kind.CLAP)
    behind.detect("west", at + 0.1, 1, Kind.CLAP)
    behind.detect("north", at + 0.1, 1, Kind.CLAP)
    assert sorted(event.person for event in behind.run(at + 2.0)) == ["dancer_2", "dancer_3"]


def test_without_assistance_the_active_client_counts_alone(world):
    assistance = ClapAssistance(CAST, world.timetable, 0.0)
    at = world.timetable.time_s(1, 32.0)
    assistance.update(at, [])
    assert not assistance.in_window(at)
    assert not assistance.accepts("dancer_1", at)


def test_hands_that_were_not_visible_a_moment_ago_still_count_as_unseen(world):
    assistance = ClapAssistance(CAST, world.timetable, 2.0)
    at = world.timetable.time_s(1, 32.0)
    assistance.update(at - 1.5, ["dancer_1", "dancer_2"])
    assistance.update(at - 0.5, ["dancer_1", "dancer_3"])
    assistance.update(at, CAST)
    assert assistance.unseen(at) == ["dancer_2"]
    assert assistance.unseen(at - 0.5 + UNSEEN_S + 0.01) == []
