"""The page of a session: whom the robot followed, how late it was, and what is missing."""

from dataclasses import replace

import numpy as np
import pytest

from sjasim.analysis.session_metrics import measures
from sjasim.choreography.timetable import timetable
from sjasim.config.toml_file import from_plain
from sjasim.core import Kind
from sjasim.core.session_log import Notice
from sjasim.studies.report.folders import write_report
from sjasim.studies.report.step_events import (
    LOGGED,
    NOT_LOGGED,
    NOT_PERFORMED,
    count_missing,
    iteration_events,
)

from .html_page import read_page


def events_of(log):
    config = from_plain(log.config)
    return iteration_events(log, config, timetable(config))


@pytest.fixture
def faulty_log(make_session_log):
    """A session in which one event of dancer 2 was not logged, one was not danced, and the robot missed a step."""
    log = make_session_log("sia", iterations=2)
    lost = next(e for e in log.events if (e.person, e.kind, e.iteration) == ("dancer_2", Kind.CLAP, 2))
    not_danced = [c for c in log.cues if (c.dancer, c.iteration, c.ordinal) == ("dancer_3", 1, 0)]
    absent = [e for e in log.events if (e.person, e.iteration) == ("dancer_3", 1)][:2]
    missed = next(e for e in log.robot_events if (e.iteration, e.kind) == (2, Kind.TURN))
    return replace(
        log,
        events=tuple(e for e in log.events if e is not lost and e not in absent),
        cues=tuple(c for c in log.cues if c not in not_danced),
        robot_events=tuple(e for e in log.robot_events if e is not missed),
    )


def test_every_step_of_every_iteration_has_a_status(make_session_log):
    found = events_of(make_session_log("sia", iterations=2))
    assert [item.iteration for item in found] == [0, 1, 2]
    assert [len(item.steps) for item in found] == [27, 36, 36]
    assert {step.status for item in found for step in item.steps} == {LOGGED}


def test_an_event_that_was_not_logged_is_no_step_that_was_not_performed(faulty_log):
    found = events_of(faulty_log)
    dancers = count_missing(found, False)
    assert (dancers[NOT_LOGGED], dancers[NOT_PERFORMED]) == (1, 2)
    assert count_missing(found, True)[NOT_PERFORMED] == 1
    lost = [step for item in found for step in item.steps if step.status == NOT_LOGGED]
    assert [(step.agent, step.kind) for step in lost] == [("dancer_2", Kind.CLAP)]

    # The clap was performed at a known time; the robot's turn was due at the dancers' mean.
    config = from_plain(faulty_log.config)
    start_s = timetable(config).start_s(2)
    clap = next(c for c in faulty_log.cues if (c.dancer, c.iteration, c.move) == ("dancer_2", 2, "clap"))
    assert lost[0].t_s == pytest.approx(clap.t_s - start_s)
    turn = next(step for step in found[2].steps if step.agent == "robot" and step.status == NOT_PERFORMED)
    claps = [e.t_s - start_s for e in faulty_log.events if (e.kind, e.iteration) == (Kind.CLAP, 2)]
    assert turn.t_s == pytest.approx(np.mean(claps))


def test_an_event_without_a_step_is_kept(make_session_log):
    log = make_session_log("sia", iterations=1)
    first = next(e for e in log.events if e.iteration == 1 and e.kind == Kind.START_FORWARD)
    twice = replace(first, t_s=first.t_s + 0.3)
    found = events_of(replace(log, events=(*log.events, twice)))
    assert [(event.agent, event.kind) for event in found[1].extra] == [(first.person, Kind.START_FORWARD)]


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


def test_the_raster_has_a_marker_for_every_step_and_says_what_is_missing(faulty_log, session_of):
    page = read_page(write_report(session_of(faulty_log)))
    described = {title: text for title, text, _ in page.drawings}["Events of all iterations"]
    assert "95 of 99 steps have a logged event; 4 are marked as missing." in described
    assert "Of 81 steps of the dancers 1 were performed but not logged; the robot missed 1 of 18." in page.text


def test_the_robot_is_late_in_words_and_in_the_chart(make_session_log, session_of):
    page = read_page(write_report(session_of(make_session_log("sia", iterations=1, spread_s=0.01))))
    assert "s later than the dancers' mean" in page.text
    shapes = {title: count for title, _, count in page.drawings}
    assert shapes["Lateness of the robot in every step"] >= 9


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
