"""Event tables are arranged for a fit by the steps of the dance or, in free time, by closeness in time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sjasim.analysis.calibration.tapping_trials import FitError
from sjasim.analysis.calibration.trials import arrange_trials, concatenate_trials, phrases
from sjasim.choreography.march import march
from sjasim.choreography.paper import paper
from sjasim.choreography.timetable import Timetable
from sjasim.core import Kind
from sjasim.core.session_log import TableEvent
from sjasim.core.tempo import TempoMap

TABLE = Timetable(paper(), TempoMap.steady(118), 4.0, 0, 4)
STEPS = TABLE.choreography.steps()


def event(agent, t_s, kind=Kind.CLAP, iteration=1, session="s", early=False) -> TableEvent:
    return TableEvent(session, iteration, agent, kind, t_s, early, 1)


def dance(agents, late_s, iteration=1, session="s") -> list[TableEvent]:
    return [
        event(agent, TABLE.time_s(iteration, step.beat) + late, step.kind, iteration, session)
        for agent, late in zip(agents, late_s, strict=True)
        for step in STEPS
    ]


def test_events_are_assigned_to_their_steps_and_missing_ones_are_nan():
    rows = [row for row in dance(("p2", "p10"), (0.1, -0.2)) if not (row.agent == "p2" and row.kind is Kind.CLAP)]
    ignored = [event("robot", 30.0), event("p2", 30.0, Kind.TURN), event("p2", 30.0, early=True)]
    found = arrange_trials(rows + ignored, TABLE)
    assert found.agents == ("p2", "p10")
    assert found.late_s.shape == (1, 9, 2)
    assert found.late_s[0, :8, 0] == pytest.approx(0.1)
    assert np.isnan(found.late_s[0, 8, 0])
    assert found.late_s[0, :, 1] == pytest.approx(-0.2)
    assert found.unused == 0


def test_an_event_without_a_step_is_counted():
    rows = [*dance(("a", "b"), (0.0, 0.0)), event("a", TABLE.time_s(1, 32) + 1.0)]
    assert arrange_trials(rows, TABLE).unused == 1


def test_each_iteration_of_each_session_is_a_trial():
    rows = dance(("a", "b"), (0.0, 0.1), 1, "x") + dance(("a", "b"), (0.0, 0.1), 2, "x")
    rows += dance(("c", "d"), (0.0, 0.1), 1, "y")
    found = arrange_trials(rows, TABLE)
    assert found.agents == ("place 1", "place 2")
    assert list(found.session) == [0, 0, 1]
    assert found.late_s[:, :, 1] == pytest.approx(0.1)


def test_in_free_time_events_close_in_time_belong_together():
    taps = [(0.5 * k + 0.02 * (agent == "b"), agent) for k in range(20) for agent in "ab" if (k, agent) != (7, "b")]
    found = arrange_trials([event(agent, t_s) for t_s, agent in sorted(taps)], None)
    assert found.late_s.shape == (1, 20, 2)
    assert found.time == "free"
    gap = found.late_s[0, :, 1] - found.late_s[0, :, 0]
    assert np.isnan(gap[7])
    assert np.delete(gap, 7) == pytest.approx(0.02)


def test_different_tempi_are_refused():
    taps = [event("a", 0.5 * k) for k in range(30)] + [event("b", 0.7 * k) for k in range(20)]
    with pytest.raises(FitError, match=r"a's clap comes every 0.50 s, b's every 0.70 s: .* one to one"):
        arrange_trials(sorted(taps, key=lambda one: one.t_s), None)


def test_one_omitted_step_of_few_is_not_another_tempo():
    steps = [event("a", 6.0 * k) for k in range(3)] + [event("b", 0.1 + 6.0 * k) for k in (0, 2)]
    found = arrange_trials(sorted(steps, key=lambda one: one.t_s), None)
    assert np.isfinite(found.late_s).all(axis=2).sum() == 2


def test_tables_are_concatenated_as_different_sessions():
    one, two = (arrange_trials(dance(("a", "b"), (0.0, 0.1), k), TABLE) for k in (1, 2))
    both = concatenate_trials([one, two])
    assert list(both.session) == [0, 1]
    assert both.late_s.shape == (2, 9, 2)
    with pytest.raises(FitError, match="groups of 2, 3 dancers"):
        concatenate_trials([one, arrange_trials(dance(("a", "b", "c"), (0, 0, 0)), TABLE)])
    with pytest.raises(FitError, match="different dances"):
        concatenate_trials([one, replace(two, phrases=phrases(march()))])


def test_phrases_are_the_events_that_people_omit_together():
    assert phrases(paper()) == ((0, 1, 2, 3), (4, 5, 6, 7), (8,))
    assert phrases(march()) == ((0, 1, 2, 3), (4, 5, 6, 7))


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (dance(("a",), (0.0,)), "a group of 2 to 8 dancers is needed, not of 1"),
        (dance("abcdefghi", [0.0] * 9), "not of 9"),
        (
            dance("ab", (0, 0)) + dance("abc", (0, 0, 0), session="t") + dance("xy", (0, 0), session="u"),
            "as many dancers",
        ),
        (dance("ab", (40.0, 40.0)), "s from the score on average"),
        ([], "not of 0"),
    ],
)
def test_events_that_do_not_belong_together_are_refused(rows, says):
    with pytest.raises(FitError, match=says):
        arrange_trials(rows, TABLE)


def test_people_who_do_not_hear_one_another_give_a_warning():
    rng = np.random.default_rng(2)
    alone = [(k, t_s) for k in range(3) for t_s in 0.3 * k + (0.65 + 0.01 * k) * np.arange(75)]
    together = [(k, 0.65 * beat + 0.03 * rng.standard_normal()) for k in range(3) for beat in range(75)]
    warnings = [arrange_trials([event(f"p{k}", t_s) for k, t_s in sorted(taps, key=lambda one: one[1])], None).warnings
              for taps in (alone, together)]  # fmt: skip
    assert "may be chance" in warnings[0][0]
    assert warnings[1] == ()
