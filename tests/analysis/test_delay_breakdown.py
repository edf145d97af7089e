"""Parts of the robot's delay, on a log whose delays are known."""

import dataclasses

import numpy as np
import pytest

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.analysis.session_metrics import measures
from sjasim.core.session_log import Decision
from sjasim.record.rerun.explanation import STAGES, as_markdown, explain

from ..synthetic_log import DETECTION_S, ROBOT_LAG_S

DECISION_S = 0.03
"""Added to the commands' times, so that the events that they answer have arrived [s]."""


def with_decisions(log):
    """The log with a decision for every command, which follows the first dancer's regular event."""
    commands = tuple(dataclasses.replace(item, t_start_s=item.t_start_s + DECISION_S) for item in log.commands)
    sent = tuple(
        Decision(
            command.t_start_s,
            command.iteration,
            command.ordinal,
            answered_event(log, command).kind,
            "sent",
            command.t_start_s,
            "dancer_1",
            "seen",
        )
        for command in commands
    )
    return dataclasses.replace(log, commands=commands, decisions=sent)


def answered_event(log, command):
    """The first dancer's event nearest to a command."""
    events = [e for e in log.events if e.person == "dancer_1" and not e.early and e.iteration == command.iteration]
    return min(events, key=lambda event: abs(event.t_s - command.t_start_s))


@pytest.fixture(scope="module")
def found(make_session_log):
    """Report of a session whose first dancer, whom the robot follows, is half a second late."""
    log = make_session_log(iterations=2, late_s=(0.5, 0.0, 0.0), spread_s=0.02)
    return delay_report(with_decisions(log))


def test_parts_add_up_to_the_delay(found):
    known = [step for step in found.steps if np.isfinite(step.parts_s).all()]
    assert known
    for step in known:
        assert sum(step.parts_s) == pytest.approx(step.late_s)


def test_each_part_equals_the_delay_in_the_log(found):
    parts = np.array([step.parts_s for step in found.steps if np.isfinite(step.parts_s).all()])
    mean = dict(zip(STAGES, parts.mean(axis=0), strict=True))
    assert mean["sensor"] + mean["detector"] == pytest.approx(DETECTION_S, abs=0.02)
    assert mean["wheels"] == pytest.approx(ROBOT_LAG_S - DECISION_S, abs=0.02)
    assert mean["dancer"] == pytest.approx(0.5 * 2 / 3, abs=0.05)


def test_a_late_dancer_explains_the_worst_step(found):
    worst = max(found.steps, key=lambda step: step.late_s)
    assert "dancer_1, whom it followed" in explain(worst)
    assert "| 2 |" in as_markdown(found)


def test_timing_appropriateness_equals_the_measures(make_session_log):
    log = make_session_log(iterations=2)
    assert [value for _, value in delay_report(log).ta] == list(measures(log).ta_s)


def test_clock_errors_are_found_for_every_sensor(make_session_log):
    errors = delay_report(make_session_log(iterations=2)).clocks
    assert set(errors) == {"east", "north", "west"}
    assert np.allclose(errors["north"][1], 0.0015)


def test_humans_only_has_graphs_and_no_steps(make_session_log):
    alone = delay_report(make_session_log(method="none", robot=False, iterations=1))
    assert alone.steps == ()
    assert len(alone.graphs) == 1
    assert "no robot" in as_markdown(alone)
