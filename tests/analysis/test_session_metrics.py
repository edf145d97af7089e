"""Measures of sessions whose errors are known."""

import dataclasses
import json

import numpy as np
import pytest

from sjasim.analysis.session_metrics import measures
from sjasim.core import Kind

from ..synthetic_log import CLOCK_ERROR_S, DETECTION_S, ROBOT_LAG_S


@pytest.fixture(scope="module")
def log(make_session_log):
    return make_session_log(method="sia", iterations=3, joints=False)


@pytest.fixture(scope="module")
def result(log):
    return measures(log)


def test_known_errors_are_measured(result):
    assert result.detector.recall == result.detector.precision == 1.0
    assert result.detector.timing_bias_s == pytest.approx(DETECTION_S + CLOCK_ERROR_S, abs=0.005)
    for clock in result.clocks.values():
        assert clock.bias_s == pytest.approx(CLOCK_ERROR_S, abs=1e-9)
        assert clock.p95_s == pytest.approx(CLOCK_ERROR_S, abs=1e-9)
    assert result.bodies.tether_rms_n == pytest.approx(5.0)
    assert result.bodies.feet_load_share == pytest.approx(0.99)
    assert result.bodies.falls == 0
    assert result.robot.executed == 1.0
    assert result.robot.end_distance_m < 0.01
    assert abs(result.robot.end_heading_rad) < 0.01


def test_net_latencies_are_those_behind_the_followed_dancer(result):
    assert [(row.human_events, row.robot_events) for row in result.iterations] == [(27, 9)] * 3
    assert sum(latency.n for latency in result.net_latency_s.values()) == 2 * 9
    assert {row.msp for row in result.iterations} == {"dancer_1"}
    assert [row.followed for row in result.iterations] == [(), ("dancer_1",), ("dancer_1",)]
    means = [latency.mean for latency in result.net_latency_s.values()]
    assert means == pytest.approx([ROBOT_LAG_S - CLOCK_ERROR_S] * 5)


def test_both_edge_rules_and_perfect_synchrony(make_session_log):
    eca = measures(make_session_log(method="eca", spread_s=0.0, joints=False))
    assert eca.gsi == eca.gsi_full_edges == pytest.approx(1.0)
    assert eca.net_latency_s == {}
    sia = measures(make_session_log(method="sia", spread_s=0.0, joints=False))
    assert [row.gsi for row in sia.iterations] == pytest.approx([9 / 12, 10 / 12])
    assert sia.gsi_full_edges == pytest.approx(1.0)


def test_the_index_from_true_onsets_has_all_edges(make_session_log):
    log = make_session_log(method="sia", spread_s=0.0, joints=False)
    # The robot's true onsets coincide with the dancers', so that all pairs are synchronous.
    odometry = {**log.odometry, "t_s": log.odometry["t_s"] - DETECTION_S - ROBOT_LAG_S}
    result = measures(dataclasses.replace(log, odometry=odometry))

    assert [row.gsi_truth for row in result.iterations] == pytest.approx([1.0, 1.0])
    assert result.gsi_truth == pytest.approx(1.0)
    assert [row.gsi for row in result.iterations] == pytest.approx([9 / 12, 10 / 12])


def test_timing_appropriateness_is_the_robots_distance_from_the_dancers_mean(make_session_log):
    result = measures(make_session_log(spread_s=0.0, joints=False))
    assert result.ta_mean_s == result.late_mean_s == pytest.approx(ROBOT_LAG_S - CLOCK_ERROR_S)
    assert len(result.ta_s) == 2 * 9
    assert result.ta_truth_mean_s == pytest.approx(ROBOT_LAG_S + DETECTION_S, abs=0.02)


def test_measures_of_a_robot_are_nan_in_a_humans_only_session(make_session_log):
    result = measures(make_session_log(method="none", robot=False, joints=False))
    assert result.ta_s == ()
    assert np.isnan(result.ta_mean_s)
    assert result.robot_missed == 0
    plain = result.as_dict()
    assert plain["ta_mean_s"] is None
    assert plain["robot"]["end_distance_m"] is None


def test_missing_and_false_events_are_counted(log):
    events = tuple(e for e in log.events if not (e.person == "dancer_2" and e.kind is Kind.CLAP))
    false = dataclasses.replace(log.events[0], t_s=log.events[0].t_s + 1.0)
    robot = tuple(e for e in log.robot_events if not (e.iteration == 2 and e.kind is Kind.START_BACKWARD))
    result = measures(dataclasses.replace(log, events=(*events, false), robot_events=robot))
    true = 3 * 4 * 9
    assert result.detector.recall == pytest.approx((true - 4) / true)
    assert result.detector.precision == pytest.approx((true - 4) / (true - 3))
    assert [row.robot_missed for row in result.iterations] == [0, 2, 0]
    assert result.robot.executed == pytest.approx(25 / 27)


def test_invisible_events_do_not_count_against_recall(log):
    first = log.events[0]
    onset_s = first.t_s - DETECTION_S
    truth = dict(log.truth)
    truth["spine_seen"] = np.where(
        (truth["dancer"] == 0) & (abs(truth["t_s"] - onset_s) < 0.1), 0.0, truth["spine_seen"]
    )
    result = measures(dataclasses.replace(log, truth=truth, events=log.events[1:]))
    found = result.detector
    assert found.recall == 1.0
    assert found.visible == found.true - 2  # the stop of an invisible start is invisible too
    # One start was not logged; its stop was, although it counts as invisible.
    assert (found.detected_visible, found.detected, found.logged) == (found.visible, found.true - 1, found.true - 1)
    assert found.recall_all == pytest.approx((found.true - 1) / found.true)


def test_falls_are_counted_once(log):
    fallen = ((log.truth["dancer"] == 1) & (log.truth["t_s"] > 20)).astype(float)
    assert measures(dataclasses.replace(log, truth={**log.truth, "fallen": fallen})).bodies.falls == 1


def test_an_empty_log_has_measures(make_session_log):
    log = make_session_log(iterations=1, joints=False)
    empty = dataclasses.replace(
        log, events=(), robot_events=(), commands=(), cues=(), device_events=(), truth={}, odometry={}
    )
    result = measures(empty)
    assert result.gsi == 0.0
    assert result.as_dict()["detector"]["recall"] is None
    assert result.iterations[0].robot_missed == 9


def test_session_json_has_the_documented_keys_and_no_nan(result):
    text = json.dumps(result.as_dict(), allow_nan=False)
    plain = json.loads(text)
    public = {
        "schema", "method", "seed", "fidelity", "sensing", "humans", "config", "versions", "iterations", "gsi",
        "gsi_full_edges", "gsi_truth", "ta_mean_s", "ta_truth_mean_s", "ta_s", "net_latency_s", "detector",
        "tether_rms_n", "falls", "cost",
    }  # fmt: skip
    assert public <= set(plain)
    keys = {"index", "gsi", "gsi_full_edges", "gsi_truth", "msp", "followed", "late_mean_s", "ta_mean_s"}
    assert keys | {"events", "robot_missed"} == set(plain["iterations"][0])
    assert set(plain["iterations"][0]["events"]) == {"humans", "robot"}
    assert {"recall", "recall_all", "precision", "timing_p95_s"} <= set(plain["detector"])
    assert set(plain["cost"]) == {"sim_s", "cpu_s", "wall_s"}
