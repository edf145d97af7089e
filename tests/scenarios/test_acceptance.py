"""Whole dances with joint sensing on seeds that nothing was tuned on; ``pytest -s`` prints the figures."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from sjasim.analysis.ground_truth_events import dancer_events
from sjasim.analysis.session_metrics import measures
from sjasim.choreography.timetable import timetable
from sjasim.config import NetworkConfig, SessionConfig
from sjasim.session.session import run_session

pytestmark = pytest.mark.slow

SEEDS = range(13001, 13011)
"""Seeds that nothing may be tuned on."""

MATCH_S = 0.4
"""Largest distance between a planned and a true event that count as one [s]."""


@pytest.fixture(scope="module")
def measures_by_seed():
    """Measures by seed, filled by the fixture `danced`."""
    return {}


@pytest.fixture(scope="module", params=SEEDS)
def danced(request, measures_by_seed):
    """Configuration, log and measures of the session of one seed."""
    config = SessionConfig(humans="paper-entrainment", sensing="joints", seed=request.param)
    log = run_session(config)
    result = measures(log)
    measures_by_seed[request.param] = result
    print(
        f"\n{request.param}: recall {result.detector.recall:.3f} precision {result.detector.precision:.3f} "
        f"clock p95 {1e3 * max(clock.p95_s for clock in result.clocks.values()):.2f} ms "
        f"executed {result.robot.executed:.3f} end {result.robot.end_distance_m:.2f} m "
        f"{math.degrees(result.robot.end_heading_rad):+.1f} degrees, feet {result.bodies.feet_load_share:.4f}"
    )
    return config, log, result


def test_nobody_falls_and_the_feet_carry_the_weight(danced):
    _, _, result = danced
    assert result.bodies.falls == 0
    assert result.bodies.feet_load_share >= 0.99


def test_every_planned_move_is_danced(danced):
    config, log, _ = danced
    true_events = dancer_events(log.truth, log.cues, timetable(config))
    planned = [(cue.dancer, kind, t_s) for cue in log.cues for kind, t_s in cue.events()]
    matches = [
        sum(e.agent == dancer and e.kind is kind and abs(e.t_s - t_s) <= MATCH_S for e in true_events)
        for dancer, kind, t_s in planned
    ]
    assert len(planned) >= 3 * 9 * config.iterations
    assert [event for event, count in zip(planned, matches, strict=True) if count != 1] == []


def test_estimated_clocks_agree_within_two_milliseconds(danced):
    _, _, result = danced
    assert max(clock.p95_s for clock in result.clocks.values()) <= 0.002


def test_the_robot_ends_on_its_heading(danced):
    _, _, result = danced
    assert abs(result.robot.end_heading_rad) <= math.radians(5)


def test_detectors_and_robot_over_all_seeds(measures_by_seed):
    """Pooled over the sessions of the tests above."""
    if len(measures_by_seed) < len(SEEDS):
        pytest.skip("needs the sessions of all seeds")
    results = list(measures_by_seed.values())
    detectors = [result.detector for result in results]
    robots = [result.robot for result in results]
    recall = np.average([d.recall for d in detectors], weights=[d.visible for d in detectors])
    precision = np.average([d.precision for d in detectors], weights=[d.logged for d in detectors])
    executed = np.average([robot.executed for robot in robots], weights=[robot.commands for robot in robots])
    far_from_slot = [seed for seed, result in measures_by_seed.items() if result.robot.end_distance_m > 0.25]
    print(f"\npooled: recall {recall:.4f} precision {precision:.4f} executed {executed:.4f} far {far_from_slot}")
    assert np.mean([result.bodies.feet_load_share for result in results]) >= 0.99
    assert recall >= 0.97
    assert precision >= 0.97
    assert executed >= 0.97
    assert not far_from_slot


@pytest.fixture(scope="module")
def metronomic():
    """Measures of ECA and SIA with metronomic dancers, and the share of occluded torso joints of each."""
    config = SessionConfig(humans="metronomic", sensing="joints")
    logs = {method: run_session(dataclasses.replace(config, method=method)) for method in ("eca", "sia")}
    occluded = {method: 1.0 - np.nanmean(log.truth["spine_seen"]) for method, log in logs.items()}
    return SimpleNamespace(occluded=occluded, **{method: measures(log) for method, log in logs.items()})


def test_the_torso_is_rarely_occluded(metronomic):
    print(f"\ntorso occluded in {metronomic.occluded} of the frames")
    assert max(metronomic.occluded.values()) <= 0.07


def test_eca_is_synchronous_with_metronomic_dancers(metronomic):
    print(f"\neca: gsi_full_edges {metronomic.eca.gsi_full_edges:.3f}")
    assert metronomic.eca.gsi_full_edges >= 0.9


def test_sia_follows_metronomic_dancers_within_tau(metronomic):
    latencies = metronomic.sia.net_latency_s
    for kind, latency in latencies.items():
        print(f"\n{kind}: {latency.mean:+.3f} s (sd {latency.sd:.3f}, n {latency.n})")
    assert set(latencies) == {"start_forward", "stop_forward", "start_backward", "stop_backward", "clap"}
    pooled_s = np.average([x.mean for x in latencies.values()], weights=[x.n for x in latencies.values()])
    print(f"pooled: {pooled_s:+.3f} s")
    assert pooled_s < 0.25


def test_an_asymmetric_link_biases_the_clocks_by_half_its_asymmetry():
    network = NetworkConfig(uplink_asymmetry_s=0.02)
    config = SessionConfig(method="eca", humans="metronomic", sensing="joints", iterations=1, network=network)
    clocks = measures(run_session(config)).clocks
    assert len(clocks) >= 2  # only sensors that reported events have a measured clock
    for sensor, clock in clocks.items():
        print(f"\n{sensor}: bias {1e3 * clock.bias_s:+.2f} ms")
        assert clock.bias_s == pytest.approx(0.01, abs=0.002)
        assert clock.p95_s > 0.008
