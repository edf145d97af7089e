"""Power of studies of simulated people: pool, effects, and the report."""

import json

import numpy as np
import pytest

from sjasim.analysis.study_values import group_values
from sjasim.config import SessionConfig
from sjasim.core.errors import ConfigError, SjasimError
from sjasim.studies.power import PowerDesign, pool_differences, power, print_power, simulate_pool
from sjasim.studies.study_design import StudyDesign
from sjasim.studies.study_execution import run_study

SMALL = PowerDesign(pool=16, max_groups=8, seed=3)


@pytest.fixture(scope="module")
def report():
    return power(SMALL, jobs=1)


def test_a_pool_has_the_wanted_number_of_different_groups_under_both_methods():
    tables = simulate_pool(SMALL, SessionConfig(), jobs=1)
    assert len(np.unique(tables.sessions["seed"])) == 16
    differences = pool_differences(tables, SMALL)
    values = group_values(tables, "gsi", ("eca", "sia"))
    assert differences == pytest.approx(values.column("sia") - values.column("eca"))
    assert len(differences) == 16


def test_the_report_has_one_row_for_each_number_of_groups_and_is_plain_json(report):
    assert json.loads(json.dumps(report, allow_nan=False)) == report
    assert [row["groups"] for row in report["rows"]] == [6, 7, 8]
    assert all(0.0 <= row["low"] <= row["power"] <= row["high"] <= 1.0 for row in report["rows"])
    assert report["schema"] == 1
    assert report["pool"] == 16
    assert report["effect"]["source"] == "simulated"
    assert report["effect"]["d_z"] == pytest.approx(report["effect"]["simulated"]["d_z"]["value"])


def test_the_report_repeats_itself(report):
    assert power(SMALL, jobs=1) == report


def test_a_study_on_disk_can_be_the_pool(tmp_path):
    folder = tmp_path / "study"
    run_study(StudyDesign(groups=8, humans_only=False, seed=3), folder, jobs=1)
    found = power(PowerDesign(pool=8, max_groups=7), study=folder)
    assert found["pool"] == 8
    assert found["config"] is None
    with pytest.raises(ConfigError, match="march"):
        power(PowerDesign(methods=("eca", "march"), pool=8, max_groups=7), study=folder)
    with pytest.raises(SjasimError, match="at least as many groups"):
        power(PowerDesign(pool=8, max_groups=8), study=folder) and power(PowerDesign(max_groups=9), study=folder)


def test_the_paper_s_effect_is_the_published_difference():
    assert PowerDesign(effect="paper").given_effect() == pytest.approx(0.0447, abs=1e-4)
    assert PowerDesign(effect="paper", measure="ta_mean_s").given_effect() == pytest.approx(-0.16)
    assert PowerDesign(effect="paper", methods=("sia", "eca")).given_effect() == pytest.approx(-0.0447, abs=1e-4)
    assert PowerDesign(effect="-.02").given_effect() == -0.02
    assert PowerDesign().given_effect() is None


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"effect": "paper", "measure": "gsi_full_edges"}, "effect"),
        ({"effect": "paper", "methods": ("eca", "metronome")}, "effect"),
        ({"effect": "large"}, "effect"),
        ({"effect": "0"}, "effect"),
        ({"effect": "nan"}, "effect"),
        ({"measure": "ta"}, "measure"),
        ({"methods": ("sia", "sia")}, "methods"),
        ({"max_groups": 5}, "max_groups"),
        ({"pool": 20, "max_groups": 40}, "pool"),
        ({"target": 1.0}, "target"),
        ({"alpha": 0.0}, "alpha"),
    ],
)
def test_a_design_that_cannot_be_answered_is_refused(changes, field):
    with pytest.raises(ConfigError) as caught:
        PowerDesign(**changes)
    assert caught.value.field == field


def test_a_target_that_is_not_reached_is_reported_as_such(report, capsys):
    print_power({**report, "groups_needed": None, "groups_needed_low": 7, "groups_needed_high": None})
    out = capsys.readouterr().out
    assert "groups needed for a power of 0.8: more than 8 (95 % interval 7 to more than 8)" in out
