"""The report of a reproduced study, and bad input of its command."""

from __future__ import annotations

import json

import pytest

from sjasim.commands.main import main
from sjasim.reproduce import command
from sjasim.studies.reproduction_report import ReproducedValue, Reproduction, summary


def value(people: float, role="fitted") -> ReproducedValue:
    return ReproducedValue("asynchrony [ms]", "slow", people, 10.0, 8.0, 12.0, role, "somebody2020")


ROWS = (value(8.0), value(12.5), value(11.0, "held out"))


def test_a_value_is_inside_its_interval_ends_included():
    assert [row.inside for row in ROWS] == [True, False, True]
    assert summary(ROWS) == "inside: 1 of 2 fitted, 1 of 1 held out values"


def test_the_printed_report_fits_a_terminal_and_tells_fitted_from_held_out(capsys):
    Reproduction("somebody's", {"seed": 1}, ROWS).print(False)
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    titles = [line.strip() for line in lines if line.strip().endswith("somebody's")]
    assert titles == ["fitted values of somebody's", "held out values of somebody's"]


def test_json_is_the_same_on_stdout_and_in_the_folder(tmp_path, capsys):
    found = Reproduction("somebody's", {"seed": 1}, ROWS, {"players": [3]})
    found.print(True)
    found.save(tmp_path / "out", False)
    printed = capsys.readouterr().out
    assert printed == (tmp_path / "out" / "reproduce.json").read_text()

    content = json.loads(printed)
    assert content["players"] == [3]
    assert content["rows"][1] == {
        "value": "asynchrony [ms]",
        "condition": "slow",
        "people": 12.5,
        "mean": 10.0,
        "low": 8.0,
        "high": 12.0,
        "role": "fitted",
        "source": "somebody2020",
        "inside": False,
    }


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["choir"], "choir"),
        (["ashle", "--studies", "3"], "studies = 3 is not allowed"),
        (["ashle", "--humans", "musicians"], "only with the study paper"),
        (["--humans", "nobody", "--studies", "20"], "nobody"),
        (["--fidelity", "exact"], "timing"),
    ],
)
def test_bad_input_gives_one_line_and_2(arguments, says, capsys):
    assert main(command, arguments) == 2
    heard = capsys.readouterr()
    assert heard.out == ""
    assert heard.err.count("\n") == 1
    assert says in heard.err
