"""Delays behind the dancers' plans, from a log whose delays are known, and back through the event-level world."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from sjasim.analysis.accuracy.timing_delays import DelayObservation, delay_observations, delay_table, statistics_tables
from sjasim.config import SessionConfig
from sjasim.core import Kind
from sjasim.session.session import run_session
from sjasim.session.timing_statistics import timing_statistics


def test_a_log_with_known_delays_gives_them_back(make_session_log):
    log = make_session_log(spread_s=0.0)
    observations = delay_observations(log)
    regular = [item.delay_s for item in observations if item.table == "regular" and not item.is_false]
    assert len(regular) > 50
    assert np.isfinite(regular).all()
    assert np.ptp(regular) < 0.05
    robot = [item.delay_s for item in observations if item.table == "robot"]
    assert len(robot) == len({command.number for command in log.commands})


def test_a_missing_start_hides_its_stop_and_a_false_event_counts(make_session_log):
    log = make_session_log(spread_s=0.0)
    events = list(log.events)
    start = next(event for event in events if event.kind is Kind.START_FORWARD and not event.early)
    extra = dataclasses.replace(start, t_s=start.t_s + 2.0)
    changed = dataclasses.replace(log, events=(*[event for event in events if event is not start], extra))

    before, after = ([item for item in delay_observations(item) if item.table == "regular"] for item in (log, changed))
    stops = [[item for item in found if item.kind is Kind.STOP_FORWARD] for found in (before, after)]
    assert len(stops[1]) == len(stops[0]) - 1
    assert sum(item.is_false for item in after) == 1
    missing = [item for item in after if not item.is_false and np.isnan(item.delay_s)]
    assert [item.kind for item in missing] == [Kind.START_FORWARD]


def test_the_table_by_hand():
    found = [DelayObservation("regular", Kind.CLAP, value) for value in (0.1, 0.2, 0.3, float("nan"))]
    found.append(DelayObservation("regular", Kind.CLAP, float("nan"), is_false=True))
    row = delay_table(found, minutes=2.0)["regular"]["clap"]
    assert (row["n"], row["missed"], row["false_per_minute"]) == (4, 0.25, 0.5)
    assert (row["delay_s"][0], row["delay_s"][10], row["delay_s"][-1]) == (0.1, 0.2, 0.3)


def test_the_event_level_world_has_the_delays_that_it_draws():
    config = SessionConfig(fidelity="timing", sensing="joints", humans="musicians")
    logs = []
    for seed in range(25):
        one = dataclasses.replace(config, seed=seed)
        log = run_session(one)
        logs.append((one, delay_observations(log), log.cost["sim_s"]))
    found = statistics_tables(logs)["joints"]["square"]
    drawn = timing_statistics("measured", "joints", "square")

    for name, table in (("regular", drawn.regular), ("early", drawn.early)):
        for kind, expected in table.items():
            row = found[name][kind.value]
            assert np.median(row["delay_s"]) == pytest.approx(np.median(expected.delay_s), abs=0.01)
            assert row["missed"] == pytest.approx(expected.missed, abs=0.06)
