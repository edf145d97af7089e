"""The page of a characterisation: a verdict, and the figures of characterise.json."""

import copy

import pytest

from sjasim.config import SessionConfig
from sjasim.config.toml_file import to_plain
from sjasim.studies.report.characterisation_page import verdict
from sjasim.studies.report.folders import write_report

from .html_page import read_page


def detector_row(kind, early=False, row="all", occlusion="all", **figures):
    known = {"n": 100, "logged": 99, "recall": 0.99, "precision": 1.0, "bias_s": 0.2, "sd_s": 0.05, "p95_s": 0.3}
    return {"sensing": "joints", "kind": kind, "early": early, "row": row, "occlusion": occlusion, **known, **figures}


@pytest.fixture
def report():
    joints = {"n": 9000, "tracked": 0.97, "inferred": 0.03, "median_m": 0.0134, "p95_m": 0.04, "astray": 0.002}
    joints |= {"bias_m": 0.01, "drift_m": 0.011, "correlation": 0.97, "inferred_m": None}
    return {
        "schema": 1,
        "seed": 4,
        "sessions": [{"sensing": "joints", "layout": "rows", "seed": 4}],
        "versions": {"numpy": "2.0"},
        "config": to_plain(SessionConfig(seed=4)),
        "joints": [{"sensing": "joints", "joints": "arms", "row": "all", "occlusion": "all", **joints}],
        "detector": [
            detector_row("all"),
            detector_row("clap", recall=0.9, bias_s=-0.01),
            detector_row("start_forward", early=True),
            detector_row("start_forward", row="back", occlusion="hidden", n=7),
        ],
        "robot": [{"kind": "all", "n": 36, "delay_s": 0.321, "jitter_s": 0.03, "not_executed": 0.0278}],
    }


def test_figures_are_those_of_the_file(folder_of, report):
    page = read_page(write_report(folder_of("characterise.json", report)))
    rows = {row[0]: row[1:] for row in page.tables["Skeletons from joints: regular events"][1:]}
    assert rows["clap"] == ["100", "90.0 %", "100.0 %", "−0.010", "0.050", "0.300"]
    assert page.tables["Robot: from command to event"][1] == ["all", "36", "0.321", "0.030", "2.8 %"]
    # Lengths are given in centimetres, and what was not measured is a dash.
    joints = page.tables["Joints from joints"][1]
    assert joints[4:7] == ["1.3", "4.0", "0.20 %"]
    assert joints[-1] == "–"
    assert "bad" in page.styles["Skeletons from joints: regular events"][1]
    (details,) = page.tables["Skeletons from joints: regular events by row and occlusion"][1:]
    assert details[:4] == ["start forward", "back", "hidden", "7"]


def test_the_verdict_judges_recall_spread_and_delay(report):
    detectors, times, robot = verdict(report)
    assert "find nearly all events: 99.0 % of 100 events" in detectors
    assert "0.05 s (s.d.), which is small against the 0.25 s" in times
    assert "comes too late to be synchronous" in robot

    worse = copy.deepcopy(report)
    worse["detector"][0] |= {"recall": 0.7, "sd_s": 0.2}
    worse["robot"][0]["delay_s"] = 0.1
    detectors, times, robot = verdict(worse)
    assert "miss events or report false ones" in detectors
    assert "is not small" in times
    assert "can answer a dancer's event in time" in robot


def test_a_characterisation_without_a_robot(folder_of, report):
    page = read_page(write_report(folder_of("characterise.json", {**report, "robot": []})))
    assert "have no robot" in page.text
    assert len(verdict({**report, "robot": []})) == 2


def test_settings_of_its_own_are_mentioned(folder_of, report):
    assert "further settings" not in read_page(write_report(folder_of("characterise.json", report))).text
    report["config"]["robot"]["cruise_m_s"] = 0.3
    folder = folder_of("characterise.json", report)
    assert "further settings" in read_page(write_report(folder, overwrite=True)).text
