"""The fit of coupling and noise: its likelihood by a second route, recovery of known parameters, and refusals."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sjasim.analysis.calibration.kalman_likelihood import Noise, PhaseFilter, log_mixture
from sjasim.analysis.calibration.tapping_trials import FitError, TappingTrials
from sjasim.analysis.calibration.timing_fit import fit_trials
from sjasim.analysis.calibration.trials import phrases
from sjasim.choreography.paper import paper
from sjasim.choreography.timetable import Timetable
from sjasim.core.clock import stream
from sjasim.core.errors import ConfigError
from sjasim.core.tempo import TempoMap
from sjasim.humans.timing.ensemble import EnsembleTiming
from sjasim.humans.timing.parameters import TimingParameters, preset

WIDE = 1.7
"""Factor from 95 % to 99.9 % intervals, for tests of about fifteen values at once."""
TABLE = Timetable(paper(), TempoMap.steady(118), 4.0, 0, 4)
STEPS = TABLE.choreography.steps()


def simulate(p: TimingParameters, sessions: int, dancers: int, seed: int) -> TappingTrials:
    """Five iterations of some groups, simulated with the timing model, with lapses and the order rule."""
    rows = []
    for session in range(sessions):
        people = stream(seed + session, "people")
        performance = stream(seed + session, "performance")
        model = EnsembleTiming(p, TABLE, dancers, people, performance)

        # Time from which each dancer may begin the next iteration.
        free_s = np.full(dancers, 0.5)
        for iteration in range(5):
            model.begin(iteration, None, free_s)
            late_s = np.full((len(STEPS), dancers), np.nan)
            for dancer, own in enumerate(model.decide(-math.inf, ())):
                for cue in own:
                    for k, (_, t_s) in enumerate(cue.events()):
                        beat = STEPS[cue.ordinal + k].beat
                        late_s[cue.ordinal + k, dancer] = t_s - TABLE.time_s(iteration, beat)
                free_s[dancer] = max(cue.t_s + cue.duration_s for cue in own) + 0.7
            rows.append(late_s)

    names = tuple(f"dancer_{k + 1}" for k in range(dancers))
    return TappingTrials(
        names, np.array(rows), np.repeat(np.arange(sessions), 5), "music", phrases=phrases(TABLE.choreography)
    )


def not_recovered(fit, p: TimingParameters, wide: float = 1.0) -> dict[str, tuple[float, float, float, float]]:
    """Parameters that are neither within 10 % of the fit nor inside its interval, widened by a factor."""
    truth = {name: getattr(p, name) for name in ("timekeeper_s", "motor_s", "common_s", "common_correlation", "lapse")}
    truth |= {name: getattr(p, name) for name in ("coupling", "iteration_spread", "group_spread")}
    truth |= {f"late_s[{k + 1}]": late for k, late in enumerate(p.per_dancer("late_s", len(fit.agents), 0.0))}
    found = {}
    for name, value in truth.items():
        if name not in fit.estimates:
            # A matrix of couplings has other names; few groups have no spread.
            assert name in ("coupling", "group_spread")
            continue

        item = fit.estimates[name]
        low = item.value - wide * (item.value - item.low)
        high = item.value + wide * (item.high - item.value)
        if not (low <= value <= high or abs(item.value - value) <= 0.1 * abs(value)):
            found[name] = (value, item.value, item.low, item.high)
    return found


def dense(times, phase, noise) -> tuple[float, float, int]:
    """Squared distance, log determinant and number of events from the full covariance matrix.

    Every observed event is written as a linear combination of all independent draws, by the model's recursion.
    """
    events, dancers = times.shape
    # Draws: first or timekeeper noise of all events, then motor noise; the common shift is added as a covariance.
    draws = np.eye(2 * events * dancers).reshape(2, events, dancers, -1)
    timekeeper, motor = draws
    observed = [timekeeper[0] + motor[0]]
    for e in range(1, events):
        observed.append(observed[-1] - phase @ observed[-1] + timekeeper[e] + motor[e] - motor[e - 1])
    weights = np.array(observed).reshape(events * dancers, -1)
    first = [noise.first, *[noise.timekeeper] * (events - 1)]
    variances = np.concatenate([np.ravel(first), np.tile(noise.motor, events)])
    count = np.arange(events)
    common = noise.common * noise.correlation ** np.abs(np.subtract.outer(count, count))
    if noise.rate:
        common = noise.common * (1.0 + np.outer(count, count))
    whole = weights @ np.diag(variances) @ weights.T + np.kron(common, np.ones((dancers, dancers)))
    # Changes of tempo stay with all deviations from the event after the first one on.
    tempo = np.minimum.outer(np.arange(events), np.arange(events)) * noise.tempo
    whole += np.kron(tempo, np.ones((dancers, dancers)))

    seen = np.isfinite(times).reshape(-1)
    values = times.reshape(-1)[seen]
    part = whole[np.ix_(seen, seen)]
    return float(values @ np.linalg.solve(part, values)), float(np.linalg.slogdet(part)[1]), int(seen.sum())


@pytest.mark.parametrize("rate", [0.0, 1.0])
def test_the_filter_gives_the_gaussian_density(rate):
    rng = np.random.default_rng(0)
    times = rng.normal(size=(6, 5, 3))
    times[rng.random(times.shape) < 0.25] = np.nan
    noise = Noise(
        np.array([0.4, 0.5, 0.9]),
        np.array([0.4, 0.5, 2.0]),
        np.array([0.1, 0.2, 0.3]),
        0.7,
        1.5,
        1.0 if rate else 0.6,
        rate,
    )
    phase = np.eye(3) - TimingParameters(coupling=((0, 0.1, 0.3), (0.2, 0, 0.2), (0.4, 0.0, 0))).transition_matrix(3)
    phase_filter = PhaseFilter(times)
    distance, log_det = phase_filter.evaluate(phase, noise)
    for n in range(len(times)):
        assert (distance[n], log_det[n], phase_filter.counts[n]) == pytest.approx(dense(times[n], phase, noise))


def test_the_likelihood_is_summed_over_random_scales():
    rng = np.random.default_rng(1)
    values = rng.normal(size=(4, 6))
    spread = 0.4
    nodes = np.linspace(-4.2, 4.2, 31)
    weights = np.exp(-(nodes**2) / 2) / np.exp(-(nodes**2) / 2).sum()
    found = log_mixture((values**2).sum(axis=1), np.full(4, 6), spread * nodes, np.log(weights))
    z = rng.normal(size=400_000)
    scale = np.exp(spread * z)[:, None]
    for n in range(4):
        by_chance = np.mean(np.exp(-0.5 * (values[n] ** 2).sum() / scale**2) / scale**6)
        assert found[n] == pytest.approx(np.log(by_chance), abs=0.02)


def test_musicians_are_recovered():
    p = preset("musicians")
    assert not_recovered(fit_trials(simulate(p, 30, 3, seed=610_000)), p) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper-entrainment", "paper-warmup", "musicians"])
def test_every_parameter_is_recovered_from_two_hundred_sessions(name):
    p = preset(name)
    assert not_recovered(fit_trials(simulate(p, 200, 3, seed=620_000)), p) == {}


@pytest.mark.slow
@pytest.mark.parametrize("dancers", [2, 5, 8])
def test_groups_of_every_size_are_fitted(dancers):
    p = replace(preset("musicians"), coupling=0.2)
    found = not_recovered(fit_trials(simulate(p, 40, dancers, seed=630_000)), p, WIDE)
    assert not {name for name in found if not name.startswith("late_s")}  # all dancers share the group's shift


@pytest.mark.slow
def test_a_leader_is_recovered():
    p = preset("leader")
    fit = fit_trials(simulate(p, 200, 3, seed=640_000), coupling="matrix")
    assert not_recovered(fit, p, WIDE) == {}
    gains = p.coupling_gains(3)
    for i in range(3):
        for j in range(3):
            if i != j:
                item = fit.estimates[f"coupling[{i + 1}][{j + 1}]"]
                assert item.low - 0.01 <= gains[i, j] <= item.high + 0.01
    found = fit.parameters.coupling_gains(3)
    assert found[0, 1:].max() < 0.5 * found[1:, 0].min()


@pytest.mark.slow
def test_each_dancers_noise_is_recovered():
    p = replace(preset("musicians"), scale=(0.6, 1.0, 1.6))
    fit = fit_trials(simulate(p, 100, 3, seed=650_000), noise="each")
    assert fit.parameters.scale == pytest.approx(np.array(p.scale) / np.prod(p.scale) ** (1 / 3), rel=0.06)


def test_in_free_time_only_differences_between_dancers_count():
    rng = np.random.default_rng(660_000)
    p = TimingParameters(timekeeper_s=0.03, motor_s=0.01, coupling=0.15)
    step = p.transition_matrix(3)
    x = np.zeros(3)
    motor = np.zeros(3)
    rows = []
    for _ in range(600):
        before = motor
        motor = 0.01 * rng.normal(size=3)
        x = step @ x + 0.03 * rng.normal(size=3) + motor - before
        rows.append(x + 0.5 * rng.normal())
    rows = np.array(rows)
    rows[rng.random(rows.shape) < 0.1] = np.nan
    late = rows - np.nanmean(rows, axis=1, keepdims=True)
    fit = fit_trials(TappingTrials(("a", "b", "c"), late[None], np.zeros(1, dtype=int), "free", expects_time=False))
    for name, value in (("timekeeper_s", 0.03), ("motor_s", 0.01), ("coupling", 0.15)):
        assert fit.estimates[name].low <= value <= fit.estimates[name].high, name
    assert fit.estimates["timekeeper_s"].value == pytest.approx(0.03, rel=0.15)
    assert set(fit.estimates) == {"timekeeper_s", "motor_s", "coupling", *(f"late_s[{k}]" for k in (1, 2, 3))}


def test_too_few_events_and_unknown_options_are_refused():
    few = simulate(preset("musicians"), 1, 2, seed=1)
    with pytest.raises(FitError, match="too little to fit: 18 events of 2 dancers"):
        fit_trials(replace(few, late_s=few.late_s[:1], session=few.session[:1]))
    with pytest.raises(ConfigError, match=r"coupling = 'some' .*one, matrix"):
        fit_trials(few, coupling="some")
    with pytest.raises(ConfigError, match="noise"):
        fit_trials(few, noise="loud")
    with pytest.raises(ConfigError, match="in free time"):
        fit_trials(replace(few, time="free", expects_time=False), coupling="matrix")
