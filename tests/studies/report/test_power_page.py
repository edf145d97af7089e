"""The page of a power analysis: how many groups are needed, and the curve."""

import copy

import pytest

from sjasim.studies.report.folders import write_report

from .html_page import read_page

POWERS = ((6, 0.2), (12, 0.5), (18, 0.81))

CONTENT = {
    "schema": 1,
    "design": {
        "methods": ["eca", "sia"], "measure": "gsi", "effect": "simulated", "target": 0.8, "alpha": 0.05,
        "max_groups": 18, "pool": 100, "humans": "paper-entrainment", "fidelity": "timing", "seed": 3,
    },
    "study": None,
    "test": "sign-flip permutation of group differences",
    "effect": {"source": "simulated", "difference": 0.068, "sd": 0.116, "d_z": 0.59},
    "pool": 100,
    "rows": [{"groups": n, "power": power, "low": power - 0.1, "high": power + 0.1} for n, power in POWERS],
    "groups_needed": 18,
    "groups_needed_low": 13,
    "groups_needed_high": 22,
    "versions": {"numpy": "2.0"},
}  # fmt: skip


@pytest.fixture
def page(folder_of):
    return read_page(write_report(folder_of("power.json", CONTENT)))


def test_the_verdict_says_how_many_groups_are_needed(page):
    assert "18 groups are needed (95 % interval 13 to 22) to find the difference between ECA and SIA" in page.text
    assert "That difference is +0.068 in the group synchronisation index (published rule) (as simulated)" in page.text


def test_the_curve_is_that_of_the_file(page):
    rows = page.tables["Power by number of groups"][1:]
    assert rows == [
        ["6", "20.0 %", "10.0 % to 30.0 %"],
        ["12", "50.0 %", "40.0 % to 60.0 %"],
        ["18", "81.0 %", "71.0 % to 91.0 %"],
    ]
    ((title, described, _),) = page.drawings
    assert title == "Power by number of groups"
    assert described == "6 groups: 20 %; 12 groups: 50 %; 18 groups: 81 %"


def test_too_few_groups_are_named(folder_of):
    content = copy.deepcopy(CONTENT) | {"groups_needed": None}
    page = read_page(write_report(folder_of("power.json", content)))
    assert "18 groups are not enough to find the difference" in page.text


def test_the_command_line_has_the_design(page):
    assert "sjasim power --methods eca sia --measure gsi --effect simulated --target 0.8" in page.text
