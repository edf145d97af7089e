"""The report card: its arithmetic on made-up outcomes, one tiny run, bad input."""

import json
import math

import numpy as np
import pytest

from sjasim import characterise
from sjasim.analysis.accuracy import detection_accuracy
from sjasim.analysis.accuracy.detection_accuracy import ALL, BANDS, Execution, Outcome
from sjasim.commands.options import main
from sjasim.config import SceneConfig, SessionConfig
from sjasim.core import Kind

NAN = math.nan
TINY = ("--iterations", "1", "--dance.no-rehearsal", "--sessions", "1", "--layouts", "rows", "--sensings", "joints")


def outcome(true=True, logged=True, error_s=NAN, band="visible", row="front"):
    return Outcome("joints", Kind.CLAP, False, row, band, true, logged, error_s)


FOUND = [
    outcome(error_s=0.1), outcome(error_s=0.2), outcome(error_s=0.3, row="back"),
    outcome(logged=False, band="hidden", row="back"), outcome(true=False),
]  # fmt: skip


def test_figures_by_hand():
    (row,) = [
        row for row in detection_accuracy.detector_rows(FOUND)
        if (row["kind"], row["row"], row["occlusion"]) == ("clap", ALL, ALL)
    ]  # fmt: skip
    assert (row["n"], row["logged"], row["recall"], row["precision"]) == (4, 4, 0.75, 0.75)
    assert row["bias_s"] == pytest.approx(0.2)
    assert row["sd_s"] == pytest.approx(np.std([0.1, 0.2, 0.3]))


def test_rows_and_bands_sum_up():
    rows = detection_accuracy.detector_rows(FOUND)
    parts = {(row["row"], row["occlusion"]): row["n"] for row in rows if row["kind"] == "clap"}
    assert parts[ALL, ALL] == parts["front", ALL] + parts["back", ALL] == 4
    assert parts[ALL, ALL] == sum(parts.get((ALL, band), 0) for band in BANDS)


def test_distributions_tell_misses_errors_and_inventions():
    rows = {row["occlusion"]: row for row in detection_accuracy.distributions(FOUND, {"joints": 2.0})}
    assert rows["hidden"]["miss"] == 1.0
    assert rows["hidden"]["error_s"] is None
    assert rows["visible"]["miss"] == 0.0
    assert rows["visible"]["error_s"][0] == 0.1
    assert rows["visible"]["error_s"][-1] == 0.3
    assert rows[ALL]["false_per_minute"] == 0.5


def test_robot_rows_by_hand():
    rows = detection_accuracy.robot_rows(
        [Execution(Kind.TURN, 0.3), Execution(Kind.TURN, 0.5), Execution(Kind.TURN, NAN)]
    )
    assert [row["kind"] for row in rows] == ["turn", ALL]
    for row in rows:
        assert (row["delay_s"], row["jitter_s"]) == pytest.approx((0.4, 0.1))
        assert row["not_executed"] == pytest.approx(1 / 3)


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
    page = (folder / "characterise.md").read_text()
    assert "| start_forward" in page
    assert "| astray" in page
    assert main(characterise.command, [*TINY, "--out", str(folder)]) == 2
    said = capsys.readouterr().err
    assert "--overwrite" in said
    assert str(folder) in said


def test_own_slots_are_those_of_the_custom_layout():
    common = SessionConfig(scene=SceneConfig(slots_m=((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))))
    designs = characterise.Options(common, sessions=2, layouts=("rows", "custom"), sensings=("joints",)).designs()
    assert [(one.layout, one.seed, len(one.scene.slots_m)) for one in designs] == [
        ("rows", 0, 0), ("rows", 1, 0), ("custom", 0, 4), ("custom", 1, 4),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--sessions", "0"), "sessions"),
        (("--layouts", "circle"), "layout"),
        (("--sensings", "sonar"), "sonar"),
        (("--sensings", "joints", "joints"), "sensings"),
        (("--out", "/proc/nowhere/x"), "cannot be written"),
        (("--sessions", "many"), "many"),
        (("--sensing", "joints"), "here --sensings names those of all sessions"),
        (("--sensing=depth",), "--sensings"),
        (("--layout", "rows"), "here --layouts names those of all sessions"),
        (("--scene.slots-m", "0", "1", "1", "0"), "only with layout custom"),
    ],
)
def test_bad_input_is_one_line(capsys, arguments, words):
    assert main(characterise.command, list(arguments)) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
