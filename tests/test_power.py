"""The command ``power``."""

import json

import pytest

from sjasim.core.errors import RecordError
from sjasim.power import command
from sjasim.studies.study_design import StudyDesign
from sjasim.studies.study_execution import run_study

SMALL = ["--pool", "16", "--max-groups", "7", "--jobs", "1"]


def test_the_table_is_printed_and_the_report_written(tmp_path, capsys):
    folder = tmp_path / "power"
    command([*SMALL, "--measure", "ta_mean_s", "--effect", "paper", "--out", str(folder)])
    printed = capsys.readouterr()
    assert "ta_mean_s: sia minus eca is -0.160 (paper)" in printed.out
    assert "groups needed" in printed.out
    report = json.loads((folder / "power.json").read_text(encoding="utf-8"))
    assert report["design"]["measure"] == "ta_mean_s"


def test_json_is_all_that_stands_on_stdout(capsys):
    command([*SMALL, "--json"])
    report = json.loads(capsys.readouterr().out)
    assert [row["groups"] for row in report["rows"]] == [6, 7]


def test_an_earlier_report_is_refused_before_anything_is_simulated(tmp_path, monkeypatch):
    (tmp_path / "power.json").write_text("mine", encoding="utf-8")
    monkeypatch.setattr("sjasim.studies.power.run_study", None)
    with pytest.raises(RecordError, match="--overwrite"):
        command([*SMALL, "--out", str(tmp_path)])
    with pytest.raises(RecordError):
        command([*SMALL, "--out", str(tmp_path / "power.json")])
    assert (tmp_path / "power.json").read_text(encoding="utf-8") == "mine"


def test_the_report_is_written_beside_a_study(tmp_path, capsys):
    folder = tmp_path / "study"
    run_study(StudyDesign(groups=8, humans_only=False), folder, jobs=1)
    before = {path.name for path in folder.iterdir()}
    command(["--study", str(folder), "--pool", "8", "--max-groups", "7", "--out", str(folder)])
    assert {path.name for path in folder.iterdir()} == before | {"power.json"}
    assert "7 " in capsys.readouterr().out
