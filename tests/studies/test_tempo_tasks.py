"""Tasks that show people's pull towards their spontaneous tempo, and the command that reproduces them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sjasim.assets import tempo_studies as people
from sjasim.humans.timing.ashle import OscillatorParameters
from sjasim.reproduce import command
from sjasim.studies import tempo_tasks

QUIET = OscillatorParameters(noise=0.0)


def test_the_people_of_the_studies_are_complete():
    assert len(people.PACED_PERIODS_MS) == 20
    assert {len(changes) for changes in people.UNPACED_CHANGES_MS.values()} == {len(people.UNPACED_PERIODS_MS)} == {24}
    gaps = {kind: [abs(a - b) for a, b in pairs] for kind, pairs in people.DUET_PERIODS_MS.items()}
    assert {kind: len(own) for kind, own in gaps.items()} == {"matching": 10, "mismatching": 10}
    # The studies' criteria: less than 10 ms, and more than 100 ms.
    assert max(gaps["matching"]) < 10
    assert min(gaps["mismatching"]) >= 100


@pytest.mark.slow
def test_asynchronies_with_a_metronome_are_those_of_another_implementation():
    found = tempo_tasks.paced_asynchronies_ms(QUIET, np.random.default_rng(0)).mean(axis=0)
    # An implementation that finds taps as peaks of the oscillation, at the resolution of a step of 2 ms.
    assert found == pytest.approx([10.9, 5.0, -4.1, -8.5], abs=0.5)


def test_parts_of_a_duet_are_compared_tone_by_tone_after_the_best_shift():
    first = 0.4 * np.arange(20) + 4.0
    second = 0.4 * np.arange(40) + 2.82
    assert tempo_tasks.aligned_asynchronies_s(first, second) == pytest.approx(np.full(20, 0.02))


def test_pairs_with_matching_tempi_are_closer_than_others():
    rng = np.random.default_rng(0)
    near, far = (tempo_tasks.duet_asynchronies_ms(kind, QUIET, rng) for kind in ("matching", "mismatching"))
    assert near.shape == far.shape == (10, 4)
    assert near.mean() < 5.0 < 10.0 < far.mean()


@pytest.mark.slow
def test_the_command_prints_and_writes_every_value(tmp_path, capsys):
    command(["ashle", "--out", str(tmp_path / "out")])
    printed = capsys.readouterr().out
    report = json.loads((tmp_path / "out" / "reproduce.json").read_text())
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["reproduce.json"]
    assert len(report["rows"]) == 16
    assert report["study"] == "ashle"

    outside = {row["condition"] for row in report["rows"] if not row["inside"]}
    # What the model misses: see docs/second-studies.md.
    assert outside <= {"metronome 85 %", "alone, slow"}
    assert f"inside: {8 - ('metronome 85 %' in outside)} of 8 fitted" in printed
    for row in report["rows"]:
        assert row["low"] < row["mean"] < row["high"]
        assert row["inside"] == (row["low"] <= row["people"] <= row["high"])
