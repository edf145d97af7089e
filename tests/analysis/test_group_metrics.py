"""Measures of single iterations: whom the robot followed, and latencies behind that dancer."""

import dataclasses

import pytest

from sjasim.analysis.group_metrics import group_metrics, net_latencies
from sjasim.analysis.session_metrics import logged_events
from sjasim.choreography.timetable import timetable
from sjasim.config.toml_file import from_plain
from sjasim.core import Kind
from sjasim.core.session_log import Followed

from ..synthetic_log import CLOCK_ERROR_S, ROBOT_LAG_S


@pytest.fixture(scope="module")
def log(make_session_log):
    return make_session_log(method="sia", iterations=2, spread_s=0.0, joints=False)


def measure(log, **changes):
    """Rows of a log with changes, and its timetable."""
    changed = dataclasses.replace(log, **changes)
    config = from_plain(changed.config)
    table = timetable(config)
    return group_metrics(logged_events(changed), config, table, changed.followed), table


@pytest.mark.parametrize(
    ("persons", "followed"),
    [
        ((), ""),
        (("",), ""),
        (("dancer_2",), "dancer_2"),
        (("dancer_2", "dancer_3"), ""),
    ],
)
def test_a_dancer_is_followed_only_if_it_is_the_only_one(log, persons, followed):
    rows, _ = measure(log, followed=tuple(Followed(2, person) for person in persons))
    assert [row.follows for row in rows] == ["", followed]


def test_a_method_without_rows_of_followed_dancers_follows_everyone_and_no_robot_follows_nobody(log):
    rows, _ = measure(log, followed=())
    assert {row.followed for row in rows} == {("dancer_1", "dancer_2", "dancer_3")}
    rows, _ = measure(log, config={**log.config, "method": "none"})
    assert {row.followed for row in rows} == {()}


def test_lateness_is_signed_and_timing_appropriateness_is_not(make_session_log):
    log = make_session_log(method="eca", iterations=1, spread_s=0.0, late_s=(-0.6, 0.0, 0.0), joints=False)
    (row,), _ = measure(log)
    # The robot answers the first dancer, who is .4 s ahead of the mean.
    assert row.late_s == pytest.approx(ROBOT_LAG_S - CLOCK_ERROR_S - 0.4)
    assert row.ta_s == pytest.approx(0.4 - ROBOT_LAG_S + CLOCK_ERROR_S)


def test_net_latency_is_measured_where_the_dancers_event_triggered_the_step(log):
    rows, table = measure(log)
    latencies = net_latencies(rows, table, log.decisions)
    assert {kind: len(values) for kind, values in latencies.items()} == {
        "start_forward": 2, "stop_forward": 2, "start_backward": 2, "stop_backward": 2, "clap": 1
    }  # fmt: skip
    for values in latencies.values():
        assert values == pytest.approx(ROBOT_LAG_S - CLOCK_ERROR_S)


def test_a_turn_by_schedule_has_no_net_latency_although_the_robot_follows_a_dancer(log):
    """The followed dancer's clap is far from the scheduled turn, and has nothing to do with it."""
    decisions = [
        dataclasses.replace(item, person="", why="fallback") if item.kind is Kind.CLAP else item
        for item in log.decisions
    ]
    rows, table = measure(log)
    assert rows[-1].follows == "dancer_1"
    assert set(net_latencies(rows, table, decisions)) == {kind for kind in Kind if kind not in (Kind.CLAP, Kind.TURN)}


def test_decisions_that_were_not_sent_and_people_who_are_unknown_have_no_net_latency(log):
    rows, table = measure(log)
    for change in ({"action": "scheduled"}, {"person": "stranger"}):
        decisions = [dataclasses.replace(item, **change) for item in log.decisions]
        assert net_latencies(rows, table, decisions) == {}


def test_the_paper_s_edges_depend_on_the_followed_dancers_and_full_edges_do_not(log):
    indices = {}
    for count in range(4):
        persons = [f"dancer_{k + 1}" for k in range(count)] or [""]
        rows, _ = measure(log, followed=tuple(Followed(i, person) for i in (1, 2) for person in persons))
        indices[count] = rows[0].gsi
        assert rows[0].gsi_full_edges == pytest.approx(1.0)

    # All pairs are synchronous: the robot contributes its share of outgoing edges, 0 to 3 of 3.
    assert indices == pytest.approx({count: (9 + count) / 12 for count in range(4)})
