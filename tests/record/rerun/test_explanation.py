"""Sentences about a step's delay, and the summary of a session."""

import dataclasses

import numpy as np
import pytest

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.core import Kind
from sjasim.record.rerun.explanation import STAGES, StepDelay, as_markdown, classify_step, explain

UNKNOWN = (np.nan,) * len(STAGES)


def step(robot_s, parts_s, follows=""):
    """A clap of the dancers at 1.0 s, and the robot's turn at ``robot_s``."""
    return StepDelay(1, 0, Kind.CLAP, 1.0, robot_s, follows, parts_s, "because")


@pytest.mark.parametrize(("robot_s", "name"), [(1.1, "on time"), (1.6, "late"), (0.4, "early"), (np.nan, "missed")])
def test_a_step_is_classified_by_its_delay(robot_s, name):
    one = step(robot_s, (np.nan,) * 4 + (0.1, robot_s - 1.1))
    assert classify_step(one) == name
    assert "because" in explain(one)


def test_the_largest_part_of_a_delay_is_named():
    parts_s = (0.1, 0.07, 0.02, 0.01, 0.5, -0.1)
    assert (
        explain(step(1.6, parts_s))
        == "1.0 s, clap: robot 0.60 s late; mostly the method's own timing (0.50 s): because"
    )


def test_the_followed_dancer_is_named_if_it_was_late_itself():
    sentence = explain(step(1.6, (0.5, 0.07, 0.02, 0.01, 0.05, -0.05), follows="dancer_2"))
    assert sentence == "1.0 s, clap: robot 0.60 s late; dancer_2, whom it followed, was 0.50 s late too"


@pytest.mark.parametrize(("robot_s", "word"), [(1.6, "late"), (0.4, "early")])
def test_a_late_or_early_step_without_a_command_says_so(robot_s, word):
    one = step(robot_s, UNKNOWN)
    assert explain(one) == f"1.0 s, clap: robot 0.60 s {word}; no command (because)"


def test_the_summary_of_a_session_without_commands_says_so(make_session_log):
    log = make_session_log(method="eca", late_s=(-0.5, 0.5, 0.5), iterations=1, joints=False)
    report = delay_report(dataclasses.replace(log, commands=(), decisions=()))

    assert {classify_step(one) for one in report.steps} >= {"early"}
    assert np.isnan([one.parts_s for one in report.steps]).all()
    assert "no command" in as_markdown(report)
