"""A session with the default sensing, depth images, detects nearly everything and reports nothing."""

from __future__ import annotations

import dataclasses

from sjasim.config import SessionConfig

from .conftest import SHORT, run_short_session


def test_a_session_with_the_default_sensing_detects_nearly_everything():
    default = SessionConfig().sensing
    assert default == "depth"
    session = run_short_session(sensing=default, dance=dataclasses.replace(SHORT.dance, lead_in_s=2.0))
    assert session.measures.as_dict()["sensing"] == "depth"
    assert session.notices == []
    assert session.measures.detector.recall >= 0.95
    assert session.measures.detector.precision >= 0.95
    assert session.measures.robot.executed == 1.0
    assert session.measures.robot_missed == 0
    assert session.measures.bodies.falls == 0
