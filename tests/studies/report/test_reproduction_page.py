"""The page of a reproduction: one row per published value, and the verdict that follows from them."""

import pytest

from sjasim.studies.report.folders import write_report

from .html_page import read_page

KEYS = ("value", "method", "paper", "mean", "low", "high", "inside", "role")

ROWS = [
    dict(zip(KEYS, row, strict=True))
    for row in (
        ("gsi_mean", "sia", 0.4556, 0.441, 0.39, 0.49, True, "fitted"),
        ("gsi_rise", "sia", 0.158, 0.072, 0.005, 0.146, False, "held_out"),
        ("iterations_won", None, 22, 21.5, 14, 28, True, "held_out"),
        ("far", "", 5.0, 0.1, 0.0, 0.2, False, "held_out"),
    )
]

ROWS[0]["meaning"] = "mean index"

CONTENT = {
    "schema": 1,
    "study": "paper",
    "preset": "paper-entrainment",
    "studies": 200,
    "seed": 3,
    "rows": ROWS,
    "findings": [
        {"title": "A random dancer does as well", "text": "Difference:", "mean": 0.01, "low": -0.02, "high": 0.04},
        "Plain.",
    ],
}


@pytest.fixture
def page(folder_of):
    return read_page(write_report(folder_of("reproduce.json", CONTENT)))


def test_every_value_has_a_row(page):
    rows = page.tables["Published and simulated values"][1:]
    assert [row[:4] for row in rows] == [
        ["mean index, SIA", "0.456", "0.441", "[0.390, 0.490]"],
        ["gsi rise, SIA", "0.158", "0.072", "[0.005, 0.146]"],
        ["iterations won", "22", "21.5", "[14.0, 28.0]"],
        ["far", "5", "0.100", "[0.00, 0.20]"],
    ]
    assert [row[5:] for row in rows] == [
        ["inside", "fitted"],
        ["outside", "held out"],
        ["inside", "held out"],
        ["outside", "held out"],
    ]


def test_the_verdict_counts_and_names_what_is_outside(page):
    assert "2 of 4 published values lie inside the 95 % interval of 200 simulated studies" in page.text
    assert "Outside: gsi rise, SIA; far. 1 of 3 values that were not used to fit the people lie inside." in page.text


def test_each_row_shows_where_the_published_value_lies(page):
    assert [description for title, description, _ in page.drawings] == [
        "The published value lies inside.",
        "The published value lies outside.",
        "The published value lies inside.",
        "The published value lies outside.",
    ]


def test_findings_have_their_intervals(page):
    assert "Difference: 0.010 [−0.020, 0.040]" in page.text
    assert "Plain." in page.text


def test_without_findings_this_is_said(folder_of):
    page = read_page(write_report(folder_of("reproduce.json", {**CONTENT, "findings": []})))
    assert "No findings were computed." in page.text


def test_another_study_names_conditions_and_what_people_did(folder_of):
    row = {"value": "asynchrony [ms]", "condition": "metronome 70 %", "people": 10.5, "mean": 10.9, "low": 8.6}
    row |= {"high": 13.1, "role": "held out", "source": "scheurich2018", "inside": True}
    content = {"schema": 1, "study": "ashle", "versions": {}, "settings": {"studies": 100, "seed": 2}, "rows": [row]}
    page = read_page(write_report(folder_of("reproduce.json", content)))
    (shown,) = page.tables["Published and simulated values"][1:]
    assert shown[:4] == ["asynchrony [ms], metronome 70 %", "10.5", "10.9", "[8.6, 13.1]"]
    assert shown[5:] == ["inside", "held out"]
    assert "sjasim reproduce ashle --studies 100 --seed 2 --out DIR" in page.text
    assert "Iqbal" not in page.text.partition("What reviewers will ask")[0]
