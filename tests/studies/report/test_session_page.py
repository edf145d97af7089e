"""The page of a session: whom the robot followed, how late it was, and what is missing."""

from dataclasses import replace

import pytest

from sjasim.analysis.group_metrics import group_metrics
from sjasim.analysis.missing_events import missing_events
from sjasim.analysis.session_metrics import logged_events, measures
from sjasim.choreography.timetable import timetable
from sjasim.config.toml_file import from_plain
from sjasim.core import Kind
from sjasim.core.session_log import Notice
from sjasim.studies.report.folders import write_report
from sjasim.studies.report.session_events import iteration_events

from .html_page import read_page


def events_of(log):
    config = from_plain(log.config)
    table = timetable(config)
    rows = group_metrics(logged_events(log), config, table, log.followed)
    return iteration_events(log, config, table, rows, missing_events(log))


@pytest.fixture
def faulty_log(make_session_log):
    """A session of which one clap of dancer 2 was not logged, and a false event of dancer 1 was."""
    log = make_session_log("sia", iterations=2)
    lost = next(e for e in log.events if (e.person, e.kind, e.iteration) == ("dancer_2", Kind.CLAP, 2))
    first = next(e for e in log.events if (e.person, e.iteration) == ("dancer_1", 1))
    false = replace(first, t_s=first.t_s + 1.0)
    return replace(log, events=(*(e for e in log.events if e is not lost), false))


def test_every_logged_event_stands_in_its_iteration(make_session_log):
    log = make_session_log("sia", iterations=2)
    found = events_of(log)
    assert [item.iteration for item in found] == [0, 1, 2]
    assert [len(item.logged) for item in found] == [27, 36, 36]
    assert [item.followed for item in found] == ["", *(item.person for item in log.followed)]
    # In iteration 1 nobody is followed.
    assert [len(item.links) for item in found] == [0, 0, 9]


def test_a_lost_and_a_false_event_are_told_apart(faulty_log):
    found = events_of(faulty_log)
    assert [(event.agent, event.kind) for event in found[2].not_logged] == [("dancer_2", Kind.CLAP)]
    assert [(event.agent, event.kind) for event in found[1].false] == [("dancer_1", Kind.START_FORWARD)]
    assert len(found[1].logged) == 36


def test_the_figures_are_those_of_session_json(make_session_log, session_of):
    log = make_session_log("sia", iterations=2)
    summary = measures(log).as_dict()
    page = read_page(write_report(session_of(log)))
    rows = page.tables["The iterations"]
    followed = {item.iteration: item.person.replace("_", " ") or "nobody" for item in log.followed}
    for row, entry in zip(rows[1:], summary["iterations"], strict=False):
        assert row[:2] == [str(entry["index"]), followed[entry["index"]]]
        assert row[-4:] == [
            f"{entry['ta_mean_s']:.2f}",
            *(f"{entry[key]:.3f}" for key in ("gsi", "gsi_full_edges", "gsi_truth")),
        ]
        assert row[-5] == f"{entry['late_mean_s']:+.2f}".replace("-", "−") or row[-5] == f"{entry['late_mean_s']:.2f}"
    assert rows[-1][-4] == f"{summary['ta_mean_s']:.2f}"
    assert f"{summary['gsi_full_edges']:.2f} of 1" in page.text


def test_the_raster_says_what_is_missing(faulty_log, session_of):
    page = read_page(write_report(session_of(faulty_log)))
    described = {title: text for title, text, _ in page.drawings}["Events of all iterations"]
    assert "98 events are logged, 1 happened and are not logged" in described
    assert "Of the dancers' events 1 were not logged, and 1 logged ones did not happen" in page.text


def test_the_robot_is_late_in_words_and_in_the_chart(make_session_log, session_of):
    page = read_page(write_report(session_of(make_session_log("sia", iterations=1, spread_s=0.01))))
    assert "s later than the dancers' mean" in page.text
    shapes = {title: count for title, _, count in page.drawings}
    assert shapes["Lateness of the robot in every step"] >= 9


@pytest.mark.parametrize(("method", "words"), [("sia", "It followed dancer "), ("eca", "It followed everybody.")])
def test_the_verdict_says_whom_the_robot_followed(make_session_log, session_of, method, words):
    page = read_page(write_report(session_of(make_session_log(method, iterations=2))))
    assert words in page.text


def test_notices_are_listed_and_escaped(make_session_log, session_of):
    log = make_session_log("sia", iterations=1)
    notices = (Notice(1.0, "<b>west</b>", "no message & no sign <script>alert(1)</script>"),)
    folder = session_of(replace(log, notices=notices))
    page = read_page(write_report(folder))
    assert page.tables["Notices of the session"][1] == [
        "1.0",
        "<b>west</b>",
        "no message & no sign <script>alert(1)</script>",
    ]


def test_a_session_without_a_robot(make_session_log, session_of):
    page = read_page(write_report(session_of(make_session_log("none", iterations=1, robot=False))))
    assert "This session has no robot." in page.text
    assert "One session of the dancers alone" in page.text
    assert [title for title, _, _ in page.drawings] == ["Events of all iterations"]


def test_a_robot_that_never_moved(make_session_log, session_of):
    page = read_page(write_report(session_of(make_session_log("sia", iterations=2, robot=False))))
    assert "The robot never moved." in page.text
    assert "the robot left out 18 of 18 steps." in page.text
