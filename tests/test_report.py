"""The command `report`: a page from a folder, and bad input."""

import json

import pytest

from sjasim import report
from sjasim.commands.main import main

ROW = {"value": "gsi_mean", "method": "eca", "paper": 0.41, "mean": 0.6, "low": 0.5, "high": 0.7}
ROW |= {"inside": False, "role": "fitted"}
CONTENT = {"schema": 1, "preset": "musicians", "studies": 20, "findings": [], "rows": [ROW]}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "reproduce.json").write_text(json.dumps(CONTENT), encoding="utf-8")
    return tmp_path


def test_the_page_is_written_and_its_path_printed(folder, capsys):
    assert main(report.command, [str(folder)]) == 0
    heard = capsys.readouterr()
    assert heard.out == f"{folder / 'report.html'}\n"
    assert "0 of 1 published values lie inside" in (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "DIR is missing"),
        (("{here}/nowhere",), "there is no such folder"),
        (("{here}/empty",), "it has none of study.json"),
        (("{here}", "--out", "{here}/nowhere/page.html"), "cannot be written"),
        (("{here}", "--out", "{here}/old.html"), "--overwrite"),
        (("{here}", "--out", "{here}/reproduce.json", "--overwrite"), "a file whose name ends in .html"),
    ],
)
def test_bad_input_is_one_line(folder, capsys, arguments, words):
    (folder / "empty").mkdir()
    (folder / "old.html").write_text("old", encoding="utf-8")
    before = (folder / "reproduce.json").read_bytes()
    assert main(report.command, [word.format(here=folder) for word in arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert (folder / "reproduce.json").read_bytes() == before
