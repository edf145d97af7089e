"""What is danced when nothing is said: depth images are all that the server's sensors have, and it ends well."""

import dataclasses

from sjasim.config import SessionConfig

from .conftest import SHORT, dance


def test_a_session_that_names_no_sensing_is_seen_in_depth_images_and_ends_well():
    by_default = SessionConfig().sensing
    assert by_default == "depth"
    session = dance(sensing=by_default, dance=dataclasses.replace(SHORT.dance, lead_in_s=2.0))
    assert session.measures.as_dict()["sensing"] == "depth"
    assert session.notices == []
    assert session.measures.detector.recall >= 0.95
    assert session.measures.detector.precision >= 0.95
    assert session.measures.robot.executed == 1.0
    assert session.measures.robot_missed == 0
    assert session.measures.bodies.falls == 0
