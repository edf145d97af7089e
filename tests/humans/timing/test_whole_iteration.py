"""Dancers of ADAM and ASHLE: order of events, lapses, generators, and the size of their asynchronies."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sjasim.choreography.timetable import Timetable
from sjasim.core import Move
from sjasim.core.errors import ConfigError
from sjasim.core.tempo import TempoMap
from sjasim.humans.timing.adam import AdamParameters, AdamTiming
from sjasim.humans.timing.ashle import OscillatorParameters
from sjasim.humans.timing.ashle_dancers import AshleParameters, AshleTiming
from sjasim.humans.timing.cue_assembly import MIN_HOLD_S, MIN_MOVE_S

from ..dancing import dance
from .test_ensemble import draw, nominal_times, times, timetable

MODELS = {"adam": (AdamTiming, AdamParameters()), "ashle": (AshleTiming, AshleParameters())}
WILD = {
    "adam": AdamParameters(timekeeper_s=0.6, motor_s=0.3),
    "ashle": AshleParameters(oscillators=OscillatorParameters(noise=4.0)),
}


def people(name, parameters=None, dancers=3, persons=0, performance=0, table=None):
    model, usual = MODELS[name]
    generators = np.random.default_rng(persons), np.random.default_rng(performance)
    return model(parameters or usual, table or timetable(118.0), dancers, *generators)


def lateness(name, count=40, **options) -> np.ndarray:
    """(N, D, E) event times of different people less the nominal ones, in iteration 1 [s]."""
    calm = replace(MODELS[name][1], lapse=0.0)
    nominal = nominal_times(118.0)
    drawn = [
        draw(people(name, calm, persons=k, performance=100 + k, **options), 1, None, np.zeros(3)) for k in range(count)
    ]
    return np.array([[np.array(times(cues)) - nominal for cues in own] for own in drawn])


@pytest.mark.parametrize("name", MODELS)
def test_moves_never_overlap_and_are_never_too_short_however_noisy_people_are(name):
    model = people(name, WILD[name])
    moves = 0
    for iteration in range(8):
        free = np.full(3, timetable().start_s(iteration) - 0.3)
        for cues, earliest in zip(draw(model, iteration, 1.5, free), free, strict=True):
            end = earliest - MIN_HOLD_S
            for cue in cues:
                if cue.move is Move.TURN:
                    continue
                moves += 1
                assert cue.t_s >= end + MIN_HOLD_S - 1e-9
                if cue.move is not Move.CLAP:
                    assert cue.duration_s >= MIN_MOVE_S - 1e-9
                end = cue.t_s + cue.duration_s
    assert moves > 60


@pytest.mark.parametrize("name", MODELS)
def test_asynchronies_are_those_of_trained_ensembles(name):
    """Standard deviations of onset differences of 30 to 50 ms (rasch1979)."""
    found = lateness(name)
    gaps = found[:, 0] - found[:, 1]
    assert 0.025 < gaps[:, 3:].std() < 0.055
    assert abs(found.mean()) < 0.01


@pytest.mark.parametrize("name", MODELS)
def test_the_same_generators_give_the_same_dance_and_others_another(name):
    def take(persons, performance):
        drawn = draw(people(name, persons=persons, performance=performance), 1, None, np.zeros(3))
        return [cue.t_s for own in drawn for cue in own]

    assert take(1, 1) == take(1, 1)
    assert take(1, 1) != take(1, 2)
    assert take(1, 1) != take(2, 1)


@pytest.mark.parametrize("name", MODELS)
def test_the_same_persons_keep_their_ways_in_another_performance(name):
    """Persons differ in their noise (ADAM) or their spontaneous tempo (ASHLE), whatever the performance."""
    wide = {"adam": AdamParameters(dancer_spread=1.0), "ashle": AshleParameters(spontaneous_spread=0.25)}[name]
    first, second = (people(name, wide, persons=3, performance=k) for k in (1, 2))
    if name == "adam":
        assert np.array_equal(first._scale, second._scale)
    else:
        assert np.array_equal(first._oscillators.frequencies_hz, second._oscillators.frequencies_hz)


@pytest.mark.parametrize("name", MODELS)
def test_with_a_lapse_rate_of_one_dancers_only_turn(name):
    drawn = draw(people(name, replace(MODELS[name][1], lapse=1.0)), 1, None, np.zeros(3))
    assert [[cue.move for cue in cues] for cues in drawn] == [[Move.TURN]] * 3


@pytest.mark.parametrize("name", MODELS)
def test_an_iteration_is_decided_once_in_time_for_the_bodies(name):
    model = people(name)
    assert model.next_due_s == math.inf
    model.begin(1, None, np.zeros(3))
    due_s = model.next_due_s
    cues = model.decide(due_s, ())
    assert min(cue.t_s for own in cues for cue in own) - due_s > 1.2
    assert model.next_due_s == math.inf
    assert model.decide(due_s, ()) == ((), (), ())


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("dancers", [0, 9])
def test_a_group_outside_one_to_eight_is_refused(name, dancers):
    with pytest.raises(ConfigError, match="1 to 8 dancers"):
        people(name, dancers=dancers)


@pytest.mark.parametrize("name", MODELS)
def test_one_dancer_keeps_to_the_music(name):
    found = times(draw(people(name, replace(MODELS[name][1], lapse=0.0), dancers=1), 1, None, np.zeros(1))[0])
    assert np.abs(np.array(found) - nominal_times(118.0)).max() < 0.25


def lateness_in_a_ritardando(name, parameters) -> float:
    """Largest distance of an event from the music that slows down by 30 % [s]."""
    music = TempoMap.changing(118.0, ((0.0, 1.0), (40.0, 0.7)), ())
    table = Timetable(dance(), music, 4.0, 1, 1)
    found = np.array([times(own) for own in draw(people(name, parameters, table=table), 1, None, np.zeros(3))])
    return float(np.abs(found - [table.time_s(1, step.beat) for step in dance().steps()]).max())


def test_oscillators_follow_a_ritardando():
    assert lateness_in_a_ritardando("ashle", AshleParameters(lapse=0.0)) < 0.35


def test_anticipation_keeps_dancers_with_a_ritardando():
    correction, both = (
        lateness_in_a_ritardando("adam", AdamParameters(prediction=1.0, anticipation=share, lapse=0.0))
        for share in (0.0, 0.9)
    )
    assert both < 0.6 * correction


def test_spontaneous_tempi_pull_the_oscillators():
    """Dancers whose spontaneous tempo is faster than the music are early, those with a slower one late."""
    quiet = OscillatorParameters(noise=0.0)
    means = []
    for spontaneous_s in (0.40, 0.508, 0.64):
        parameters = AshleParameters(spontaneous_s, 0.0, quiet, 0.0)
        drawn = draw(people("ashle", parameters, dancers=1), 1, None, np.zeros(1))[0]
        means.append(np.mean(np.array(times(drawn)) - nominal_times(118.0)))
    assert means[0] < -0.003
    assert abs(means[1]) < 0.001
    assert means[2] > 0.003


def test_dancers_count_the_metrical_level_that_is_nearest_to_their_tempo():
    parameters = AshleParameters(0.24, 0.0, OscillatorParameters(noise=0.0), 0.0)
    drawn = draw(people("ashle", parameters, dancers=1), 1, None, np.zeros(1))[0]
    assert np.abs(np.array(times(drawn)) - nominal_times(118.0)).max() < 0.02
