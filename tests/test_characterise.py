"""The command `characterise`: one small run, and bad input."""

import json

import pytest

from sjasim import characterise
from sjasim.analysis.accuracy.detection_accuracy import ALL
from sjasim.commands.main import main

TINY = ("--iterations", "1", "--dance.no-rehearsal", "--sessions", "1", "--layouts", "rows", "--sensings", "joints")


def test_a_tiny_run_leaves_numbers_and_a_page(tmp_path, capsys):
    folder = tmp_path / "card"
    assert main(characterise.command, [*TINY, "--humans", "metronomic", "--out", str(folder), "--json"]) == 0
    card = json.loads((folder / "characterise.json").read_text())
    assert json.loads(capsys.readouterr().out) == card
    whole = [row for row in card["detector"] if not row["early"] and (row["row"], row["occlusion"]) == (ALL, ALL)]
    by_kind = {row["kind"]: row for row in whole}
    assert by_kind["clap"]["n"] == 3
    assert by_kind[ALL]["n"] == 27
    assert by_kind[ALL]["recall"] >= 0.9
    assert 0.0 < by_kind["start_forward"]["bias_s"] < 0.4
    assert {row["kind"] for row in card["robot"]} >= {"start_forward", ALL}
    assert len(card["distributions"][0]["error_s"]) == len(card["quantiles"])
    (seen,) = [row for row in card["joints"] if (row["joints"], row["row"], row["occlusion"]) == ("all", "all", "all")]
    assert seen["n"] > 25 * 3 * 30 * 15
    assert 0.7 < seen["tracked"] <= 1.0
    assert 0.005 < seen["median_m"] < 0.03
    assert seen["astray"] < 0.001
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "The detectors find nearly all events" in page
    assert f"{100 * by_kind[ALL]['recall']:.1f} %" in page
    assert main(characterise.command, [*TINY, "--out", str(folder)]) == 2
    said = capsys.readouterr().err
    assert "--overwrite" in said
    assert str(folder) in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--sessions", "0"), "sessions"),
        (("--layouts", "circle"), "layout"),
        (("--sensings", "sonar"), "sonar"),
        (("--sensings", "joints", "joints"), "sensings"),
        (("--out", "/proc/nowhere/x"), "cannot be written"),
        (("--sessions", "many"), "many"),
        (("--sensing", "joints"), "perhaps you meant --sensings"),
        (("--config", "{here}/common.toml"), "here --sensings names those of all sessions"),
        (("--layout", "rows"), "perhaps you meant --layouts"),
        (("--scene.slots-m", "0", "1", "1", "0"), "only with layout custom"),
    ],
)
def test_bad_input_is_one_line(capsys, tmp_path, arguments, words):
    (tmp_path / "common.toml").write_text('sensing = "joints"', encoding="utf-8")
    assert main(characterise.command, [word.format(here=tmp_path) for word in arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
