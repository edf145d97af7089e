"""The string quartet: reading a laboratory's folder, alignment, recovery from simulated quartets, and the command."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sjasim.commands.main import main
from sjasim.core.errors import RecordError
from sjasim.reproduce import command
from sjasim.studies.quartet import align, intervals_of, measures, read_onsets, regress_ensemble, simulated_measures

from ..analysis.calibration.test_phase_correction_regression import GAINS, played

PLAYERS = ("VA", "VC", "VN1", "VN2")


def write_folder(folder, takes=3, leader="VA", condition="NR", events=200, missing=0.05):
    """Write takes of quartets that play quavers with rests, of which some onsets are missing."""
    folder.mkdir(exist_ok=True)
    rng = np.random.default_rng(1)
    for number in range(1, takes + 1):
        onsets = 0.3 + played(rng, events)
        onsets += np.repeat(1.5 * np.arange(events // 20), 20)[:, None]
        for index, player in enumerate(PLAYERS):
            kept = onsets[rng.random(events) > missing, index]
            text = "\n".join(f"{time:.6f}" for time in np.sort(kept))
            (folder / f"{player}-Q-JH-{leader}-{condition}-{number}.txt").write_text(f"{text}\n")
    (folder / "README.txt").write_text("not onsets\n")
    return folder


def test_takes_are_found_by_leader_and_condition_and_other_files_are_ignored(tmp_path):
    folder = write_folder(tmp_path / "data", takes=2, events=40)
    write_folder(folder, takes=1, leader="VN2", condition="SP", events=40)
    found = read_onsets(folder)
    assert {key: sorted(takes) for key, takes in found.items()} == {("VA", "NR"): ["1", "2"], ("VN2", "SP"): ["1"]}
    assert sorted(found["VA", "NR"]["2"]) == list(PLAYERS)


def test_chords_are_found_again_although_onsets_are_missing(tmp_path):
    takes = read_onsets(write_folder(tmp_path / "data", takes=1))["VA", "NR"]
    take = align([takes["1"][player] for player in PLAYERS])
    assert abs(len(take.onsets_s) - 200) <= 4
    # A steady interval needs eight onsets, and there is none over the rest after every 20 notes.
    assert len(take.steady) == pytest.approx(190 * 0.95**8, abs=25)
    assert (np.diff(take.onsets_s, axis=0)[take.steady] < 0.4).all()


def test_measures_of_a_simulated_quartet_are_those_of_its_parameters(tmp_path):
    takes = read_onsets(write_folder(tmp_path / "data", takes=8, missing=0.0))["VA", "NR"]
    aligned = [align([onsets[player] for player in PLAYERS]) for onsets in takes.values()]
    fit = regress_ensemble([intervals_of(take) for take in aligned])
    found = measures(aligned, fit, leader=0)
    assert found["others to leader"] == pytest.approx(GAINS[1:, 0].mean(), abs=0.06)
    assert found["leader to others"] == pytest.approx(GAINS[0, 1:].mean(), abs=0.06)
    assert found["mean gain"] == pytest.approx(GAINS[~np.eye(4, dtype=bool)].mean(), abs=0.03)
    assert found["timekeeper [ms]"] == pytest.approx(12.0, rel=0.15)

    simulated = simulated_measures(aligned, fit, 0, 20, np.random.default_rng(0))
    for name, value in found.items():
        assert simulated[name].shape == (20,)
        assert simulated[name].mean() == pytest.approx(value, rel=0.25, abs=0.02), name
    assert simulated["pairwise s.d. [ms]"].std() > 0.0


def test_the_command_writes_every_condition(tmp_path, capsys):
    folder = write_folder(tmp_path / "data", takes=3)
    command(["quartet", "--data", str(folder), "--studies", "20", "--out", str(tmp_path / "out")])
    report = json.loads((tmp_path / "out" / "reproduce.json").read_text())
    assert "inside: " in capsys.readouterr().out
    assert {row["condition"] for row in report["rows"]} == {"VA leads, NR"}
    assert len(report["rows"]) == 8

    condition = report["conditions"][0]
    assert condition["players"] == list(PLAYERS)
    assert np.array(condition["gains"]).shape == (4, 4)
    assert condition["takes"] == ["1", "2", "3"]


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda folder: [path.unlink() for path in folder.glob("*-Q-*")], "has no file named PLAYER-Q-JH"),
        (lambda folder: (folder / "VC-Q-JH-VA-NR-1.txt").unlink(), "take 1 of NR, led by VA, has no file of VC"),
        (lambda folder: [path.unlink() for path in folder.glob("VA-*")], "VA leads NR, but has no file there"),
        (lambda folder: (folder / "VC-Q-JH-VA-NR-1.txt").write_text("0.1\n\nabc\n"), "line 3: 'abc' is not a time"),
        (lambda folder: (folder / "VC-Q-JH-VA-NR-1.txt").write_text("\n"), "has no onsets"),
        (lambda folder: (folder / "VC-Q-JH-VA-NR-1.txt").write_bytes(b"\xff\xfe"), "cannot be read"),
    ],
)
def test_a_folder_that_cannot_be_used_is_refused_in_one_line(tmp_path, damage, says):
    folder = write_folder(tmp_path / "data", takes=2, events=40)
    damage(folder)
    with pytest.raises(RecordError, match=says) as refused:
        read_onsets(folder)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["quartet"], "data = None is not allowed: the folder with the onsets of the quartet"),
        (["quartet", "--data", "nowhere"], "nowhere is not a folder of onset files"),
        (["ashle", "--data", "."], "only with the study quartet"),
    ],
)
def test_wrong_arguments_are_refused(arguments, says, capsys):
    assert main(command, arguments) == 2
    assert says in capsys.readouterr().err


def test_too_few_notes_are_refused(tmp_path, capsys):
    folder = write_folder(tmp_path / "data", takes=1, events=20)
    assert main(command, ["quartet", "--data", str(folder)]) == 2
    assert "too little to fit" in capsys.readouterr().err
