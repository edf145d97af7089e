"""Where the robot's delay comes from, by numbers that the synthetic session puts in."""

import dataclasses

import numpy as np
import pytest

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.analysis.session_metrics import measures
from sjasim.core import Kind
from sjasim.core.session_log import Decision
from sjasim.record.rerun.explanation import STAGES, StepDelay, as_markdown, classify_step, explain

from .synthetic import DETECTION_S, ROBOT_LAG_S, session

DECIDED_S = 0.03
"""How much later than in the synthetic session commands are sent, so that the events have arrived."""


def led(late=(0.0, 0.0, 0.0)):
    """A session whose robot follows the first dancer's regular events."""
    log = session(iterations=2, late=late, spread_s=0.02)
    orders = tuple(dataclasses.replace(o, t_start_s=o.t_start_s + DECIDED_S) for o in log.commands)
    sent = tuple(
        Decision(o.t_start_s, o.iteration, o.ordinal, event.kind, "sent", o.t_start_s, "dancer_1", "seen")
        for o in orders
        for event in [step_event(log, o)]
    )
    return dataclasses.replace(log, commands=orders, decisions=sent)


def step_event(log, order):
    mine = [e for e in log.events if e.person == "dancer_1" and not e.early and e.iteration == order.iteration]
    return min(mine, key=lambda event: abs(event.t_s - order.t_start_s))


@pytest.fixture(scope="module")
def found():
    return delay_report(led(late=(0.5, 0.0, 0.0)))


def test_parts_add_up_to_the_delay(found):
    known = [step for step in found.steps if np.isfinite(step.parts_s).all()]
    assert known
    for step in known:
        assert sum(step.parts_s) == pytest.approx(step.late_s)


def test_each_part_is_what_the_session_was_made_with(found):
    parts = np.array([step.parts_s for step in found.steps if np.isfinite(step.parts_s).all()])
    mean = dict(zip(STAGES, parts.mean(axis=0), strict=True))
    assert mean["sensor"] + mean["detector"] == pytest.approx(DETECTION_S, abs=0.02)
    assert mean["wheels"] == pytest.approx(ROBOT_LAG_S - DECIDED_S, abs=0.02)
    assert mean["dancer"] == pytest.approx(0.5 * 2 / 3, abs=0.05)


def test_a_late_dancer_is_named(found):
    worst = max(found.steps, key=lambda step: step.late_s)
    assert "dancer_1, whom it followed" in explain(worst)
    assert "| 2 |" in as_markdown(found)


def test_timing_is_that_of_the_measures():
    log = session(iterations=2)
    assert [value for _, value in delay_report(log).ta] == list(measures(log).ta_s)


def test_clock_errors_are_found_for_every_sensor():
    errors = delay_report(session(iterations=2)).clocks
    assert set(errors) == {"east", "north", "west"}
    assert np.allclose(errors["north"][1], 0.0015)


@pytest.mark.parametrize(("robot_s", "word"), [(1.1, "on time"), (1.6, "late"), (0.4, "early"), (np.nan, "missed")])
def test_verdicts(robot_s, word):
    step = StepDelay(1, 0, Kind.CLAP, 1.0, robot_s, "", (np.nan,) * 4 + (0.1, robot_s - 1.1), "because")
    assert classify_step(step) == word
    assert "because" in explain(step)


def test_humans_only_has_graphs_and_no_steps():
    alone = delay_report(session(method="none", robot=False, iterations=1))
    assert alone.steps == ()
    assert len(alone.graphs) == 1
    assert "no robot" in as_markdown(alone)
