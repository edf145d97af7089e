"""Accuracy figures of detectors and robot from made-up outcomes."""

import math

import numpy as np
import pytest

from sjasim.analysis.accuracy import detection_accuracy
from sjasim.analysis.accuracy.detection_accuracy import ALL, BANDS, Execution, Outcome
from sjasim.core import Kind

NAN = math.nan


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
