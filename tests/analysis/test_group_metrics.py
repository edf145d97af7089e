"""Measures of single iterations: whom the robot followed, and latencies behind that dancer."""

import dataclasses

import pytest

from sjasim.analysis.group_metrics import group_metrics, net_latencies
from sjasim.analysis.session_metrics import logged_events
from sjasim.choreography.timetable import timetable
from sjasim.config.toml_file import from_plain
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
    rows, table = measure(log, followed=tuple(Followed(2, person) for person in persons))
    assert [row.follows for row in rows] == ["", followed]

    latencies = net_latencies(rows, table)
    assert sum(map(len, latencies.values())) == (9 if followed else 0)
    for values in latencies.values():
        assert values == pytest.approx(ROBOT_LAG_S - CLOCK_ERROR_S)


def test_the_paper_s_edges_depend_on_the_followed_dancers_and_full_edges_do_not(log):
    indices = {}
    for count in range(4):
        persons = [f"dancer_{k + 1}" for k in range(count)] or [""]
        rows, _ = measure(log, followed=tuple(Followed(i, person) for i in (1, 2) for person in persons))
        indices[count] = rows[0].gsi
        assert rows[0].gsi_full_edges == pytest.approx(1.0)

    # All pairs are synchronous: the robot contributes its share of outgoing edges, 0 to 3 of 3.
    assert indices == pytest.approx({count: (9 + count) / 12 for count in range(4)})
