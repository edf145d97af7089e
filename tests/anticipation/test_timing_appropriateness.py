"""Clusters, ideal times and timing appropriateness by hand."""

import numpy as np
import pytest

from sjasim.anticipation.timing_appropriateness import (
    ideal_times,
    lateness,
    main_cluster,
    match_to_steps,
)
from sjasim.choreography.paper import paper
from sjasim.core import Kind

STEPS = paper().steps()
EXPECTED = np.array([step.beat * 60 / 118 for step in STEPS])
NAN = np.nan


def test_every_event_finds_its_occurrence_in_any_order():
    kinds = [step.kind for step in STEPS]
    found = match_to_steps(EXPECTED[::-1] + 0.3, kinds[::-1], STEPS, EXPECTED)
    assert found == pytest.approx(EXPECTED + 0.3)


def test_a_missing_first_occurrence_does_not_shift_the_second():
    found = match_to_steps([EXPECTED[4] - 0.9], [Kind.START_FORWARD], STEPS, EXPECTED)
    assert np.isnan(found[0])
    assert found[4] == pytest.approx(EXPECTED[4] - 0.9)


def test_of_two_claims_the_nearer_counts_and_unknown_kinds_do_not():
    found = match_to_steps([0.9, 0.1, 5.0], [Kind.START_FORWARD] * 2 + [Kind.TURN], STEPS[:2], EXPECTED[:2])
    assert found[0] == pytest.approx(0.1)
    assert np.isnan(found[1])


def test_a_turn_is_the_claps_occurrence():
    assert match_to_steps([16.5], [Kind.TURN], STEPS, EXPECTED)[8] == 16.5


@pytest.mark.parametrize(
    ("times", "members"),
    [
        ([0.0, 1.0, 2.0], [True, True, True]),  # linked through the middle one
        ([0.0, 1.5, 3.1], [True, True, False]),  # a gap of exactly epsilon still links
        ([5.0, NAN, 0.0], [False, False, True]),  # two singletons: the earlier
        ([0.0, 9.0, 9.5], [False, True, True]),
        ([NAN, NAN], [False, False]),
        ([], []),
    ],
)
def test_main_cluster(times, members):
    assert main_cluster(np.array(times), 1.5).tolist() == members


def test_ideal_is_the_mean_of_those_together():
    dancers = np.array([[1.0, 4.0, NAN], [1.2, NAN, NAN], [9.0, NAN, NAN]])
    assert ideal_times(dancers) == pytest.approx([1.1, 4.0, NAN], nan_ok=True)
    assert ideal_times(dancers, min_members=2) == pytest.approx([1.1, NAN, NAN], nan_ok=True)
    robot = np.array([0.6, NAN, 7.0])
    assert lateness(robot, dancers) == pytest.approx([-0.5, NAN, NAN], nan_ok=True)
