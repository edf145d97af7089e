"""The command ``power``."""

import json

import pytest

from sjasim.core.errors import RecordError
from sjasim.power import command

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


def test_a_folder_that_holds_other_files_is_refused_before_anything_is_simulated(tmp_path, monkeypatch):
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    monkeypatch.setattr("sjasim.studies.power.run_study", None)
    with pytest.raises(RecordError):
        command([*SMALL, "--out", str(tmp_path)])
