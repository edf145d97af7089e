"""Claps from the hand ratio alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.config import DetectorConfig
from sjasim.sensors.events.clap_detection import clap_time_s, initial_clap_states, may_be_clapping
from sjasim.sensors.events.thresholds import REFERENCE_RATE_HZ, threshold_row

CLOSING = [1.2, 1.1, 0.9, 0.65, 0.45, 0.2, 0.1, 0.08, 0.08]
THRESHOLDS = threshold_row(DetectorConfig(), REFERENCE_RATE_HZ).view(np.recarray)[0]
LONGEST_INFERRED_S = 0.1


def clap_times(ratios: list[float], tracked: list[bool]) -> list[float]:
    """Times of the claps in frames with these hand ratios [s]."""
    hands = initial_clap_states(1).view(np.recarray)[0]
    times_s = [
        clap_time_s(hands, tick / REFERENCE_RATE_HZ, ratio, known, LONGEST_INFERRED_S, THRESHOLDS)
        for tick, (ratio, known) in enumerate(zip(ratios, tracked, strict=True))
    ]
    return [t_s for t_s in times_s if not math.isnan(t_s)]


@pytest.mark.parametrize(("first_tracked", "count"), [(0, 1), (2, 1), (3, 1), (4, 1), (5, 0), (7, 0)])
def test_hands_that_come_into_sight_before_they_touch_clap_once(first_tracked: int, count: int):
    assert len(clap_times(CLOSING, [tick >= first_tracked for tick in range(len(CLOSING))])) == count


def test_hands_that_were_not_known_to_be_apart_do_not_clap():
    unknown = [math.nan] * 3 + CLOSING[3:]
    assert clap_times(unknown, [tick >= 3 for tick in range(len(unknown))]) == []


@pytest.mark.parametrize(("last_tracked", "count"), [(0.65, 1), (0.95, 1), (1.05, 0), (1.2, 0)])
def test_occluded_hands_clap_if_they_were_near_when_last_tracked(last_tracked: float, count: int):
    ratios = [1.2, 1.1, last_tracked, 0.1, 0.4]
    found = clap_times(ratios, [True, True, True, False, False])
    assert found == pytest.approx([3 / REFERENCE_RATE_HZ] * count)


def test_a_clap_has_the_time_of_the_minimum():
    assert clap_times([1.2, 0.9, 0.5, 0.35, 0.5, 0.9], [True] * 6) == pytest.approx([3 / REFERENCE_RATE_HZ])


def test_hands_that_stay_apart_or_come_no_closer_than_the_threshold_do_not_clap():
    assert clap_times([1.2, 0.9, 0.7, 0.61, 0.7, 0.9], [True] * 6) == []
    assert len(clap_times([1.2, 0.9, 0.7, 0.59, 0.7, 0.9], [True] * 6)) == 1


@pytest.mark.parametrize(("ratio", "clapping"), [(0.95, True), (1.05, False)])
def test_near_hands_may_be_clapping_for_the_refractory_time(ratio: float, clapping: bool):
    hands = initial_clap_states(1).view(np.recarray)[0]
    clap_time_s(hands, 0.0, ratio, True, LONGEST_INFERRED_S, THRESHOLDS)
    assert may_be_clapping(hands, 0.9, THRESHOLDS) is clapping
    assert not may_be_clapping(hands, 1.0, THRESHOLDS)
