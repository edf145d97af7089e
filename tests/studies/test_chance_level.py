"""Chance level of the dancers' synchrony in simulated studies, against an independent computation."""

import numpy as np
import pytest

from sjasim.analysis.event_rows import event_rows
from sjasim.analysis.surrogates import chance_level
from sjasim.studies.study_design import StudyDesign
from sjasim.studies.study_execution import run_study

from ..analysis.test_surrogates import independent_chance


@pytest.mark.slow
@pytest.mark.parametrize("condition", ["none", "sia"])
def test_pseudo_groups_of_simulated_people_have_the_chance_level_of_an_independent_computation(condition):
    """In physics, the index was .595, its chance level .193 and the 95 % point .386."""
    study = run_study(StudyDesign(groups=30, methods=("sia",), seed=7), jobs=1)
    mean, point = independent_chance(study, condition, 600, np.random.default_rng(0))
    level = chance_level(event_rows(study, condition), np.random.default_rng(1))["surrogates"]["pseudo_groups"]
    assert level["gsi_humans"]["mean"] == pytest.approx(mean, abs=0.02)
    assert level["gsi_humans"]["p95"] == pytest.approx(point, abs=0.03)
    assert level["gsi_humans"]["mean"] == pytest.approx(0.193, abs=0.05)
    assert level["gsi_humans"]["p95"] == pytest.approx(0.386, abs=0.06)
    assert level["gsi_humans"]["observed"] > level["gsi_humans"]["p95"]
