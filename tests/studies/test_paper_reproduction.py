"""Reproduction of the published study: rows, hypotheses, findings, report."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sjasim.analysis.published_values import PUBLISHED, StudyArrays
from sjasim.commands.main import main
from sjasim.reproduce import command
from sjasim.studies import paper_findings
from sjasim.studies.paper_reproduction import HYPOTHESES, PaperReproduction, study_design, summary, value_rows
from sjasim.studies.reproduction_options import ReproductionOptions
from sjasim.studies.study_design import StudyPlan

RNG = np.random.default_rng(3)


def studies_around(gsi: float) -> StudyArrays:
    """Forty studies of three groups whose index scatters around a value."""
    return StudyArrays(RNG.normal(gsi, 0.1, (40, 3, 4, 2)), RNG.exponential(0.6, (40, 3, 4, 9, 2)))


def test_a_value_is_inside_if_the_interval_holds_it():
    rows = {(row["value"], row["method"]): row for row in value_rows(studies_around(0.43))}
    assert len(rows) == len(PUBLISHED)
    mean = rows["gsi_mean", "eca"]
    assert mean["low"] < mean["mean"] < mean["high"]
    assert mean["inside"]
    far = {(row["value"], row["method"]): row for row in value_rows(studies_around(0.9))}
    assert not far["gsi_mean", "eca"]["inside"]
    assert "gsi_mean eca" in summary(list(far.values()))


def test_groups_dance_both_methods_with_the_seeds_of_evaluation():
    plan = StudyPlan(study_design(ReproductionOptions(studies=20, groups=3)))
    assert len(plan) == 20 * 3 * 2
    first = [plan.session(number) for number in range(2)]
    assert {spec.config.method for spec in first} == {"eca", "sia"}
    assert len({spec.config.seed for spec in first}) == 1
    tuning = StudyPlan(study_design(ReproductionOptions(studies=20, groups=3), seeds="tuning"))
    seeds = [{plan.session(number).config.seed for number in range(len(plan))} for plan in (plan, tuning)]
    assert not seeds[0] & seeds[1]


def test_the_warm_up_hypothesis_follows_a_dancer_from_the_third_iteration():
    assert HYPOTHESES["paper-warmup"] == {"first_followed_iteration": 3}
    plan = StudyPlan(study_design(ReproductionOptions(humans="paper-warmup", studies=20, groups=3)))
    options = {plan.session(number).config.method: plan.session(number).config.method_options for number in range(2)}
    assert options == {"eca": {}, "sia": {"first_followed_iteration": 3}}


def test_the_findings_are_intervals_over_groups(monkeypatch):
    monkeypatch.setattr(paper_findings, "GROUPS", 6)
    found = paper_findings.findings("paper-entrainment", seed=1, jobs=1)
    assert len(found) == 4
    assert all(item["low"] < item["mean"] < item["high"] for item in found)
    # Steady people are far above the published index, and people without a common shift far below its error.
    assert found[1]["low"] > 0.7
    assert found[2]["high"] < 0.5


def test_people_without_entrainment_have_no_finding_about_it(monkeypatch):
    monkeypatch.setattr(paper_findings, "GROUPS", 3)
    assert len(paper_findings.findings("musicians", seed=1, jobs=1)) == 3


def test_the_command_prints_and_writes_the_same_rows(tmp_path, capsys):
    arguments = ["--studies", "20", "--groups", "3", "--no-findings", "--json", "--out", str(tmp_path / "out")]
    assert main(command, arguments) == 0
    printed = json.loads(capsys.readouterr().out)
    written = json.loads((tmp_path / "out" / "reproduce.json").read_text())
    assert printed == written
    assert printed["preset"] == "paper-entrainment"
    assert [row["value"] for row in printed["rows"]] == [value.name for value in PUBLISHED]
    assert all(row["inside"] == (row["low"] <= row["paper"] <= row["high"]) for row in printed["rows"])


def test_the_table_fits_80_columns(capsys):
    rows = value_rows(studies_around(0.43))
    finding = {"title": "A finding", "text": "GSI:", "mean": 0.1, "low": 0.0, "high": 0.2}
    PaperReproduction(ReproductionOptions(), rows, [finding]).print(False)
    lines = capsys.readouterr().out.splitlines()
    assert all(len(line) <= 80 for line in lines if line[:1] in "┏┃┡│└")
    assert not any("…" in line for line in lines)
    assert lines[-1].startswith("inside: ")


@pytest.mark.slow
def test_musicians_fail_at_least_five_values_and_fitted_people_at_most_two(capsys):
    rows = {}
    for humans, studies in (("musicians", "40"), ("paper-entrainment", "200")):
        assert main(command, ["--humans", humans, "--studies", studies, "--no-findings", "--json"]) == 0
        rows[humans] = json.loads(capsys.readouterr().out)["rows"]
    outside = {humans: sum(not row["inside"] for row in found) for humans, found in rows.items()}
    assert outside["musicians"] >= 5
    assert outside["paper-entrainment"] <= 2
