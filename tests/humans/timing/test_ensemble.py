"""Tests of the ensemble timing model against its equations, computed by a second route."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sjasim.choreography.timetable import Timetable
from sjasim.core import Kind, Move
from sjasim.core.clock import stream
from sjasim.core.errors import ConfigError
from sjasim.core.tempo import TempoMap
from sjasim.humans.timing.cue_assembly import MIN_HOLD_S, MIN_MOVE_S
from sjasim.humans.timing.ensemble import PREPARATION_S, EnsembleTiming
from sjasim.humans.timing.parameters import TimingParameters, preset, preset_names

from ..dancing import dance

SLOW = 40.0
"""A tempo so slow that the shortest moves and holds never change an event time [beats per minute]."""

PAIR = ("dancer_1", "dancer_2")

NOISY = ("paper-entrainment", "paper-warmup", "one-late", "tempo-change")


def timetable(bpm: float = 118.0) -> Timetable:
    return Timetable(dance(), TempoMap.steady(bpm), 4.0, 0, 1000)


def ensemble(parameters, dancers=3, people=0, performance=0, bpm=118.0) -> EnsembleTiming:
    streams = np.random.default_rng(people), np.random.default_rng(performance)
    return EnsembleTiming(parameters, timetable(bpm), dancers, *streams)


def draw(model, iteration, appropriateness_s, free):
    """Cues of a whole iteration of dancers who are not coupled to the robot."""
    model.begin(iteration, appropriateness_s, free)
    return model.decide(-math.inf, ())


def times(cues) -> list[float]:
    """Event times of one dancer's cues [s]."""
    return [t for cue in cues for _, t in cue.events()]


def nominal_times(bpm: float = SLOW) -> np.ndarray:
    """(E,) nominal event times of iteration 1 [s]."""
    table = timetable(bpm)
    return np.array([table.time_s(1, step.beat) for step in table.choreography.steps()])


@cache
def deviations(parameters, count, dancers=3, appropriateness_s=None, people=0, bpm=SLOW) -> np.ndarray:
    """(N, D, E) event times minus the nominal ones; each draw is another group of people."""
    nominal = nominal_times(bpm)

    out = []
    for index in range(count):
        model = ensemble(parameters, dancers, people + index, 10_000 + index, bpm)
        drawn = draw(model, 1, appropriateness_s, np.zeros(dancers))
        out.append([np.array(times(cues)) - nominal for cues in drawn])
    return np.array(out)


def expected_covariance(p: TimingParameters, dancers: int, events: int) -> np.ndarray:
    """(E, D, D) covariance of observed deviations y, from y[k+1] = A y[k] + T[k] + M[k+1] - M[k]."""
    gain = p.coupling * np.diag([(*p.correction, 1.0)[0], *[1.0] * (dancers - 1)])
    matrix = (1 - p.music_coupling) * np.eye(dancers) - gain @ (dancers * np.eye(dancers) - np.ones((dancers, dancers)))
    spread = np.exp(p.group_spread**2 + p.iteration_spread**2 + p.dancer_spread**2)

    motor = p.motor_s**2 * np.eye(dancers)
    timekeeper = p.timekeeper_s**2 * np.eye(dancers)
    sigma = timekeeper + motor
    rows = []
    for _ in range(events):
        rows.append(spread * sigma)
        # The covariance of y[k] with M[k] is that of the motor noise.
        sigma = matrix @ sigma @ matrix.T - matrix @ motor - motor @ matrix.T + timekeeper + 2 * motor
    return np.array(rows)


def test_metronomic_dancers_perform_the_nominal_times():
    drawn = draw(ensemble(preset("metronomic")), 1, None, np.zeros(3))
    assert len(drawn) == 3
    for cues in drawn:
        assert times(cues) == pytest.approx(nominal_times(118.0))


@pytest.mark.parametrize("name", preset_names())
def test_moves_never_overlap_and_are_never_too_short(name):
    model = ensemble(preset(name))
    moves = 0
    for iteration in range(60):
        free = np.array([timetable().start_s(iteration) - 0.3] * 3)
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
    assert moves > 300


def test_no_dancer_begins_before_its_earliest_time():
    earliest = [60.0, 70.0, 80.0]
    drawn = draw(ensemble(replace(preset("paper-entrainment"), lapse=0.0)), 1, None, np.array(earliest))
    assert [own[0].t_s for own in drawn] == earliest


@pytest.mark.parametrize("name", NOISY)
def test_presets_have_the_asynchronies_of_their_parameters(name):
    p = replace(preset(name), lapse=0.0, late_s=())
    found = deviations(p, 1500)

    gaps = (found[:, 0] - found[:, 1]).std(axis=0)
    covariance = expected_covariance(p, 3, found.shape[2])
    expected = np.sqrt(covariance[:, 0, 0] + covariance[:, 1, 1] - 2 * covariance[:, 0, 1])
    assert gaps == pytest.approx(expected, rel=0.10)


@pytest.mark.parametrize("name", NOISY)
def test_presets_have_the_common_shift_of_their_parameters(name):
    p = replace(preset(name), lapse=0.0, late_s=())
    found = deviations(p, 1500)
    mean = found.mean(axis=1)
    own = expected_covariance(p, 3, found.shape[2]).sum(axis=(1, 2)) / 9
    spread = np.exp(p.group_spread**2 + p.iteration_spread**2)
    assert mean.std(axis=0) == pytest.approx(np.sqrt(spread * p.common_s**2 + own), rel=0.10)
    assert np.abs(mean.mean(axis=0)).max() < 0.06


@pytest.mark.parametrize("name", NOISY)
def test_the_common_shift_is_autoregressive(name):
    p = replace(preset(name), timekeeper_s=0.0, motor_s=0.0, lapse=0.0, late_s=())
    found = deviations(p, 1200, dancers=1)[:, 0]
    rho = p.common_correlation
    for lag in (1, 2):
        pairs = [np.corrcoef(found[:, k], found[:, k + lag])[0, 1] for k in range(found.shape[1] - lag)]
        assert np.mean(pairs) == pytest.approx(rho**lag, abs=0.04)


def test_observed_asynchronies_are_corrected_motor_noise_included():
    """The published model by a second route: observed deviations, from the draws of a whole iteration."""
    gains = ((0.0, 0.1, 0.2), (0.3, 0.0, 0.0), (0.15, 0.25, 0.0))
    p = TimingParameters(timekeeper_s=0.01, motor_s=0.02, coupling=gains)
    rng = np.random.default_rng(7)
    # The draws of the iteration's scale and of the common shift come first.
    rng.standard_normal(1)
    rng.standard_normal(9)
    timekeeper, motor = np.array([[[0.01]], [[0.02]]]) * rng.standard_normal((2, 3, 9))

    y = timekeeper[:, 0] + motor[:, 0]
    expected = [y]
    for k in range(1, 9):
        asynchrony = y[:, None] - y[None, :]
        y = y - (np.array(gains) * asynchrony).sum(axis=1) + timekeeper[:, k] + motor[:, k] - motor[:, k - 1]
        expected.append(y)

    found = deviations_of(p, people=0, performance=7)
    assert pytest.approx(np.array(expected)) == np.array(found).T


def test_period_correction_reaches_a_drifting_partner_whom_phase_correction_follows_late():
    p = TimingParameters(coupling=0.2, drift=(0.02,))
    whole = [deviations(replace(p, period_correction=beta), 1)[0] for beta in (0.0, 0.1)]
    apart = [float(np.abs(found[0] - found[1:].mean(axis=0))[-1]) for found in whole]
    assert apart[1] < 0.6 * apart[0]


def test_period_correction_changes_the_tempo_of_the_following_intervals():
    """One asynchrony of .1 s, after an interval of 3 beats; the correction is relative to the interval."""
    p = TimingParameters(period_correction=0.25, robot_coupling=(0.5, 0.0), correction=(0.0,))
    late = np.array(
        [lateness(decide_beside_late_robot(ensemble(p, 2, bpm=SLOW), 0.2, [0], dancers=2), d) for d in PAIR]
    )
    interval_s = np.diff(nominal_times())
    assert late[0, 2:] == pytest.approx(0.1)
    assert late[1, 2] == pytest.approx(0.0)
    tempo = 0.25 * 0.1 / interval_s[1]
    assert late[1, 3] == pytest.approx(tempo * interval_s[2])
    tempo += 0.25 * (0.1 - late[1, 3]) / interval_s[2]
    assert late[1, 4] == pytest.approx(late[1, 3] + tempo * interval_s[3])


def test_practice_steadies_people_from_one_danced_iteration_to_the_next():
    def scatter(p, iteration):
        model = ensemble(p, 3, 0, 0, SLOW)
        nominal = np.array([timetable(SLOW).time_s(iteration, step.beat) for step in dance().steps()])
        return np.std([np.array(times(own)) - nominal for own in draw(model, iteration, None, np.zeros(3))])

    noisy = TimingParameters(timekeeper_s=0.02, motor_s=0.01)
    usual = scatter(noisy, 0)
    steady = [scatter(replace(noisy, practice=0.2), iteration) / usual for iteration in range(5)]
    assert steady == pytest.approx([1.0, 1.0, 0.8, 0.64, 0.512])
    late = [scatter(replace(noisy, practice=(0.0, 0.3)), iteration) / usual for iteration in range(5)]
    assert late == pytest.approx([1.0, 1.0, 1.0, 0.7, 0.7])
    shift = TimingParameters(common_s=0.1)
    assert scatter(shift, 3) == scatter(replace(shift, practice=0.5), 3)


def test_coupling_reduces_asynchronies():
    p = TimingParameters(timekeeper_s=0.1)
    loose, tight = (deviations(replace(p, coupling=c), 300)[:, :, -1] for c in (0.0, 0.25))
    assert tight.std(axis=1).mean() < 0.5 * loose.std(axis=1).mean()


def test_noise_grows_with_the_robots_error_by_the_entrainment_exponent():
    p = TimingParameters(timekeeper_s=0.05, motor_s=0.02, entrainment=0.61)
    usual, twice, half = (deviations(p, 200, appropriateness_s=error_s).std() for error_s in (0.70, 1.40, 0.35))
    assert twice / usual == pytest.approx(2**0.61, rel=1e-6)
    assert half / usual == pytest.approx(2**-0.61, rel=1e-6)
    assert deviations(p, 200).std() == pytest.approx(usual)


def test_the_robots_error_leaves_the_common_shift_as_it_is():
    p = TimingParameters(common_s=0.3, common_correlation=0.7, entrainment=0.61)
    assert np.array_equal(deviations(p, 20, appropriateness_s=0.1), deviations(p, 20, appropriateness_s=2.0))


def test_lapses_leave_out_phrases_and_claps_at_their_rate():
    model = ensemble(replace(preset("paper-entrainment"), lapse=0.2), dancers=8)
    cues = [own for iteration in range(150) for own in draw(model, iteration, None, np.zeros(8))]

    moved = [[cue.move for cue in own] for own in cues]
    for move, whole in ((Move.FORWARD, 2), (Move.BACKWARD, 2), (Move.CLAP, 1)):
        assert sum(m.count(move) for m in moved) / len(cues) == pytest.approx(0.8 * whole, abs=0.06)
    assert all(m.count(Move.FORWARD) == m.count(Move.BACKWARD) for m in moved)
    assert all(m.count(Move.TURN) == 1 for m in moved)


def test_with_a_lapse_rate_of_one_dancers_only_turn():
    drawn = draw(ensemble(TimingParameters(lapse=1.0)), 1, None, np.zeros(3))
    assert [[cue.move for cue in cues] for cues in drawn] == [[Move.TURN]] * 3


def test_a_late_dancer_has_a_constant_lateness():
    found = deviations(TimingParameters(late_s=(0.5,)), 2)
    assert found[:, 0] == pytest.approx(0.5)
    assert found[:, 1:] == pytest.approx(0.0)
    assert preset("one-late").late_s == (0.5,)


def test_people_and_performance_have_separate_generators():
    p = TimingParameters(common_s=0.1, group_spread=0.5)

    def take(people: int, performance: str) -> np.ndarray:
        model = EnsembleTiming(
            p, timetable(SLOW), 2, stream(people, "humans", "group"), stream(0, "humans", "performance", performance)
        )
        return np.array(times(draw(model, 1, None, np.zeros(2))[0]))

    nominal = nominal_times()
    assert np.array_equal(take(1, "a"), take(1, "a"))
    assert not np.allclose(take(1, "a"), take(1, "b"))
    ratio = (take(2, "a") - nominal) / (take(1, "a") - nominal)
    assert np.ptp(ratio) < 1e-9
    assert abs(ratio[0] - 1.0) > 0.01


def test_lapses_do_not_change_the_times_of_other_moves():
    """An iteration uses as many random numbers whatever the parameters are."""
    calm, lapsing = (ensemble(replace(preset("paper-warmup"), lapse=lapse)) for lapse in (0.0, 0.3))
    first, second = draw(calm, 1, None, np.zeros(3)), draw(lapsing, 1, None, np.zeros(3))
    starts = {(cue.dancer, cue.ordinal, cue.move): cue.t_s for own in first for cue in own}

    remaining = [cue for own in second for cue in own]
    assert 3 < len(remaining) < len(starts)
    for cue in remaining:
        assert starts[cue.dancer, cue.ordinal, cue.move] == cue.t_s


@pytest.mark.parametrize("dancers", [0, -1, 9])
def test_a_group_outside_one_to_eight_is_refused(dancers):
    with pytest.raises(ConfigError, match="1 to 8 dancers"):
        ensemble(TimingParameters(), dancers)


@pytest.mark.parametrize("dancers", [2, 3, 5, 8])
def test_one_coupling_is_a_gain_per_partner_in_groups_of_every_size(dancers):
    p = TimingParameters(timekeeper_s=0.1, coupling=0.2)
    last = deviations(p, 300, dancers)[:, :, -1]
    expected = 0.1 * np.sqrt((1 - 1 / dancers) * sum((1 - 0.2 * dancers) ** (2 * k) for k in range(9)))
    own = last - last.mean(axis=1, keepdims=True)
    assert np.sqrt((own**2).mean()) == pytest.approx(expected, rel=0.1)


def decide_beside_late_robot(model, late_s, ordinals=range(9), iteration=1, dancers=3):
    """Cues, in order of time, of a group that decides move by move beside a robot that is late at the given steps."""
    table, steps = timetable(SLOW), dance().steps()
    robot = [(steps[k].kind, table.time_s(iteration, steps[k].beat) + late_s) for k in ordinals]
    model.begin(iteration, None, np.zeros(dancers))
    cues = []
    while math.isfinite(now := model.next_due_s):
        cues += [cue for own in model.decide(now, [event for event in robot if event[1] <= now]) for cue in own]
    return sorted(cues, key=lambda cue: (cue.t_s, cue.dancer))


def lateness(cues, dancer="dancer_1"):
    """Lateness of each event of a dancer [s]."""
    events = [event for cue in cues if cue.dancer == dancer for event in cue.events()]
    return [t_s - nominal_s for nominal_s, (_, t_s) in zip(nominal_times(), events, strict=True)]


def test_dancers_who_are_coupled_to_a_late_robot_become_late():
    p = TimingParameters(robot_coupling=0.5)
    found = lateness(decide_beside_late_robot(ensemble(p, bpm=SLOW), 0.4))
    assert found[:2] == [0.0, 0.0]
    assert found[2:4] == pytest.approx([0.2, 0.2])
    assert found[4:6] == pytest.approx([0.3, 0.3])
    assert found[8] == pytest.approx(0.4 * (1 - 0.5**4))


def test_each_dancer_has_its_own_robot_coupling():
    p = TimingParameters(robot_coupling=(0.0, 0.5))
    cues = decide_beside_late_robot(ensemble(p, bpm=SLOW), 0.4)
    assert lateness(cues, "dancer_1") == pytest.approx([0.0] * 9)
    assert lateness(cues, "dancer_2")[2] == pytest.approx(0.2)


def test_dancers_correct_once_for_each_robot_event():
    p = TimingParameters(robot_coupling=0.5)
    found = lateness(decide_beside_late_robot(ensemble(p, bpm=SLOW), 0.4, ordinals=[0]))
    assert found[2:] == pytest.approx([0.2] * 7)


def test_a_turn_of_the_robot_counts_as_a_clap():
    p = TimingParameters(robot_coupling=0.5)
    model = ensemble(p, bpm=SLOW)
    model.begin(1, None, np.zeros(3))
    for _ in range(4):
        model.decide(model.next_due_s, ())
    clap_s = timetable(SLOW).time_s(1, 32)
    drawn = model.decide(model.next_due_s, [(Kind.TURN, clap_s + 0.2)])
    assert drawn[0][0].t_s == pytest.approx(clap_s - 0.5 * (0.0 - 0.2))


def test_without_robot_coupling_the_times_do_not_depend_on_when_they_are_decided():
    p = replace(preset("paper-warmup"), lapse=0.0)
    whole = ensemble(p, bpm=SLOW)
    at_once = sorted(cue.t_s for own in draw(whole, 1, None, np.zeros(3)) for cue in own)
    stepwise = ensemble(replace(p, robot_coupling=1e-12), bpm=SLOW)
    assert [cue.t_s for cue in decide_beside_late_robot(stepwise, 0.4)] == pytest.approx(at_once)


def test_a_move_begins_at_the_earliest_after_its_preparation():
    model = ensemble(TimingParameters(robot_coupling=0.1), bpm=SLOW)
    model.begin(1, None, np.zeros(3))
    late = timetable(SLOW).time_s(1, 0) + 1.0
    assert [own[0].t_s for own in model.decide(late, ())] == pytest.approx([late + PREPARATION_S] * 3)


def test_drift_accumulates_unless_the_music_is_followed():
    alone = deviations(TimingParameters(drift=(0.02,)), 1)[0]
    elapsed = nominal_times()
    assert alone[0] == pytest.approx(0.02 * (elapsed - elapsed[0]))
    held = deviations(TimingParameters(drift=(0.02,), music_coupling=0.5), 1)[0]
    assert held[0, -1] == pytest.approx(0.02 * (elapsed[1] - elapsed[0]) / 0.5, rel=0.01)
    assert alone[1:] == pytest.approx(0.0)


def test_noise_scales_with_the_dancers_factor_and_spread():
    p = TimingParameters(timekeeper_s=0.02, motor_s=0.02, scale=(0.0, 1.0, 3.0))
    found = deviations(p, 300).std(axis=(0, 2))
    assert found[0] == 0.0
    assert found[2] / found[1] == pytest.approx(3.0, rel=0.1)

    spread = deviations(TimingParameters(motor_s=0.02, dancer_spread=0.5), 400, dancers=8)
    log_scale = np.log(spread.std(axis=2))
    assert log_scale.std() > 0.45


def test_a_persons_noise_scale_is_the_same_in_every_performance():
    p = TimingParameters(motor_s=0.02, dancer_spread=0.5)
    takes = [deviations_of(p, people=3, performance=take) for take in range(40)]
    other = [deviations_of(p, people=4, performance=take) for take in range(40)]
    ratio = np.std(takes, axis=(0, 2)) / np.std(other, axis=(0, 2))
    assert np.abs(np.log(ratio)).max() > 0.2
    assert np.log(np.std(takes[:20], axis=(0, 2)) / np.std(takes[20:], axis=(0, 2))) == pytest.approx(0, abs=0.25)


def deviations_of(p, people, performance):
    """(D, E) event times of one performance minus the nominal ones [s]."""
    model = ensemble(p, 3, people, performance, SLOW)
    return [np.array(times(own)) - nominal_times() for own in draw(model, 1, None, np.zeros(3))]
