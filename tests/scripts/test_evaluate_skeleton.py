"""Targets of depth sensing, on dances that were not used for tuning; ``-s`` prints the figures."""

import importlib.util
from pathlib import Path

import pytest

PATH = Path(__file__).resolve().parents[2] / "scripts" / "evaluate_skeleton.py"
SEED = 9700
DANCES = 2
FRAME_S = 1.0 / 30.0


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("evaluate_skeleton", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def figures(script, name):
    row = script.condition_figures(name, DANCES, SEED)
    script.print_condition(name, row)
    return row


@pytest.mark.slow
@pytest.mark.parametrize("name", ["facing", "extreme_builds", "yaw_45", "yaw_-45", "yaw_90", "yaw_-90"])
def test_visible_joints_reach_their_targets(script, name):
    row = figures(script, name)
    median_cm, p95_cm = script.TARGETS_CM[name]
    assert row["median_cm"] <= median_cm
    assert row["p95_cm"] <= p95_cm
    assert row["swapped"] == 0.0
    assert row["changed"] == 0
    assert row["tracked"] >= (0.97 if "90" in name else 0.98)  # from the side the far hand is mostly occluded


@pytest.mark.slow
@pytest.mark.parametrize("name", ["facing", "extreme_builds"])
def test_events_of_visible_dancers_are_those_of_their_true_joints(script, name):
    row = figures(script, name)
    assert row["jitter_base_cm"] <= 0.05
    for group in ("moves", "claps"):
        counts = row["events"][group]
        assert counts["expected"] >= 4
        assert counts["missed"] == 0
        assert counts["false"] <= 0.01 * counts["expected"]
        assert counts["p95_ms"] <= 1000.0 * FRAME_S + 0.1


@pytest.mark.slow
def test_dancers_who_pass_one_another_keep_their_identities(script):
    for found in (script.crossing_errors(SEED), script.occlusion_errors(SEED)):
        assert found["runs"] >= 8
        assert found["wrong"] == 0
