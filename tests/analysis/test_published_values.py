"""The published values: what the paper reports, and that each function computes what it says."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.analysis.published_values import METHODS, PUBLISHED, StudyArrays, study_arrays
from sjasim.analysis.study_tables import StudyTables
from sjasim.assets import published_study as published

RNG = np.random.default_rng(4)


def paper_as_studies() -> StudyArrays:
    """The paper's Table I as two equal studies, with some timing appropriateness."""
    gsi = np.stack([np.array(published.GSI[method]) for method in METHODS], axis=-1)
    ta_s = RNG.exponential(0.6, (9, 4, 9, 2))
    ta_s[0, 0, 0, 1] = np.nan
    return StudyArrays(np.stack([gsi, gsi]), np.stack([ta_s, ta_s]))


def value_of(name: str, method: str = ""):
    return next(value for value in PUBLISHED if (value.name, value.method) == (name, method))


def test_there_are_at_least_27_values_with_different_names():
    assert len(PUBLISHED) >= 27
    assert len({(value.name, value.method) for value in PUBLISHED}) == len(PUBLISHED)
    assert {value.role for value in PUBLISHED} == {"fitted", "held out"}


@pytest.mark.parametrize(
    "value",
    [value for value in PUBLISHED if value.name.startswith(("gsi", "iterations", "groups", "group"))],
    ids=lambda value: f"{value.name}-{value.method}",
)
def test_the_papers_own_table_gives_the_papers_values(value):
    computed = value.compute(paper_as_studies())
    assert computed.shape == (2,)
    assert computed == pytest.approx(np.full(2, value.value))


def test_the_text_of_the_paper_agrees_with_its_table():
    assert value_of("gsi_mean", "eca").value == pytest.approx(0.4108, abs=5e-5)
    assert value_of("gsi_mean", "sia").value == pytest.approx(0.4556, abs=5e-5)
    assert value_of("gsi_rise", "sia").value == pytest.approx(0.158, abs=5e-4)
    assert value_of("iterations_won").value == 22
    assert value_of("groups_won").value == 7


def test_shares_and_missing_steps_ignore_what_the_robot_missed():
    studies = paper_as_studies()
    ta_s = studies.ta_s[0, ..., 1].ravel()
    within = value_of("ta_within_0.8_s", "sia").compute(studies)[0]
    assert within == pytest.approx((ta_s[np.isfinite(ta_s)] <= 0.8).mean())
    assert value_of("not_executed").compute(studies)[0] == pytest.approx(1 / studies.ta_s[0].size)
    assert value_of("ta_mean_s", "sia").compute(studies)[0] == pytest.approx(np.nanmean(ta_s))


def test_the_signed_rank_statistic_is_negative_if_sia_is_nearer():
    studies = paper_as_studies()
    nearer = StudyArrays(studies.gsi, np.stack([studies.ta_s[..., 0], 0.5 * studies.ta_s[..., 0]], axis=-1))
    assert (value_of("wilcoxon_z").compute(nearer) < -5).all()
    assert (value_of("wilcoxon_r").compute(nearer) < 0).all()


def test_tables_become_arrays_by_study_group_iteration_step_and_method():
    order = [(study, group, method) for study in range(2) for group in (1, 2, 3) for method in ("sia", "eca")]
    sessions = {
        "session": np.arange(len(order)),
        "study": np.array([study for study, _, _ in order]),
        "group": np.array([group for _, group, _ in order]),
        "condition": np.array([method for _, _, method in order], dtype=object),
    }
    keys = [(number, iteration) for number in range(len(order)) for iteration in (1, 2)]
    iterations = {
        "session": np.array([number for number, _ in keys]),
        "iteration": np.array([iteration for _, iteration in keys]),
        "gsi": np.array([number + iteration / 10 for number, iteration in keys]),
    }
    steps = {
        "session": np.repeat(iterations["session"], 3),
        "iteration": np.repeat(iterations["iteration"], 3),
        "ordinal": np.tile(np.arange(3), len(keys)),
        "ta_s": np.repeat(iterations["gsi"], 3) + np.tile(np.arange(3), len(keys)) / 100,
    }
    studies = study_arrays(StudyTables(sessions, iterations, steps, {}))
    assert studies.gsi.shape == (2, 3, 2, 2)
    assert studies.ta_s.shape == (2, 3, 2, 3, 2)
    # Study 1, group 2, iteration 2 under ECA is session 9.
    assert studies.gsi[1, 1, 1, 0] == pytest.approx(9.2)
    assert studies.ta_s[1, 1, 1, 2, 0] == pytest.approx(9.22)
