"""When hands have met, from their ratio alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.config import DetectorConfig
from sjasim.sensors.events.clap_detection import met_s, unseen_hands
from sjasim.sensors.events.thresholds import BASE_HZ, rules

CLOSING = [1.2, 1.1, 0.9, 0.65, 0.45, 0.2, 0.1, 0.08, 0.08]


def claps(ratios: list[float], tracked: list[bool]) -> int:
    """How many claps these frames show."""
    hands, rule = unseen_hands(1), rules(DetectorConfig(), BASE_HZ)
    frames = zip(ratios, tracked, strict=True)
    found = [met_s(hands[0], tick / BASE_HZ, ratio, sure, 0.1, rule[0]) for tick, (ratio, sure) in enumerate(frames)]
    return int(np.isfinite(found).sum())


@pytest.mark.parametrize(("sight_from", "count"), [(0, 1), (2, 1), (3, 1), (4, 1), (5, 0), (7, 0)])
def test_hands_that_come_into_sight_on_their_way_clap_and_hands_that_touch_already_do_not(sight_from: int, count: int):
    assert claps(CLOSING, [tick >= sight_from for tick in range(len(CLOSING))]) == count


def test_of_hands_that_nobody_thought_apart_a_glimpse_on_their_way_is_no_clap():
    unknown = [math.nan] * 3 + CLOSING[3:]
    assert claps(unknown, [tick >= 3 for tick in range(len(unknown))]) == 0
