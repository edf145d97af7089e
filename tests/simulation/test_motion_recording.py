"""Figures of recorded motion, from recordings with known errors, and recordings of the world without sensing."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from sjasim.core import Cue, Move, WheelCommand
from sjasim.simulation.motion_recording import MotionRecording, motion_figures
from sjasim.simulation.open_loop_world import OpenLoopWorld

HZ = 50
STEPS = 4 * HZ


def standing(error_m: float, support_n: float = 0.0, falls: int = 0) -> MotionRecording:
    """Two dancers who stand for four seconds; the second one's pelvis is beside its plan."""
    roots = np.zeros((STEPS, 2, 6))
    roots[:, 1, 0] = error_m
    tether = np.zeros((STEPS, 2, 5))
    tether[:, 0, :2] = [0.6 * support_n, 0.8 * support_n]
    loads_n = np.full((STEPS, 2), 700.0)
    loads_n[:, 1] = 630.0
    return MotionRecording(
        t_s=np.arange(STEPS) / HZ,
        roots=roots,
        hands_m=np.full((STEPS, 2), 0.5),
        feet_m=np.zeros((STEPS, 2, 2, 2)),
        tether=tether,
        loads_n=loads_n,
        planned_m=np.zeros((STEPS, 2, 3)),
        landing_s=np.zeros((STEPS, 2, 2)),
        weight_n=np.array([700.0, 700.0]),
        cues=(Cue("dancer_1", Move.CLAP, 1, 8, 32.0, 1.0, 0.0), Cue("dancer_2", Move.CLAP, 1, 8, 32.0, 3.7, 0.0)),
        falls=falls,
    )


def test_figures_are_those_of_the_worst_dancer():
    figures = motion_figures([standing(0.01), standing(0.03, support_n=5.0, falls=1)])
    assert (figures["dances"], figures["dances_without_a_fall"], figures["falls"]) == (2, 1, 1)
    assert figures["pelvis_error_mean_mm"] == pytest.approx(30.0)
    assert figures["tether_rms_n"] == pytest.approx(5.0)
    assert figures["feet_load_share"] == pytest.approx(0.9)


def test_only_completed_moves_count_and_those_without_an_event_are_missing():
    recording = standing(0.0)
    assert [cue.t_s for cue in recording.completed_cues(0)] == [1.0]
    assert recording.completed_cues(1) == []
    figures = motion_figures([recording])
    assert figures["claps_missing"] == 1
    assert figures["crossings_missing"] == 0
    assert np.isnan(figures["clap_p95_ms"])
    assert np.isnan(figures["slip_median_mm"])


def test_the_open_loop_world_records_every_control_step(short_config):
    config = dataclasses.replace(short_config, method="none")
    world = OpenLoopWorld(config, [[] for _ in range(config.dancers)])
    world.wheels = WheelCommand(3.0, 3.0)
    start_m = world.physics.robot_pose()[:2]
    recording = world.run(1.0).recording()
    assert len(recording.t_s) == config.physics.control_hz
    assert recording.roots.shape == (len(recording.t_s), config.dancers, 6)
    assert recording.roots[:, :, :3] == pytest.approx(recording.planned_m, abs=0.01)
    assert recording.falls == 0

    # The constant wheel speeds of 3 rad/s drive the robot, whose wheels have a radius of a few centimetres.
    driven_m = np.hypot(*np.subtract(world.physics.robot_pose()[:2], start_m))
    assert driven_m == pytest.approx(3.0 * config.robot.wheel_radius_m, rel=0.15)
