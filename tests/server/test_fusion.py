"""Fusion of the clients: the active sensor, the events that count, and that none is lost or counted twice."""

from itertools import pairwise

import pytest

from sjasim.assets.names import CARDINALS
from sjasim.core import Kind
from sjasim.core.clock import DeviceClock

SF, TF, SB, TB, CLAP, TURN = Kind


def test_an_event_gets_name_session_time_and_iteration(hall, world):
    at = world.timetable.time_s(1, 4.0)
    hall.run(at)
    hall.detect("north", at + 0.01, 2, TF)
    (event,) = hall.run(at + 0.2)
    assert (event.person, event.kind, event.iteration, event.sensor) == ("dancer_3", TF, 1, "north")
    assert event.t_s == pytest.approx(at + 0.01, abs=1e-4)
    assert event.t_arrival_s == pytest.approx(at + 0.03)
    assert hall.notices == []


def test_the_active_client_follows_the_turns(hall, world):
    hall.run(world.timetable.time_s(4, 32.0))
    assert [sensor for _, sensor in hall.actives] == ["east", "north", "west", "south", "east"]
    for (t_s, _), iteration in zip(hall.actives[1:], range(4), strict=True):
        assert world.timetable.time_s(iteration, 32.5) < t_s < world.timetable.time_s(iteration, 38.0)


def test_orders_name_active_and_next_and_are_repeated(hall, world):
    hall.run(world.timetable.start_s(2))
    before, overlap = world.timetable.time_s(1, 30.0), world.timetable.time_s(1, 35.0)

    def watching(t_s):
        latest = {order.sensor: order.watch for at, order in hall.orders if at <= t_s}
        return {sensor for sensor, watch in latest.items() if watch}

    assert watching(before) == {"north"}
    assert watching(overlap) == {"north", "west"}
    times = [at for at, order in hall.orders if order.sensor == "west"]
    assert max(b - a for a, b in pairwise(times)) <= 0.6


def test_the_handover_loses_nothing_and_doubles_nothing(hall, world):
    """Claps and late moves before the turn, early moves after it; in the overlap both clients report each."""
    table = world.timetable
    told = []
    for dancer in range(3):
        told += [
            ("north", table.time_s(1, 31.2) + 0.05 * dancer, dancer, TB),
            ("north", table.time_s(1, 32.0) + 0.1 * dancer, dancer, CLAP),
            ("west", table.time_s(1, 39.0) + 0.1 * dancer, dancer, SF),
            ("west", table.time_s(2, 4.0), dancer, TF),
        ]
    for sensor, t_s, dancer, kind in told:
        for client, late in ((sensor, 0.0), ("west" if sensor == "north" else "north", 0.03)):
            hall.detect(client, t_s + late, dancer, kind)
    events = hall.run(table.time_s(2, 8.0))
    assert sorted((e.person, e.kind) for e in events) == sorted((f"dancer_{d + 1}", k) for _, _, d, k in told)


def test_in_mid_turn_each_dancer_counts_where_they_face(hall, world):
    """Dancer 3 stays with the old sensor long after the others; each one's event counts once, whoever is active."""
    table = world.timetable
    late = table.time_s(1, 37.5)
    turning = hall.yaw
    hall.yaw = lambda t_s, dancer: turning(t_s - 1.5 if dancer == 2 else t_s, dancer)
    hall.detect("north", table.time_s(1, 33.0), 2, CLAP)
    hall.detect("north", table.time_s(1, 34.6), 2, CLAP, early=True)
    hall.detect("west", late, 0, SF)
    hall.detect("north", late + 0.02, 0, SF)
    events = hall.run(table.time_s(2, 4.0))
    assert [(e.person, e.kind, e.early) for e in events] == [
        ("dancer_3", CLAP, False),
        ("dancer_3", CLAP, True),
        ("dancer_1", SF, False),
    ]


def test_only_the_active_client_counts(hall, world):
    at = world.timetable.time_s(2, 8.0)
    for sensor in ("north", "south", "east"):
        hall.detect(sensor, at, 0, SB)
    assert hall.run(at + 1.0) == []


def test_early_and_regular_are_two_events_and_repetitions_are_one(hall, world):
    at = world.timetable.time_s(1, 0.0)
    for late, early in ((0.0, True), (0.1, False), (0.3, False), (1.0, False)):
        hall.detect("north", at + late, 0, SF, early)
    found = [(e.early, round(e.t_s - at, 2)) for e in hall.run(at + 2.0)]
    assert found == [(True, 0.0), (False, 0.1), (False, 1.0)]


def test_dancers_who_forget_to_turn_keep_their_client(hall, world):
    hall.yaw = lambda t_s, dancer: world.timetable.heading_rad(1)
    hall.run(world.timetable.time_s(2, 20.0))
    assert hall.server.active == "north"


def test_a_dead_client_is_noticed_and_replaced_and_comes_back(hall, world):
    table = world.timetable
    death = table.time_s(1, 8.0)
    hall.silent["north"] = death
    hall.run(death + 1.5)
    notices = [(n.source, n.what.split(":")[0]) for n in hall.notices]
    assert notices == [("north", "client is dead"), ("south", "client takes over from north")]
    assert death + 1.0 < hall.notices[0].t_s < death + 1.3
    assert ("south", True) in [(order.sensor, order.watch) for at, order in hall.orders if at > death]
    # it sees their backs: coming nearer is going backward
    hall.detect("south", death + 1.6, 0, SF)
    (event,) = hall.run(death + 2.0)
    assert event.kind == SB
    hall.silent.clear()
    hall.run(death + 3.0)
    assert hall.server.active == "north"
    assert hall.notices[-1].what == "client is back"


def test_a_dead_client_that_nobody_can_replace_stays_active(hall, world):
    death = world.timetable.time_s(1, 8.0)
    hall.hidden = lambda sensor, t_s: sensor != "north"
    hall.silent["north"] = death
    hall.run(death + 3.0)
    assert hall.server.active == "north"
    assert [n.source for n in hall.notices] == ["north"]


def test_a_clock_jump_is_noticed_and_costs_no_event(world):
    table = world.timetable
    jump = table.time_s(1, 3.9)
    hall = world.Hall({name: DeviceClock(0.1, 20e-6, jump, 2.5 if name == "north" else 0.0) for name in CARDINALS})
    for beat, kind in ((0.0, SF), (4.0, TF), (8.0, SB)):
        hall.detect("north", table.time_s(1, beat), 0, kind)
    events = hall.run(table.time_s(1, 12.0))
    assert [e.kind for e in events] == [SF, TF, SB]
    assert [e.t_s for e in events] == pytest.approx([table.time_s(1, b) for b in (0, 4, 8)], abs=0.02)
    (notice,) = hall.notices
    assert notice.source == "north"
    assert "clock jumped by +2.500 s" in notice.what


def test_an_event_of_an_unknown_person_is_noticed_once(hall, world):
    at = world.timetable.time_s(1, 0.0)
    hall.detect("north", at, 7, SF)
    hall.detect("north", at + 1.0, 7, TF)
    assert hall.run(at + 2.0) == []
    assert [n.what for n in hall.notices] == ["event of unknown person 7"]


def test_session_time_undoes_each_clients_clock(hall):
    hall.run(10.0)
    for sensor in CARDINALS:
        assert hall.server.session_time(sensor, hall.clocks[sensor].reading(9.5)) == pytest.approx(9.5, abs=1e-4)
