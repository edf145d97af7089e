"""Chance level of the synchronisation index: against plain loops over KD-trees, and in groups whose level is known."""

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from sjasim.analysis.event_rows import event_rows
from sjasim.analysis.study_summary import study_summary
from sjasim.analysis.study_values import select_sessions
from sjasim.analysis.surrogates import (
    chance_level,
    interval_shuffle,
    observed_indices,
    pseudo_groups,
    uniform_shift,
)
from sjasim.anticipation.pair_kernel import pair_indices
from sjasim.anticipation.synchrony import pair_index

from .synthetic_study import nested_study

TAU_S = 0.25


@pytest.fixture(scope="module")
def study():
    return nested_study(np.random.default_rng(21), groups=10, methods=("none", "eca", "sia"), shared_s=0.15)


def tree_index(a, b):
    """Pairwise index of two agents by counting neighbours in KD-trees. Source: iqbal2016, eqs. (1)-(4)."""
    total, weights = 0.0, 0
    for kind in {name for _, name in (*a, *b)}:
        x = np.array([[t_s] for t_s, name in a if name == kind])
        y = np.array([[t_s] for t_s, name in b if name == kind])
        weights += len(x) + len(y)
        if len(x) and len(y):
            count = cKDTree(x).count_neighbors(cKDTree(y), np.nextafter(TAU_S, 0.0))
            total += count / np.sqrt(len(x) * len(y)) * (len(x) + len(y))
    return total / weights if weights else 0.0


def series_by_group(tables, condition):
    """(group, iteration, agent) -> events of that agent, with turns as claps."""
    group_of = {
        number: group
        for number, group, name in zip(
            tables.sessions["session"], tables.sessions["group"], tables.sessions["condition"], strict=True
        )
        if name == condition
    }
    series = {}
    for number, iteration, agent, kind, t_s in zip(*tables.events.values(), strict=True):
        if number in group_of:
            name = "clap" if kind == "turn" else kind
            series.setdefault((group_of[number], iteration, agent), []).append((round(t_s, 6), name))
    return series


def independent_chance(tables, condition, draws, rng):
    """Index of the dancers of pseudo-groups, by loops: each dancer of an iteration comes from another group."""
    series = series_by_group(tables, condition)
    groups = sorted({group for group, _, _ in series})
    values = []
    for _ in range(draws):
        chosen = rng.permutation(groups)[:3]
        for iteration in (1, 2, 3, 4):
            dancers = [series.get((group, iteration, agent), []) for agent, group in enumerate(chosen, start=1)]
            values.append(np.mean([tree_index(a, b) for a, b in itertools.combinations(dancers, 2)]))
    return np.mean(values), np.quantile(values, 0.95)


@pytest.mark.parametrize("condition", ["none", "eca", "sia"])
def test_real_groups_have_the_indices_of_the_tables(study, condition):
    rows = event_rows(study, condition)
    indices = observed_indices(rows)
    numbers = study.sessions["session"][study.sessions["condition"] == condition]
    own = np.isin(study.iterations["session"], numbers)
    for name in ("gsi", "gsi_full_edges", "gsi_humans"):
        assert getattr(indices, name) == pytest.approx(study.iterations[name][own], abs=1e-12)
    assert rows.gsi == pytest.approx(study.iterations["gsi"][own])


@settings(max_examples=60)
@given(
    st.lists(st.tuples(st.integers(0, 200), st.integers(0, 2)), max_size=12),
    st.lists(st.tuples(st.integers(0, 200), st.integers(0, 2)), max_size=12),
)
def test_the_kernel_counts_ties_bursts_and_missing_kinds_as_the_pairwise_index_does(a, b):
    """Times in steps of 10 ms: lags of exactly 0 and of exactly tau occur."""
    events = [*a, *b]
    times_us = np.array([time * 10_000 for time, _ in events], dtype=np.int64)
    kinds = np.array([kind for _, kind in events], dtype=np.int64)
    slices = np.array([[[0, len(a)], [len(a), len(events)]]])
    computed = pair_indices(times_us, kinds, slices, 250_000, 3)[0, 0, 1]

    names = ("start_forward", "stop_forward", "clap")
    times = [[0.01 * time for time, _ in own] for own in (a, b)]
    words = [[names[kind] for _, kind in own] for own in (a, b)]
    assert computed == pytest.approx(pair_index(times[0], words[0], times[1], words[1]), abs=1e-12)


@pytest.mark.parametrize("condition", ["none", "sia"])
def test_the_chance_level_agrees_with_an_independent_computation(study, condition):
    mean, point = independent_chance(study, condition, 200, np.random.default_rng(3))
    computed = chance_level(event_rows(study, condition), np.random.default_rng(4))
    level = computed["surrogates"]["pseudo_groups"]["gsi_humans"]
    assert level["mean"] == pytest.approx(mean, abs=0.02)
    assert level["p95"] == pytest.approx(point, abs=0.04)
    assert level["observed"] > level["mean"] + 0.1


def test_groups_that_do_not_coordinate_are_at_chance():
    """Every dancer of a group gets the events of the same dancer of another group."""
    study = nested_study(np.random.default_rng(8), groups=30, methods=("none",), shared_s=0.3)
    rows = event_rows(study, "none")
    slices = rows.slices.copy()
    for agent in range(3):
        slices[:, agent] = rows.slices[(np.arange(len(slices)) + 4 * agent) % len(slices), agent]
    mixed = dataclasses.replace(rows, slices=slices)

    real = chance_level(rows, np.random.default_rng(0))
    apart = chance_level(mixed, np.random.default_rng(0))
    assert real["observed"] > real["p95"]
    assert apart["observed"] == pytest.approx(apart["mean"], abs=0.04)
    assert apart["above_p95"] < 0.12


def test_no_two_agents_of_a_pseudo_group_come_from_one_group(study):
    """Groups whose events are a year apart never coincide, unless two agents come from one of them."""
    year_s = 3.15e7
    group_of = dict(zip(study.sessions["session"], study.sessions["group"], strict=True))
    offset_s = year_s * np.array([group_of[number] for number in study.events["session"]])
    apart = dataclasses.replace(study, events={**study.events, "t_s": study.events["t_s"] + offset_s})
    rows = event_rows(apart, "sia")
    assert observed_indices(rows).gsi_full_edges.min() > 0.1
    rng = np.random.default_rng(1)
    for _ in range(20):
        assert pseudo_groups(rows, rng).gsi_full_edges.max() == 0.0


def test_the_robot_of_a_pseudo_group_keeps_its_edges(study):
    rng = np.random.default_rng(2)
    for condition, equal in (("eca", True), ("sia", False)):
        drawn = pseudo_groups(event_rows(study, condition), rng)
        assert np.allclose(drawn.gsi, drawn.gsi_full_edges) == equal
        assert (drawn.gsi <= drawn.gsi_full_edges + 1e-12).all()


def test_the_edges_of_a_pseudo_group_are_those_of_the_session_that_gave_the_robot(study, monkeypatch):
    followed = np.random.default_rng(5).integers(1, 4, len(study.iterations["followed"]))
    rows = event_rows(dataclasses.replace(study, iterations={**study.iterations, "followed": followed}), "sia")
    seen = {}

    def record(rows, times_us, slices, robot_edges):
        seen.update(slices=slices, robot_edges=robot_edges)

    monkeypatch.setattr("sjasim.analysis.surrogates.group_indices", record)
    pseudo_groups(rows, np.random.default_rng(0))
    donor = np.searchsorted(rows.slices[:, -1, 0], seen["slices"][:, -1, 0])
    assert len(donor) == 40
    assert (seen["robot_edges"] == rows.robot_edges[donor]).all()


def test_a_shuffle_keeps_every_series_first_event_and_its_intervals(study, monkeypatch):
    rows = event_rows(study, "eca")
    seen = {}

    def record(rows, times_us, slices, robot_edges):
        seen["times_us"] = times_us

    monkeypatch.setattr("sjasim.analysis.surrogates.group_indices", record)
    interval_shuffle(rows, np.random.default_rng(0))
    changed = 0
    for start, end in rows.slices.reshape(-1, 2):
        before, after = rows.times_us[start:end], seen["times_us"][start:end]
        assert before[0] == after[0]
        assert sorted(np.diff(before)) == sorted(np.diff(after))
        changed += not np.array_equal(before, after)
    assert changed > 100


def test_a_shift_keeps_lags_within_an_agent_on_the_circle_and_spreads_the_phase(study, monkeypatch):
    rows = event_rows(study, "eca")
    seen = {}

    def record(rows, times_us, slices, robot_edges):
        seen["times_us"] = times_us

    monkeypatch.setattr("sjasim.analysis.surrogates.group_indices", record)
    uniform_shift(rows, np.random.default_rng(0))
    start_us = rows.times_us.min()
    length_us = rows.times_us.max() - start_us + 1
    shifts = (seen["times_us"] - rows.times_us) % length_us
    first = [shifts[start] for start, _ in rows.slices.reshape(-1, 2)]
    for start, end in rows.slices.reshape(-1, 2):
        assert (shifts[start:end] == shifts[start]).all()
    assert np.std(first) == pytest.approx(length_us / np.sqrt(12), rel=0.15)
    assert seen["times_us"].min() >= start_us
    assert seen["times_us"].max() < start_us + length_us


def test_three_groups_are_too_few_for_a_robot_and_three_dancers(study):
    summary = study_summary(select_sessions(study, study.sessions["group"] <= 3))
    assert summary["chance"]["eca"]["mean"] is None
    assert summary["chance"]["eca"]["observed"] == pytest.approx(summary["gsi"]["eca"]["mean"])
    assert summary["chance"]["none"]["mean"] is not None
    assert any("too few for pseudo-groups of 4 agents" in line for line in summary["notices"])


def test_a_study_without_events_or_with_another_window_says_so(study):
    empty = {name: values[:0] for name, values in study.events.items()}
    summary = study_summary(dataclasses.replace(study, events=empty))
    assert summary["chance"] == {"none": None, "eca": None, "sia": None}
    assert len(summary["notices"]) == 3

    summary = study_summary(study, tau_s=0.1)
    assert any("other parameters of synchrony" in line for line in summary["notices"])
    assert study_summary(study)["notices"] == []


def test_an_iteration_without_events_counts_as_zero(study):
    first = (study.events["session"] == 0) & (study.events["iteration"] == 2)
    kept = dataclasses.replace(study, events={name: values[~first] for name, values in study.events.items()})
    assert observed_indices(event_rows(kept, "none")).gsi[1] == 0.0
