"""Tests of every preset's statistics against the values that it cites."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sjasim.choreography.timetable import Timetable
from sjasim.core.tempo import TempoMap
from sjasim.humans.timing.ensemble import EnsembleTiming
from sjasim.humans.timing.parameters import preset, preset_names

from ..dancing import dance
from .test_ensemble import deviations, draw, times

ROOT = Path(__file__).resolve().parents[3]


def performed(name: str, count: int = 600, dancers: int = 3) -> np.ndarray:
    """(N, D, E) lateness of dancers without lapses [s]."""
    return deviations(replace(preset(name), lapse=0.0, late_s=()), count, dancers)


def asynchrony_correlation(found: np.ndarray) -> float:
    """Lag-1 correlation of the dancers' asynchronies with their mean."""
    apart = found - found.mean(axis=1, keepdims=True)
    return float(np.corrcoef(apart[:, :, 3:-1].ravel(), apart[:, :, 4:].ravel())[0, 1])


def interval_correlation(found: np.ndarray) -> float:
    """Lag-1 correlation of a dancer's own intervals; negative where errors are corrected."""
    intervals = np.diff(found, axis=2)
    intervals = intervals - intervals.mean(axis=(0, 1))
    return float(np.corrcoef(intervals[:, :, :-1].ravel(), intervals[:, :, 1:].ravel())[0, 1])


@pytest.mark.parametrize(
    ("name", "least_s", "most_s", "follows", "common_s"),
    [
        # rasch1979; full correction (wing2014) of motor noise too: the correlation is -M^2 / (T^2 + 2 M^2) = -0.16.
        ("musicians", 0.030, 0.050, (-0.2, -0.12), 0.02),
        ("leader", 0.030, 0.055, (-0.1, 0.35), 0.02),
        ("tempo-change", 0.030, 0.050, (-0.2, -0.12), 0.02),
        ("novices", 0.060, 0.120, (0.3, 0.6), 0.06),  # less than half corrected: scheurich2018, size assumed
        ("paper-entrainment", 0.20, 0.40, (0.1, 0.4), 0.594),  # fitted to iqbal2016
        ("paper-warmup", 0.20, 0.40, (0.1, 0.4), 0.568),
        ("one-late", 0.04, 0.08, (0.05, 0.4), 0.05),
    ],
)
def test_a_preset_has_the_statistics_that_it_cites(name, least_s, most_s, follows, common_s):
    found = performed(name)

    gaps = np.stack([found[:, 0] - found[:, 1], found[:, 1] - found[:, 2], found[:, 2] - found[:, 0]])
    assert least_s <= gaps[:, :, 3:].std() <= most_s
    assert follows[0] <= asynchrony_correlation(found) <= follows[1]
    assert interval_correlation(found) < -0.1
    group = found.mean(axis=1)
    assert group[:, 0].std() == pytest.approx(np.hypot(common_s, gaps[:, :, 0].std() / np.sqrt(6)), rel=0.2)


def test_every_noisy_preset_has_its_statistics_tested():
    tested = test_a_preset_has_the_statistics_that_it_cites.pytestmark[0].args[1]
    assert {row[0] for row in tested} == set(preset_names()) - {"metronomic"}


def test_novices_are_noisier_than_musicians():
    assert performed("novices").std(axis=1).mean() > 1.5 * performed("musicians").std(axis=1).mean()


def test_the_leader_corrects_less_than_the_others():
    found = performed("leader", 1500)

    slopes = []
    for dancer in range(3):
        lead = found[:, dancer] - np.delete(found, dancer, axis=1).mean(axis=1)
        slopes.append(np.polyfit(lead[:, :-1].ravel(), np.diff(found[:, dancer], axis=1).ravel(), 1)[0])
    assert slopes[0] > 0.6 * max(slopes[1:])
    assert max(slopes[1:]) < -0.4


def slowing(anticipation: float) -> np.ndarray:
    """Mean lateness of the group at every event of a ritardando."""
    p = replace(preset("tempo-change"), lapse=0.0, common_s=0.0, anticipation=anticipation)
    music = TempoMap.changing(60.0, ((0.0, 1.0), (40.0, 0.6)), ())
    table = Timetable(dance(), music, 4.0, 1, 1)
    nominal = np.array([table.time_s(1, step.beat) for step in dance().steps()])

    rows = []
    for seed in range(150):
        model = EnsembleTiming(p, table, 3, np.random.default_rng(seed), np.random.default_rng(900 + seed))
        rows += [np.array(times(own)) - nominal for own in draw(model, 1, None, np.zeros(3))]
    return np.mean(rows, axis=0)


def test_dancers_run_ahead_of_a_ritardando_by_the_share_they_do_not_foresee():
    none, usual, whole = (slowing(share)[2:] for share in (0.0, 0.7, 1.0))
    assert none.max() < -0.1
    assert usual == pytest.approx(0.3 * none, abs=0.01)
    assert whole == pytest.approx(0.0, abs=0.01)


def test_sources_that_presets_cite_are_in_the_bibliography():
    known = re.findall(r"^@\w+\{(\w+),", (ROOT / "docs" / "references.bib").read_text(encoding="utf-8"), re.M)
    for name in preset_names():
        cited = re.findall(r"\b[a-z]+(?:19|20)\d\d\b", preset(name).about)
        assert set(cited) <= set(known), name
        assert cited or "assumed" in preset(name).about or name == "metronomic"
