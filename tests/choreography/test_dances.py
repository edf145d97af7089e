"""Tests of every registered dance: order and length of its moves, and whether dancers can perform it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from sjasim.choreography.score import MOVE_EVENTS
from sjasim.choreography.timetable import Timetable
from sjasim.core import Kind, Move
from sjasim.core.registry import names, resolve
from sjasim.core.tempo import TempoMap
from sjasim.humans.timing.cue_assembly import MIN_HOLD_S, MIN_MOVE_S

from ..humans.dancing import builds, paper_floor

DANCES = names("choreography")


def dance(name: str):
    """The dance of a name."""
    return resolve("choreography", name).factory()


def test_the_shipped_dances_are_registered():
    assert {"paper", "march", "waltz"} <= set(DANCES)


@pytest.mark.parametrize("name", DANCES)
def test_moves_are_in_order_and_inside_the_window(name):
    score = dance(name)
    assert score.name == name
    assert score.moves

    end = 0.0
    for item in score.moves:
        assert item.beat >= end
        end = item.beat + item.beats

    assert end <= score.close_beat <= score.iteration_beats
    beats = [step.beat for step in score.steps()]
    assert beats == sorted(beats)


@pytest.mark.parametrize("bpm", [80, 118, 140])
@pytest.mark.parametrize("name", DANCES)
def test_moves_and_holds_are_long_enough(name, bpm):
    score = dance(name)
    moves = [item for item in score.moves if len(MOVE_EVENTS[item.move]) == 2]
    beat = 60.0 / bpm
    assert len(moves) >= 2
    for before, after in pairwise(moves):
        assert before.beats * beat >= MIN_MOVE_S
        assert (after.beat - before.beat - before.beats) * beat > MIN_HOLD_S


@pytest.mark.parametrize("name", DANCES)
def test_every_move_forward_has_one_backward(name):
    moves = [item.move for item in dance(name).moves]
    assert moves.count(Move.FORWARD) == moves.count(Move.BACKWARD) > 0


@pytest.mark.parametrize("name", DANCES)
def test_occurrences_count_events_of_a_kind(name):
    steps = dance(name).steps()
    assert steps
    for kind in Kind:
        occurrences = [step.occurrence for step in steps if step.kind is kind]
        assert occurrences == list(range(len(occurrences)))


def test_a_march_has_no_turn_and_a_waltz_is_in_three_four_time():
    march, waltz = dance("march"), dance("waltz")

    assert march.turn_rad == 0.0
    assert {item.move for item in march.moves} == {Move.FORWARD, Move.BACKWARD}
    assert len({item.beat % 8 for item in march.moves if item.move is Move.FORWARD}) == 1

    assert all(item.beat % 3 == 0 for item in waltz.moves if item.move is not Move.TURN)
    assert waltz.iteration_beats % 3 == 0

    table = Timetable(march, TempoMap.steady(120), 4.0, 0, 4)
    assert [table.heading_rad(iteration) for iteration in range(5)] == pytest.approx([np.pi / 2] * 5)


@pytest.mark.parametrize("name", ["march", "waltz"])
def test_dancers_perform_the_dance_on_time(name):
    floor = paper_floor(builds(2, 31), seed=31, sd_s=0.1, name=name).run()
    assert not floor.fell
    assert floor.pelvis_errors().mean() < 0.015

    errors = [error for dancer in range(2) for _, error, _ in floor.event_errors(dancer)]
    assert len(errors) >= 16
    assert np.isfinite(errors).all()
    assert np.abs(errors).max() < 0.08


@pytest.mark.parametrize(("name", "faced"), [("paper", [3, 0, 1, 2, 3]), ("march", [0] * 5)])
def test_the_faced_sensor_changes_with_every_turn(name, faced):
    plan = Timetable(dance(name), TempoMap.steady(118.0), 0.0, 0, 4)
    quarters = [(plan.heading_rad(iteration) - np.pi / 2) / (np.pi / 2) for iteration in range(5)]
    assert [round(quarter) % 4 for quarter in quarters] == faced
