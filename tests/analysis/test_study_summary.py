"""Summaries of studies: the paper's Table I, wins, timing, and plain data for study.json."""

import dataclasses
import json

import numpy as np
import pytest

from sjasim.analysis.study_summary import study_summary
from sjasim.analysis.study_values import select_sessions
from sjasim.assets.published_study import GROUPS_WON, GSI, ITERATIONS_WON
from sjasim.core.errors import ConfigError

from .synthetic_study import nested_study, paper_table


@pytest.fixture(scope="module")
def paper():
    return study_summary(paper_table())


@pytest.fixture(scope="module")
def study():
    return nested_study(np.random.default_rng(1), methods=("none", "eca", "sia"))


def test_the_paper_s_table_gives_the_paper_s_figures(paper):
    assert paper["gsi"]["eca"]["mean"] == pytest.approx(0.4108, abs=5e-5)
    assert paper["gsi"]["sia"]["mean"] == pytest.approx(0.4556, abs=5e-5)
    assert (paper["gsi"]["eca"]["min"], paper["gsi"]["eca"]["max"]) == (0.15, 0.78)
    assert paper["gsi"]["sia"]["sd"] == pytest.approx(0.146, abs=1e-3)
    means = [row["mean"] for row in paper["gsi"]["sia"]["by_iteration"]]
    assert means == pytest.approx([0.361, 0.392, 0.534, 0.534], abs=5e-4)


def test_sia_wins_22_of_36_iterations_and_7_of_9_groups_of_the_paper(paper):
    assert paper["wins"]["pair"] == ["eca", "sia"]
    assert paper["wins"]["iterations"] == list(ITERATIONS_WON)
    assert paper["wins"]["groups"] == list(GROUPS_WON)
    assert paper["wins"]["pairs"][0]["iterations"] == {"first": 13, "second": 22, "ties": 1, "n": 36}


def test_the_table_has_the_paper_s_cells_and_marks_the_best(paper):
    assert len(paper["table"]) == 9
    for row, eca, sia in zip(paper["table"], GSI["eca"], GSI["sia"], strict=True):
        assert [cell["gsi"] for cell in row["iterations"]] == [
            {"eca": a, "sia": b} for a, b in zip(eca, sia, strict=True)
        ]
    assert paper["table"][3]["iterations"][3]["best"] == ["eca", "sia"]
    assert paper["table"][5]["best"] == ["sia"]


def test_the_paper_s_difference_in_gsi_is_not_significant_at_group_level(paper):
    (row,) = [row for row in paper["comparisons"] if row["measure"] == "gsi"]
    assert row["difference"] == pytest.approx(0.0447, abs=1e-4)
    assert row["groups"] == 9
    assert row["p"] == 28 / 512
    assert row["low"] < 0.0 < row["high"]


def test_a_summary_is_plain_json_and_repeats_itself(study):
    summary = study_summary(study, seed=3)
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    assert study_summary(study, seed=3) == summary


def test_sessions_without_a_robot_are_compared_in_the_dancers_synchrony_alone(study):
    summary = study_summary(study)
    assert set(summary["gsi"]) == {"none", "eca", "sia"}
    assert set(summary["ta"]) == {"eca", "sia"}
    measures = {(row["measure"], row["first"], row["second"]) for row in summary["comparisons"]}
    assert ("gsi_humans", "none", "sia") in measures
    assert ("gsi", "none", "sia") not in measures
    assert summary["wins"]["pair"] == ["eca", "sia"]


def test_timing_has_the_paper_s_bins_and_counts_every_step(study):
    figures = study_summary(study)["ta"]["eca"]
    assert figures["n"] == 9 * 4 * 9
    assert sum(figures["histogram"]["counts"]) + figures["histogram"]["overflow"] == figures["n"]
    assert set(figures["cdf"]) == {"0.8", "1.2", "1.6"}


def test_a_group_that_lacks_a_method_is_left_out_of_comparisons_and_counted(study):
    lost = (study.sessions["group"] == 4) & (study.sessions["condition"] == "sia")
    summary = study_summary(select_sessions(study, ~lost))
    (row,) = [row for row in summary["comparisons"] if row["measure"] == "gsi"]
    assert (row["groups"], row["left_out"]) == (8, 1)
    assert summary["wins"]["groups"][1] == 8
    assert summary["gsi"]["eca"]["groups"] == 9
    assert summary["table"][3]["mean"]["sia"] is None


def failed(study, sessions):
    """The study as it is written if some sessions failed: rows without measures, and nothing in the other tables."""
    measures = ("gsi", "gsi_full_edges", "gsi_humans", "ta_mean_s")
    lost = np.isin(study.sessions["session"], sessions)
    rows = {name: np.where(lost, np.nan, values) if name in measures else values
            for name, values in study.sessions.items()}  # fmt: skip
    return dataclasses.replace(select_sessions(study, ~lost), sessions=rows)


def test_a_session_that_failed_leaves_its_group_out_of_comparisons(study):
    summary = study_summary(failed(study, [4]))
    (row,) = [row for row in summary["comparisons"] if row["measure"] == "gsi"]
    assert (row["groups"], row["left_out"]) == (8, 1)
    assert summary["gsi"]["eca"]["groups"] == 8
    assert summary["wilcoxon"]["n"] == 2 * 8 * 4 * 9


def test_a_condition_of_which_all_sessions_failed_is_not_compared(study):
    summary = study_summary(failed(study, study.sessions["session"][study.sessions["condition"] == "sia"]))
    assert summary["gsi"]["sia"]["mean"] is None
    assert summary["chance"]["sia"] is None
    assert summary["wilcoxon"] is None
    assert {(row["first"], row["second"]) for row in summary["comparisons"]} == {("none", "eca")}


def test_a_missed_step_leaves_its_pair_out_of_the_event_test(study):
    ta_s = study.steps["ta_s"].copy()
    ta_s[:5] = np.nan
    summary = study_summary(dataclasses.replace(study, steps={**study.steps, "ta_s": ta_s}))
    assert summary["wilcoxon"]["n"] == 2 * (9 * 4 * 9 - 5)
    assert summary["ta"]["eca"]["missed"] == 5


def test_the_order_of_conditions_can_be_chosen_and_turns_differences(study):
    forward = study_summary(study)
    backward = study_summary(study, ("sia", "eca"))
    assert backward["conditions"] == ["sia", "eca", "none"]
    assert backward["wilcoxon"]["z"] == pytest.approx(-forward["wilcoxon"]["z"])
    with pytest.raises(ConfigError, match="march"):
        study_summary(study, ("march",))


def test_conditions_are_compared_if_they_differ_in_one_thing_and_have_groups_in_common(study):
    names = study.sessions["condition"].copy()
    tempo = np.where(study.sessions["group"] <= 6, 100.0, 118.0)
    conditions = np.array([f"{name} dance.bpm={bpm:g}" for name, bpm in zip(names, tempo, strict=True)], dtype=object)
    sessions = {**study.sessions, "condition": conditions, "factor.dance.bpm": tempo}
    summary = study_summary(dataclasses.replace(study, sessions=sessions))
    pairs = [(row["first"], row["second"]) for row in summary["comparisons"] if row["measure"] == "gsi"]
    assert pairs == [
        ("eca dance.bpm=100", "sia dance.bpm=100"),
        ("eca dance.bpm=118", "sia dance.bpm=118"),
    ]
    assert any("3 pairs of conditions are not compared" in line for line in summary["notices"])


def test_replications_are_summarised_over_studies():
    many = nested_study(np.random.default_rng(2), groups=3, studies=20)
    summary = study_summary(many)
    assert summary["studies"] == 20
    assert len(summary["table"]) == 3
    spread = summary["replications"]["gsi"]["eca"]
    assert spread["studies"] == 20
    assert spread["low"] < spread["mean"] < spread["high"]
    overall = many.iterations["gsi"][np.isin(many.iterations["session"] % 2, [0])].mean()
    assert spread["mean"] == pytest.approx(overall)
    assert summary["replications"]["wins_iterations"]["high"] <= 12


def test_a_study_of_one_method_and_one_group_has_no_comparison():
    summary = study_summary(nested_study(np.random.default_rng(3), groups=1, methods=("sia",)))
    assert summary["wins"] is None
    assert summary["wilcoxon"] is None
    assert summary["comparisons"] == []
    assert summary["gsi"]["sia"]["low"] is None


def test_a_study_without_sessions_is_refused(study):
    with pytest.raises(ConfigError, match="at least one session"):
        study_summary(select_sessions(study, np.zeros(len(study.sessions["session"]), dtype=bool)))
