"""The recording holds every entity on the session's clock, and its layout."""

import dataclasses
from collections import Counter

import numpy as np
import pytest

from sjasim.analysis.measures import measures
from sjasim.assets.names import JOINTS
from sjasim.record import rerun as recording

from ..analysis.synthetic import session

rr = pytest.importorskip("rerun")


def reader(log, tmp_path):
    path = tmp_path / "session.rrd"
    recording.save(log, path, measures(log).as_dict())
    return rr.chunk.RrdReader(str(path))


def rows(found):
    """Rows of every entity on the session's clock; chunks of one entity come in several pieces."""
    count = Counter()
    for chunk in found.stream():
        batch = chunk.to_record_batch()
        timed = recording.TIMELINE in batch.schema.names
        count[str(chunk.entity_path)] += batch.num_rows if timed else 0
    return count


def test_every_entity_is_there_once_per_tick(tmp_path):
    log = session(iterations=1)
    found = reader(log, tmp_path)
    count = rows(found)
    expected = {"/world/dancer_3": len(log.joints), "/world/robot": len(log.odometry["t_s"])}
    expected |= {"/events/dancer_1": 18, "/events/robot": 9, "/events/iteration": 2, "/measures/gsi_full_edges": 1}
    expected |= {"/log/notices": 1, "/log/decisions": 1, "/world/sensors/west": 0, "/world/robot/body": 0}
    assert {name: count.get(name) for name in expected} == expected
    assert count["/world/trail"] > 100
    assert len(found.blueprints()) == 1


def test_times_are_the_sessions(tmp_path):
    log = session(iterations=1, joints=False)
    times = []
    for chunk in reader(log, tmp_path).stream():
        if str(chunk.entity_path) == "/events/robot":
            times += chunk.to_record_batch().column(recording.TIMELINE).cast("int64").to_pylist()
    assert np.allclose(np.array(times) / 1e9, sorted(e.t_s for e in log.robot_events), atol=1e-5)


def test_humans_only_and_empty_sessions_are_recorded_too(tmp_path):
    log = session(method="none", robot=False, iterations=1, joints=False)
    assert rows(reader(log, tmp_path))["/world/dancer_1"] > 1000
    bare = dataclasses.replace(log, truth={}, events=(), decisions=(), notices=())
    assert "/world/robot" not in rows(reader(bare, tmp_path))


def test_bones_join_every_joint_once_into_one_body():
    assert len(recording.BONES) == len(JOINTS) - 1
    reached = {"SpineBase"}
    for _ in JOINTS:
        reached |= {name for bone in recording.BONES if reached & set(bone) for name in bone}
    assert reached == set(JOINTS)
