"""Rules for missing data, on tables that are computed by hand."""

import numpy as np
import pytest

from sjasim.analysis.study_tables import StudyTables
from sjasim.studies.missing_data import Exclusions, with_rule

NAN = np.nan


def tables(ta_s, gsi=(0.5,) * 6):
    """Two groups of three sessions without events; ``ta_s`` are four steps of each session with a robot."""
    ta_s = np.array(ta_s, dtype=float)
    session = np.repeat([1, 2, 4, 5], 4)
    empty = np.zeros(0)
    return StudyTables(
        sessions={
            "session": np.arange(6),
            "study": np.zeros(6, dtype=int),
            "group": np.repeat([1, 2], 3),
            "method": np.array(["none", "eca", "sia"] * 2, dtype=object),
            "gsi": np.array(gsi),
            "ta_mean_s": np.array([NAN, *np.nanmean(ta_s[:2], axis=1), NAN, *np.nanmean(ta_s[2:], axis=1)]),
        },
        iterations={
            "session": np.repeat(np.arange(6), 2),
            "iteration": np.tile([1, 2], 6),
            "ta_mean_s": np.full(12, NAN),
        },
        steps={
            "session": session,
            "iteration": np.tile([1, 1, 2, 2], 4),
            "ordinal": np.tile([0, 1], 8),
            "ta_s": ta_s.ravel(),
            "latency_s": ta_s.ravel() / 2,
        },
        events={"session": empty, "t_s": empty},
    )


WHOLE = [[0.1, 0.2, 0.3, 0.4], [0.2, 0.2, 0.2, 0.2], [0.5, 0.5, 0.5, 0.5], [0.3, 0.3, 0.3, 0.3]]
ONE_MISSED = [[0.1, 0.2, 0.3, 0.4], [NAN, 0.2, 0.2, 0.2], *WHOLE[2:]]
DEAD = [[0.1, 0.2, 0.3, 0.4], [0.2, NAN, NAN, NAN], *WHOLE[2:]]


@pytest.mark.parametrize("rule", ["keep", "drop-step", "drop-group"])
def test_nothing_is_left_out_of_whole_data(rule):
    kept, exclusions = with_rule(tables(WHOLE), rule)
    assert exclusions == Exclusions()
    assert exclusions.notices() == []
    assert kept.sessions["ta_mean_s"][[1, 2]] == pytest.approx([0.25, 0.2])


def test_keep_keeps_everything():
    before = tables(DEAD)
    assert with_rule(before, "keep") == (before, Exclusions())


def test_a_missed_step_is_left_out_in_the_other_sessions_of_its_group():
    kept, exclusions = with_rule(tables(ONE_MISSED), "drop-step")
    assert exclusions == Exclusions(steps=1)
    # Session 1 loses its step of .1 s too; the other group has all its steps.
    assert np.isnan(kept.steps["ta_s"]).tolist() == [True, *[False] * 3, True, *[False] * 11]
    assert kept.sessions["ta_mean_s"][[1, 2, 4]] == pytest.approx([0.3, 0.2, 0.5])
    ta_mean_s = kept.iterations["ta_mean_s"]
    assert ta_mean_s[[2, 3, 4]] == pytest.approx([0.2, 0.35, 0.2])
    assert np.isnan(ta_mean_s[[0, 1]]).all()


def test_a_group_whose_robot_stood_still_is_dropped():
    kept, exclusions = with_rule(tables(DEAD), "drop-group")
    assert exclusions == Exclusions(incomplete_groups=1)
    assert kept.sessions["session"].tolist() == [3, 4, 5]
    assert set(kept.steps["session"]) == {4, 5}
    assert set(kept.iterations["session"]) == {3, 4, 5}
    assert with_rule(tables(ONE_MISSED), "drop-group")[1] == Exclusions()


@pytest.mark.parametrize("rule", ["keep", "drop-step", "drop-group"])
def test_a_group_with_a_failed_session_is_dropped_under_every_rule(rule):
    kept, exclusions = with_rule(tables(WHOLE, gsi=(0.5, NAN, 0.5, 0.5, 0.5, 0.5)), rule)
    assert exclusions.failed_groups == 1
    assert kept.sessions["session"].tolist() == [3, 4, 5]


def test_exclusions_add_up_and_are_said_in_words():
    total = Exclusions(1, 2, 3) + Exclusions(1, 0, 4)
    assert total == Exclusions(2, 2, 7)
    assert [line.split()[0] for line in total.notices()] == ["2", "2", "7"]
