"""Rows of a study's tables for one session, against the measures of session.json."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.analysis.session_metrics import measures
from sjasim.analysis.study_tables import EVENTS, ITERATIONS, SESSIONS, STEPS
from sjasim.config import SessionConfig
from sjasim.session.session import Session
from sjasim.studies.session_rows import session_rows


def finished(method: str) -> Session:
    session = Session(SessionConfig(method=method, fidelity="timing", sensing="joints", seed=8))
    session.advance(session.end_s)
    return session


@pytest.mark.parametrize("method", ["sia", "eca"])
def test_rows_equal_the_measures_of_the_session(method):
    session = finished(method)
    rows = session_rows(session, 5)
    expected = measures(session.log())

    for name in ("gsi", "gsi_full_edges", "ta_mean_s", "robot_missed"):
        assert rows.session[name] == pytest.approx(getattr(expected, name))
    assert rows.iterations["gsi"] == pytest.approx([row.gsi for row in expected.iterations])
    assert rows.iterations["robot_missed"].tolist() == [row.robot_missed for row in expected.iterations]
    assert rows.steps["ta_s"][np.isfinite(rows.steps["ta_s"])] == pytest.approx(expected.ta_s)
    latencies = [item.mean * item.n for item in expected.net_latency_s.values()]
    assert np.nansum(rows.steps["latency_s"]) == pytest.approx(sum(latencies))
    followed = {"sia": (0, 1, 2, 3), "eca": (0,)}[method]
    assert set(rows.iterations["followed"].tolist()) <= set(followed)


def test_columns_are_those_of_the_study():
    rows = session_rows(finished("sia"), 5)
    assert set(rows.session) <= set(SESSIONS)
    for found, expected in ((rows.iterations, ITERATIONS), (rows.steps, STEPS), (rows.events, EVENTS)):
        assert list(found) == list(expected)
        assert len({len(values) for values in found.values()}) == 1
        assert set(found["session"].tolist()) == {5}


def test_a_session_without_a_robot_has_no_steps():
    rows = session_rows(finished("none"), 1)
    assert len(rows.steps["ta_s"]) == 0
    assert np.isnan(rows.session["ta_mean_s"])
    assert rows.session["robot_missed"] == 0
    assert rows.session["gsi"] == pytest.approx(rows.session["gsi_humans"])
    assert 0 not in rows.events["agent"]


def test_events_are_in_order_and_relative_to_their_iteration():
    session = finished("sia")
    events = session_rows(session, 0).events
    key = list(zip(events["agent"], events["iteration"], events["t_s"], strict=True))
    assert key == sorted(key)
    assert -3.0 < events["t_s"].min() < 2.0
    assert events["t_s"].max() < 25.0
