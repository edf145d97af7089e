"""Balance of dancers of any build: whole dances, pushes and a collision with the robot, with and without support."""

import dataclasses
import math

import pytest

from sjasim.config import DanceConfig
from sjasim.simulation.motion_recording import motion_figures
from sjasim.simulation.motion_trials import FULL_RANGE, collision_trial, count_falls_after_push, dance_trial

DANCE = DanceConfig(rehearsal=False)


@pytest.mark.parametrize("side", [0.0, math.pi / 2, math.pi, -math.pi / 2], ids=["front", "left", "back", "right"])
def test_a_robot_that_drives_into_a_dancer_stops_and_the_dancer_sways(side):
    hit = collision_trial(9601, side)
    assert 50.0 < hit.peak_n < 300.0
    assert hit.falls == 0
    assert hit.speed_m_s < 0.05
    assert 0.0005 < hit.sway_m < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("walking", [False, True], ids=["standing", "walking"])
def test_no_dancer_falls_after_a_push_of_20_newton_seconds(walking):
    assert sum(count_falls_after_push(seed, 20.0, walking=walking) for seed in range(9601, 9605)) == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper", "march", "waltz"])
def test_dancers_of_new_builds_do_not_fall_and_are_on_time(name):
    found = motion_figures([dance_trial(9611, iterations=2, dance=dataclasses.replace(DANCE, name=name))])
    assert found["falls"] == found["crossings_missing"] == found["claps_missing"] == 0
    assert found["pelvis_error_mean_mm"] <= 25
    assert found["tether_rms_n"] <= 20
    assert found["feet_load_share"] >= 0.99
    assert abs(found["crossing_bias_ms"]) <= 10
    assert found["crossing_p95_ms"] <= 33
    assert found["rise_p95_s"] <= 0.35
    assert found["slip_median_mm"] <= 5
    assert name == "march" or found["clap_p95_ms"] <= 20


@pytest.mark.slow
def test_dancers_without_balance_support_finish_a_dance():
    alone = motion_figures([dance_trial(9621, body=dataclasses.replace(FULL_RANGE, balance_support="none"))])
    assert alone["falls"] == 0
    assert alone["tether_rms_n"] == 0.0
