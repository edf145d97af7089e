"""Builds of the dancers, faults in their cues, and the timing error that they perceive."""

from __future__ import annotations

import dataclasses

import pytest

from sjasim.config import BodyConfig, FaultConfig, SessionConfig
from sjasim.core import ROBOT, Cue, Kind, Move
from sjasim.core.session_log import AgentEvent
from sjasim.simulation.cast import cues_with_faults, perceived_timing_error_s, sample_build


def test_perceived_error_is_the_distance_from_the_dancers_mean_time():
    cues = [Cue(f"dancer_{k}", Move.FORWARD, 1, 0, 0.0, 10.0 + 0.2 * k, 2.0) for k in range(3)]
    clap = Cue("dancer_1", Move.CLAP, 1, 8, 32.0, 26.0, 0.0)
    robot = [AgentEvent(1, ROBOT, Kind.START_FORWARD, 10.5), AgentEvent(1, ROBOT, Kind.TURN, 26.5)]
    assert perceived_timing_error_s([*cues, clap], robot) == pytest.approx((0.3 + 0.5) / 2)


def test_perceived_error_is_none_without_dancers_or_robot():
    clap = Cue("dancer_1", Move.CLAP, 1, 8, 32.0, 26.0, 0.0)
    turn = AgentEvent(1, ROBOT, Kind.TURN, 26.5)
    assert perceived_timing_error_s([clap], []) is None
    assert perceived_timing_error_s([], [turn]) is None


def test_builds_depend_on_the_seed_and_stay_within_the_configured_range():
    body = BodyConfig(stature_m=(1.6, 1.7), mass_kg=(60.0, 65.0))
    config = SessionConfig(seed=4, body=body)
    builds = [sample_build(config, dancer) for dancer in range(3)]
    assert len(set(builds)) == 3
    assert all(1.6 <= build.stature_m <= 1.7 and 60.0 <= build.mass_kg <= 65.0 for build in builds)
    assert [sample_build(dataclasses.replace(config, method="eca"), dancer) for dancer in range(3)] == builds
    assert sample_build(dataclasses.replace(config, seed=5), 0) != builds[0]


def test_faults_delay_or_remove_the_cues_of_their_target_from_their_time_on():
    cues = tuple(
        Cue(dancer, Move.FORWARD, 1, 0, 0.0, t_s, 2.0) for dancer in ("dancer_1", "dancer_2") for t_s in (4.0, 8.0)
    )
    late = cues_with_faults(cues, [FaultConfig("dancer_late", "dancer_1", 5.0, 0.5)])
    assert [cue.t_s for cue in late] == [4.0, 8.5, 4.0, 8.0]
    stopped = cues_with_faults(cues, [FaultConfig("dancer_stops", "dancer_2", 8.0)])
    assert [(cue.dancer, cue.t_s) for cue in stopped] == [("dancer_1", 4.0), ("dancer_1", 8.0), ("dancer_2", 4.0)]
