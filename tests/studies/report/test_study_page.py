"""The page of a study: its figures are those of study.json, and it says what is missing."""

import copy
import json
from xml.etree import ElementTree

import numpy as np
import pytest

from sjasim.assets import published_study as published
from sjasim.studies.report.folders import write_report
from sjasim.studies.report.study_page import verdict
from sjasim.studies.report.study_synchrony import condition_series
from sjasim.studies.report.study_timing import timing_figures

from .conftest import study_content
from .html_page import read_page


@pytest.fixture
def page(folder_of, paper_study):
    return read_page(write_report(folder_of("study.json", paper_study)))


def rows_of(page, start):
    """Rows below the heads of the table whose label begins like this."""
    (label,) = [label for label in page.tables if label.startswith(start)]
    return page.tables[label][1:]


def test_the_index_of_every_condition_is_that_of_the_file(page, paper_study):
    rows = {(row[0], row[1]): row[2:] for row in rows_of(page, "Group synchronisation index")}
    assert len(rows) == 7
    for name, text in (("eca", "ECA"), ("sia", "SIA")):
        for index, edges in (("gsi", "published rule"), ("gsi_full_edges", "all"), ("gsi_humans", "dancers only")):
            own = paper_study[index][name]
            assert rows[text, edges][0] == f"{own['mean']:.3f}"
            assert rows[text, edges][1] == f"[{own['low']:.3f}, {own['high']:.3f}]"
        assert rows[text, "published rule"][-2:] == [
            f"{np.mean(published.GSI[name]):.3f}",
            f"{np.std(published.GSI[name], ddof=1):.3f}",
        ]
        assert rows[text, "all"][-2:] == ["–", "–"]
    # Without a robot there is only the index of the dancers.
    assert [key for key in rows if key[0] == "dancers alone"] == [("dancers alone", "dancers only")]


def test_the_chance_level_stands_beside_every_index(page, paper_study):
    rows = {(row[0], row[1]): row[2:] for row in rows_of(page, "Group synchronisation index")}
    level = paper_study["chance"]["sia"]["surrogates"]["pseudo_groups"]["gsi_full_edges"]
    shown = [f"{level['mean']:.3f}", f"{level['p95']:.3f}", f"{100 * level['above_p95']:.0f} %"]
    assert rows["SIA", "all"][3:6] == shown
    assert f"{shown[-1]} under SIA" in verdict(paper_study)[2]

    surrogates = {row[0]: row[1:] for row in rows_of(page, "What would be found by chance")}
    shifted = paper_study["chance"]["eca"]["surrogates"]["uniform_shift"]["gsi_full_edges"]
    assert surrogates["ECA"][-2:] == [f"{shifted['mean']:.3f}", f"{shifted['p95']:.3f}"]


def test_the_table_of_groups_is_that_of_the_file_beside_the_published_one(page, paper_study):
    rows = rows_of(page, "This study")
    assert len(rows) == 9
    for row, group in zip(rows, paper_study["table"], strict=True):
        values = [entry["gsi"][name] for name in ("eca", "sia") for entry in group["iterations"]]
        shown = [*row[1:5], *row[6:10]]
        assert shown == [f"{value:.2f}" for value in values]
        assert [row[5], row[10]] == [f"{group['mean'][name]:.2f}" for name in ("eca", "sia")]

    printed = rows_of(page, "The published study")
    assert [row[1:5] for row in printed] == [[f"{value:.2f}" for value in group] for group in published.GSI["eca"]]
    styles = page.styles["The published study: index of each group"][1:]
    won = sum("best" in row[6:10][i] for row in styles for i in range(4))
    assert won == published.ITERATIONS_WON[0]
    assert sum(row[10] == "best" for row in styles) == published.GROUPS_WON[0]


def test_the_timing_is_that_of_the_file_and_the_published_one(page, paper_study):
    rows = {row[0]: row[1:] for row in rows_of(page, "Timing appropriateness")}
    for name, text in (("eca", "ECA"), ("sia", "SIA")):
        own = paper_study["ta"][name]
        assert rows[text][0] == f"{own['mean_s']:.2f}"
        assert rows[text][2] == f"{own['sd_s']:.2f}"
        assert rows[text][3:6] == [f"{100 * own['cdf'][limit]:.1f} %" for limit in ("0.8", "1.2", "1.6")]
        assert rows[text][6:] == [str(own["n"]), str(own["missed"])]
        assert rows[f"{text}, published"][0] == f"{published.TA_MEAN_S[name]:.2f}"
    assert rows["ECA, published"][3:6] == ["–", "81.9 %", "90.0 %"]


def test_the_comparisons_are_those_of_the_file(page, paper_study):
    rows = rows_of(page, "Differences")
    assert len(rows) == len(paper_study["comparisons"])
    for row, item in zip(rows, paper_study["comparisons"], strict=True):
        assert row[4] == f"{item['difference']:+.3f}".replace("-", "−")
        assert row[6:8] == [f"{item['p']:.3f}", f"{item['p_adjusted']:.3f}"]


def test_there_is_a_histogram_of_each_method_and_a_common_curve(page):
    titles = [title for title, _, _ in page.drawings]
    assert titles == [
        "Synchrony of the group",
        "Synchrony by iteration",
        "Timing appropriateness under ECA",
        "Timing appropriateness under SIA",
        "Cumulative share of the robot's events",
        "Mean timing appropriateness",
    ]
    shapes = {title: count for title, _, count in page.drawings}
    # 25 bins and one bar for what lies beyond them.
    assert shapes["Timing appropriateness under ECA"] >= 26
    assert all(description for _, description, _ in page.drawings)


def test_the_bars_of_a_histogram_are_the_counts_of_the_file(paper_study):
    figures = timing_figures(paper_study, condition_series(paper_study["conditions"]))
    for figure, name in zip(figures, ("eca", "sia"), strict=False):
        own = paper_study["ta"][name]["histogram"]
        root = ElementTree.fromstring(str(figure.drawing))
        heights = np.array([float(bar.attrib["height"]) for bar in root.iter("rect")])
        counts = np.array([*own["counts"], own["overflow"]])
        assert len(heights) == len(counts)
        # All heights have the same scale, and stay inside the area of the plot, which is 218 px high.
        scale = heights.sum() / counts.sum()
        assert heights == pytest.approx(scale * counts, abs=0.02)
        assert heights.max() <= 218.0


def test_charts_are_described_with_the_figures_of_the_file(page, paper_study):
    described = {title: text for title, text, _ in page.drawings}
    for name, text in (("eca", "ECA"), ("sia", "SIA")):
        own = paper_study["gsi"][name]
        means = ", ".join(f"{entry['mean']:.2f}" for entry in own["by_iteration"])
        assert f"{name}: {means}" in described["Synchrony by iteration"]
        assert f"{text} {own['mean']:.3f} [{own['low']:.3f}, {own['high']:.3f}]" in described["Synchrony of the group"]
        mean_s = paper_study["ta"][name]["group_mean_s"]
        assert f"{text} {mean_s:.2f} s" in described["Mean timing appropriateness"]


def test_ratings_stand_beside_the_index(page, paper_study):
    ratings = paper_study["ratings"]
    rows = rows_of(page, "Simulated ratings")
    assert len(rows) == len(ratings["by_group"]) == 9
    for row, group in zip(rows, ratings["by_group"], strict=True):
        assert row[1] == " ".join(map(str, group["ratings"]["eca"]))
    assert f"In {ratings['matches']} of 9 groups most dancers find" in page.text
    assert "the ratings are no evidence about people" in page.text


def test_the_verdict_comes_first_and_names_the_better_method(page, paper_study):
    first, second, *_ = verdict(paper_study)
    assert first.startswith("Groups are more synchronous under ECA than under SIA")
    assert f"{paper_study['gsi_full_edges']['sia']['mean']:.2f} under SIA" in first
    assert "nearest to the dancers under ECA" in second
    assert page.text.index(first) < page.text.index("What was asked")


def test_a_difference_that_is_not_shown_is_not_claimed(paper_study):
    content = copy.deepcopy(paper_study)
    for item in content["comparisons"]:
        item["p_adjusted"] = 0.4
    first, second, *_ = verdict(content)
    assert first.startswith("9 groups do not show a difference in synchrony")
    assert "do not show to be a difference" in second


def test_the_difference_is_the_better_method_minus_the_other(paper_study):
    content = copy.deepcopy(paper_study)
    for name, mean in (("eca", 0.6), ("sia", 0.4)):
        content["gsi_full_edges"][name]["mean"] = mean
    (item,) = [item for item in content["comparisons"] if item["measure"] == "gsi_full_edges"]
    item |= {"difference": -0.2, "low": -0.3, "high": -0.1, "p_adjusted": 0.01}
    assert "difference 0.20, 95 % interval 0.10 to 0.30, p = 0.010" in verdict(content)[0]


def test_of_several_conditions_the_shown_differences_are_named():
    content = study_content(methods=("eca", "sia", "random-dancer"), groups=4)
    for item in content["comparisons"]:
        item |= {"difference": 0.2, "p_adjusted": 0.01 if item["first"] == "eca" else 0.6}
    first, second, *_ = verdict(content)
    assert "Shown to be more synchronous: SIA than ECA and random-dancer than ECA." in first
    assert "No difference is shown between SIA and random-dancer." in first
    # A greater distance from the dancers is worse.
    assert "Shown to be nearer: ECA than SIA and ECA than random-dancer." in second


def test_what_is_missing_is_said(folder_of, paper_study):
    content = {**paper_study, "chance": dict.fromkeys(paper_study["conditions"])}
    page = read_page(write_report(folder_of("study.json", content)))
    assert "No chance level could be computed" in page.text
    assert "by chance" not in verdict(content)[2]
    assert "No power analysis lies beside this study" in page.text


def test_a_power_analysis_beside_the_study_is_shown(folder_of, paper_study):
    folder = folder_of("study.json", paper_study)
    rows = [
        {"groups": 9, "power": 0.5, "low": 0.43, "high": 0.57},
        {"groups": 18, "power": 0.81, "low": 0.75, "high": 0.87},
    ]
    design = {"methods": ["eca", "sia"], "target": 0.8, "measure": "gsi", "max_groups": 18}
    needed = {"groups_needed": 18, "groups_needed_low": 15, "groups_needed_high": None}
    power = {"schema": 1, "rows": rows, "design": design, **needed}
    (folder / "power.json").write_text(json.dumps(power), encoding="utf-8")
    page = read_page(write_report(folder))
    assert "18 groups are needed to find the difference between ECA and SIA with a power of 80 %." in page.text
    assert "18 groups: 81 %" in next(text for title, text, _ in page.drawings if title.startswith("Power"))


def test_reviewers_questions_follow_the_data(page, paper_study):
    assert "A perfect session scores 10/12 under SIA" in page.text
    assert "Is part of the gain built into the people?" in page.text
    assert "It lacks the control random-dancer" in page.text
    assert f"{paper_study['wilcoxon']['n']} observations" in page.text
    assert "no p-value can be below 0.0039" in page.text


def test_other_people_and_a_control_change_the_questions(folder_of):
    content = study_content(methods=("eca", "sia", "random-dancer"))
    content["design"] = {**content["design"], "humans": ["musicians"]}
    page = read_page(write_report(folder_of("study.json", content)))
    assert "built into the people" not in page.text
    assert "SIA minus random-dancer is " in page.text
    assert "Of 3 conditions" in page.text


@pytest.mark.parametrize("methods", [("none",), ("sia",), ("eca", "mine:Method")])
def test_any_set_of_methods_has_a_page(folder_of, methods):
    page = read_page(write_report(folder_of("study.json", study_content(methods=methods, groups=4))))
    assert ("No session of this study has a robot" in page.text) == (methods == ("none",))
    assert ("Nothing can be compared" in page.text) == (len(methods) == 1)


def test_many_groups_and_conditions_are_counted_where_they_are_left_out(folder_of, paper_study):
    content = copy.deepcopy(paper_study)
    content["table"] *= 5
    for name in (f"sia dance.bpm={bpm}" for bpm in range(100, 106)):
        content["conditions"].append(name)
        for figures in ("gsi", "gsi_full_edges", "gsi_humans", "ta", "chance"):
            content[figures][name] = content[figures]["sia"]
        for group in content["table"][:9]:
            group["mean"][name] = group["mean"]["sia"]
            for entry in group["iterations"]:
                entry["gsi"][name] = entry["gsi"]["sia"]
    page = read_page(write_report(folder_of("study.json", content)))
    assert "The charts leave out the last 2 conditions" in page.text
    assert "5 further groups are in iterations.parquet" in page.text
    assert "SIA dance.bpm=105" in page.text


def test_a_study_that_was_not_compared_has_the_means_of_its_conditions(folder_of, paper_study):
    means = {"mean": 0.5, "sd": 0.1, "low": 0.4, "high": 0.6, "n": 9}
    row = {"condition": "sia dance.bpm=100", "method": "sia", "factors": {"dance.bpm": 100}, "sessions": 9}
    row |= dict.fromkeys(("gsi", "gsi_full_edges", "gsi_humans"), means) | {"ta_mean_s": dict.fromkeys(means)}
    content = {"schema": 1, "design": paper_study["design"], "conditions": ["sia dance.bpm=100"], "by_condition": [row]}
    page = read_page(write_report(folder_of("study.json", {**content, "notices": ["13 conditions are too many"]})))
    assert page.tables["Means over groups"][1] == ["SIA dance.bpm=100", "9", *["0.500", "[0.400, 0.600]"] * 3, "–", "–"]
    assert "The conditions of this study were not compared." in page.text
    assert "13 conditions are too many" in page.text


def test_replications_have_a_table(folder_of):
    page = read_page(write_report(folder_of("study.json", study_content(groups=4, studies=3))))
    rows = {row[0]: row[1:] for row in rows_of(page, "Replications")}
    assert rows["GSI, SIA"][-1] == "3"
    assert "this page shows the first" in page.text
