"""Folders of every kind that can be reported on."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.analysis.session_metrics import measures
from sjasim.analysis.study_summary import study_summary
from sjasim.record.session_folder import write

from ...analysis.synthetic_study import nested_study

DESIGN = {
    "groups": 9,
    "humans": ["paper-entrainment"],
    "order": "counterbalanced",
    "performance": "fresh",
    "missing": "keep",
    "seed": 5,
    "seeds": "evaluation",
    "session": {"fidelity": "timing", "dancers": 3},
}
"""A design as study.json holds it."""


def study_content(methods=("eca", "sia", "none"), **options):
    """Content of study.json of a synthetic study."""
    tables = nested_study(np.random.default_rng(3), methods=methods, **options)
    summary = study_summary(tables)
    return {"schema": 1, "design": DESIGN, "versions": {"numpy": "2.0"}, **summary}


@pytest.fixture(scope="session")
def paper_study():
    """Content of study.json with the published conditions; the robot is late by .6 s under SIA."""
    return study_content(effect_s=0.6)


@pytest.fixture
def folder_of(tmp_path):
    """A function that writes a JSON file to a folder of its own."""

    def write_content(name, content):
        folder = tmp_path / name.partition(".")[0]
        folder.mkdir(exist_ok=True)
        (folder / name).write_text(json.dumps(content, allow_nan=False), encoding="utf-8")
        return folder

    return write_content


@pytest.fixture
def session_of(tmp_path):
    """A function that writes a log as a session's folder."""

    def write_log(log):
        return write(log, tmp_path / "session", measures(log).as_dict(), recording=False, report=delay_report(log))

    return write_log
