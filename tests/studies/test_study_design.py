"""Which sessions a design has."""

import itertools
from collections import Counter
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sjasim.config import SessionConfig
from sjasim.core.errors import ConfigError
from sjasim.studies.study_design import StudyDesign, StudyPlan, group_seed, sessions


def test_the_published_design_has_three_sessions_for_each_of_nine_groups():
    specs = list(sessions(StudyDesign()))
    assert [spec.session for spec in specs] == list(range(27))
    assert [spec.condition for spec in specs[:6]] == ["none", "eca", "sia", "none", "sia", "eca"]
    assert Counter(spec.group for spec in specs) == dict.fromkeys(range(1, 10), 3)
    assert [spec.order for spec in specs[:4]] == [1, 2, 3, 1]
    assert {spec.config.fidelity for spec in specs} == {"timing"}
    # The same persons in all sessions of a group, and a fresh performance under each method.
    assert len({(spec.group, spec.config.seed) for spec in specs}) == 9
    assert {spec.config.performance for spec in specs} == {""}


def test_the_same_performance_has_one_name_in_all_sessions():
    assert {spec.config.performance for spec in sessions(StudyDesign(performance="same"))} == {"study"}


def test_levels_of_one_method_have_fresh_performances_too():
    design = StudyDesign(factors={"dance.bpm": (100, 118)})
    group = [spec for spec in sessions(design) if spec.group == 1]
    assert len({spec.config.performance for spec in group}) == len(group) == 6


def test_an_option_multiplies_only_the_sessions_of_its_method():
    design = StudyDesign(methods=("eca", "sia"), factors={"method_options.window_s": (1.0, 1.5)}, order="fixed")
    group = [spec for spec in sessions(design) if spec.group == 1]
    assert [spec.condition for spec in group] == [
        "none", "eca", "sia method_options.window_s=1", "sia method_options.window_s=1.5",
    ]  # fmt: skip
    assert [dict(spec.config.method_options) for spec in group] == [{}, {}, {"window_s": 1.0}, {"window_s": 1.5}]


def test_a_common_option_reaches_only_methods_that_have_it():
    design = StudyDesign(session=SessionConfig(fidelity="timing", method_options={"window_s": 1.2}))
    given_options = {spec.config.method: dict(spec.config.method_options) for spec in sessions(design)}
    assert given_options == {"none": {}, "eca": {}, "sia": {"window_s": 1.2}}


def test_other_people_are_other_groups():
    design = StudyDesign(groups=2, humans=("paper-warmup", "musicians"))
    specs = list(sessions(design))
    people = {spec.group: spec.config.humans for spec in specs}
    assert people == {1: "paper-warmup", 2: "paper-warmup", 3: "musicians", 4: "musicians"}
    assert len({spec.config.seed for spec in specs}) == 4
    # Both cells are counterbalanced by themselves.
    assert [spec.config.method for spec in specs if spec.order == 2] == ["eca", "sia", "eca", "sia"]


def test_a_factor_between_groups_is_named():
    within = StudyPlan(StudyDesign(groups=4, factors={"dance.bpm": (100, 118)}))
    between = StudyPlan(StudyDesign(groups=4, factors={"dance.bpm": (100, 118)}, between=("dance.bpm",)))
    assert (within.groups, within.sessions_per_group) == (4, 6)
    assert (between.groups, between.sessions_per_group) == (8, 3)
    assert {spec.config.dance.bpm for spec in between.sessions(0, 3)} == {100.0}


def test_every_group_dances_every_dance():
    design = StudyDesign(groups=2, dances=("paper", "march"))
    danced = Counter((spec.group, spec.config.method, spec.config.dance.name) for spec in sessions(design))
    assert set(danced.values()) == {1}
    assert len(danced) == 2 * 3 * 2


def test_a_robot_option_does_not_repeat_the_session_without_the_robot():
    plan = StudyPlan(StudyDesign(factors={"robot.cruise_m_s": (0.2, 0.25)}))
    assert [condition.method for condition in plan.without_robot] == ["none"]
    assert len(plan.conditions) == 4


DESIGNS = st.builds(
    StudyDesign,
    groups=st.integers(2, 12),
    methods=st.permutations(("eca", "sia", "metronome")).flatmap(
        lambda names: st.integers(1, 3).map(lambda count: tuple(names[:count]))
    ),
    order=st.sampled_from(("counterbalanced", "fixed", "random")),
    humans=st.sampled_from((("paper-warmup",), ("paper-warmup", "novices"))),
    dances=st.sampled_from((("paper",), ("paper", "waltz"))),
    replications=st.integers(1, 4),
    humans_only=st.booleans(),
    performance=st.sampled_from(("fresh", "same")),
    seed=st.integers(0, 2**63 - 1),
    seeds=st.sampled_from(("evaluation", "tuning")),
    factors=st.sampled_from(({}, {"network.packet_loss": (0.0, 0.1)}, {"dancers": (2, 3, 4)})),
)


@settings(max_examples=40)
@given(DESIGNS)
def test_groups_are_complete_and_sessions_are_found_by_their_number(design):
    plan = StudyPlan(design)
    specs = list(plan.sessions())
    assert [spec.session for spec in specs] == list(range(len(plan)))
    assert plan.session(len(plan) // 2) == specs[len(plan) // 2]

    groups = itertools.groupby(specs, key=lambda spec: (spec.study, spec.group))
    seeds = set()
    for _, members in groups:
        group = list(members)
        assert [spec.order for spec in group] == list(range(1, plan.sessions_per_group + 1))
        assert len({spec.condition for spec in group}) == len(group)
        assert len({(spec.config.seed, spec.config.humans, spec.config.dancers) for spec in group}) == 1
        assert {spec.config.method for spec in group} - {"none"} == set(design.methods)
        seeds.add(group[0].config.seed)
    assert len(seeds) == design.replications * plan.groups
    assert {seed % 2 for seed in seeds} == {0 if design.seeds == "evaluation" else 1}


@given(st.integers(0, 2**63 - 1), st.integers(0, 10**6), st.integers(1, 10**6))
def test_tuning_and_evaluation_share_no_seed(seed, study, group):
    evaluation = group_seed(seed, "evaluation", study, group)
    tuning = group_seed(seed, "tuning", study, group)
    assert evaluation % 2 == 0
    assert tuning % 2 == 1
    assert max(evaluation, tuning) < 2**53
    assert evaluation == group_seed(seed, "evaluation", study, group)


def test_a_million_sessions_need_no_memory():
    plan = StudyPlan(StudyDesign(groups=10**6))
    assert len(plan) == 3 * 10**6
    assert plan.session(len(plan) - 1).group == 10**6
    with pytest.raises(IndexError):
        plan.session(len(plan))


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"groups": 1}, "groups"),
        ({"methods": ()}, "methods"),
        ({"methods": ("sia", "sia")}, "methods"),
        ({"methods": ("none", "sia")}, "methods"),
        ({"humans": ("novices", "novices")}, "humans"),
        ({"order": "latin"}, "order"),
        ({"performance": "best"}, "performance"),
        ({"missing": "ignore"}, "missing"),
        ({"replications": 0}, "replications"),
        ({"seeds": "test"}, "seeds"),
        ({"session": SessionConfig(fidelity="timing", method="eca")}, "session.method"),
        ({"session": SessionConfig(fidelity="timing", seed=4)}, "session.seed"),
    ],
)
def test_what_is_no_study_is_refused(change, field):
    with pytest.raises(ConfigError) as caught:
        replace(StudyDesign(), **change)
    assert caught.value.field == field
