"""The recording holds the values of the tables, and every view of its layout has data."""

import dataclasses
import itertools

import numpy as np
import pytest

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.assets.names import JOINTS
from sjasim.config.toml_file import from_plain
from sjasim.core import TRACKED
from sjasim.core.session_log import Handover
from sjasim.record.rerun.explanation import DelayReport
from sjasim.record.rerun.timeline import NO_STATE, lane_names

rr = pytest.importorskip("rerun")

from sjasim.record.body_shapes import BONES, CAPSULES, capsule_poses  # noqa: E402 - after the skip
from sjasim.record.rerun import recording, scene  # noqa: E402
from sjasim.record.rerun.entity_stream import TIMELINE, Span  # noqa: E402
from sjasim.record.rerun.rrd_reader import read_chunks  # noqa: E402


def with_skeletons(log):
    """The log with skeletons of everybody: ten joints are tracked, the others inferred."""
    state = np.full((*log.joints.shape[:3], 1), TRACKED, dtype=np.float32)
    state[:, :, 10:] -= 1
    skeletons = np.concatenate([log.joints + np.float32(0.01), state], axis=-1)
    return dataclasses.replace(log, skeletons=skeletons, handovers=(Handover(0.0, "east"), Handover(21.9, "north")))


@pytest.fixture(scope="module")
def log(make_session_log):
    return with_skeletons(make_session_log(iterations=1))


@pytest.fixture(scope="module")
def path(log, tmp_path_factory):
    target = tmp_path_factory.mktemp("rrd") / "session.rrd"
    recording.save(log, target, delay_report(log))
    return target


@pytest.fixture(scope="module")
def rows(path):
    """Every entity's rows in order of time: (seconds, {component: value})."""
    found = {}
    for entity, batch in read_chunks(path):
        times = batch.column(TIMELINE).cast("int64").to_numpy() / 1e9
        names = [name for name in batch.schema.names if ":" in name]
        values = [batch.column(name).to_pylist() for name in names]
        for row, t_s in enumerate(times):
            content = {name.partition(":")[2]: column[row] for name, column in zip(names, values, strict=True)}
            found.setdefault(entity, []).append((t_s, content))
    return {entity: sorted(items, key=lambda item: item[0]) for entity, items in found.items()}


def times(rows, entity):
    return np.array([t_s for t_s, _ in rows[entity]])


def test_joints_are_recorded_exactly(rows, log):
    assert np.allclose(times(rows, "/world/dancer_3/true"), np.arange(len(log.joints)) / 30, atol=1e-6)
    _, content = rows["/world/dancer_3/true"][40]
    assert np.array_equal(np.array(content["positions"], dtype=np.float32), log.joints[40, 2])
    _, tracked = rows["/world/dancer_1/tracked"][5]
    assert np.array_equal(np.array(tracked["positions"], dtype=np.float32), log.skeletons[10, 0, :10, :3])
    _, inferred = rows["/world/dancer_1/inferred"][5]
    assert inferred["keypoint_ids"] == list(range(10, len(JOINTS)))


def test_the_robots_poses_equal_the_odometry_table(rows, log):
    assert np.allclose(times(rows, "/world/robot"), log.odometry["t_s"], atol=1e-6)
    where = np.array([content["translation"][0] for _, content in rows["/world/robot"]])
    assert np.allclose(where[:, 0], log.odometry["true_x_m"], atol=1e-5)


def test_lanes_hold_every_event_of_the_tables(rows, log):
    starts = {t_s for t_s, content in rows["/lanes/dancer_1/seen"] if content["state"] != [NO_STATE]}
    logged = [event.t_s for event in log.events if event.person == "dancer_1"]
    assert np.allclose(sorted(starts), sorted(logged), atol=1e-6)
    moved = [t_s for t_s, content in rows["/lanes/robot/moved"] if content["state"] != [NO_STATE]]
    assert np.allclose(moved, sorted(event.t_s for event in log.robot_events), atol=1e-6)
    assert [content["state"] for _, content in rows["/lanes/dance/active_sensor"]] == [["east"], ["north"]]


def test_balance_support_forces_equal_the_truth_table(rows, log):
    t_s, content = rows["/world/dancer_2/tether"][7]
    row = np.flatnonzero((log.truth["dancer"] == 1) & (abs(log.truth["t_s"] - t_s) < 1e-6))[0]
    assert content["vectors"][0][0] * scene.NEWTONS_PER_M == pytest.approx(log.truth["tether_x_n"][row], rel=1e-5)


def test_curves_equal_the_measures(rows, log):
    from sjasim.analysis.session_metrics import measures

    result = measures(log)
    _, content = rows["/curves/group/gsi_full_edges"][0]
    assert content["scalars"] == [result.iterations[0].gsi_full_edges]
    shown = [content["scalars"][0] for _, content in rows["/curves/timing/appropriateness"]]
    assert sorted(shown) == sorted(result.ta_s)


def test_every_view_has_data_at_three_times(rows, path, log):
    config = from_plain(log.config)
    assert len(rr.chunk.RrdReader(str(path)).blueprints()) == 1
    wanted = [f"/lanes/{name}" for name in lane_names(config) if "robot/follows" not in name]
    wanted += ["/world/dancer_1/body", "/world/trail", "/curves/delay/total", "/curves/clocks/north"]
    short = {"/lanes/dance/iteration", "/lanes/dance/active_sensor"}  # two of each in a dance of one iteration
    missing = [entity for entity in wanted if len(rows.get(entity, ())) < (2 if entity in short else 3)]
    assert not missing
    assert {"/graph/agents", "/log/decisions", "/log/notices", "/world/sensors/west"} <= set(rows)


def test_humans_only_and_empty_sessions_are_recorded_too(make_session_log, tmp_path):
    alone = make_session_log(method="none", robot=False, iterations=1, joints=False)
    recording.save(alone, tmp_path / "a.rrd", delay_report(alone))
    found = {entity for entity, _ in read_chunks(tmp_path / "a.rrd")}
    assert "/world/dancer_1/name" in found
    assert "/world/robot" not in found
    bare = dataclasses.replace(alone, truth={}, events=(), cues=(), decisions=(), notices=())
    recording.save(bare, tmp_path / "b.rrd", DelayReport())
    assert "/lanes/dance/iteration" in {entity for entity, _ in read_chunks(tmp_path / "b.rrd")}


def test_blocks_add_up_to_the_recording_of_the_whole_session(log, rows, tmp_path):
    stream = rr.RecordingStream("sjasim", recording_id="blocks", send_properties=False)
    stream.save(tmp_path / "blocks.rrd")
    recorder = recording.Recorder(stream, from_plain(log.config))
    edges = [-np.inf, 10.0, 20.5, 31.0, np.inf]
    for since, until in itertools.pairwise(edges):
        recorder.send(log, Span(since, until))
    stream.disconnect()
    count = {}
    for entity, batch in read_chunks(tmp_path / "blocks.rrd"):
        count[entity] = count.get(entity, 0) + batch.num_rows
    for entity in ("/world/dancer_2/true", "/world/robot", "/world/dancer_2/body", "/log/decisions"):
        assert count[entity] == len(rows[entity])


def test_bones_connect_all_joints_without_a_cycle():
    assert len(BONES) == len(JOINTS) - 1
    reached = {"SpineBase"}
    for _ in JOINTS:
        reached |= {name for bone in BONES if reached & set(bone) for name in bone}
    assert reached == set(JOINTS)


def test_capsules_lie_along_their_bones():
    joints = np.random.default_rng(0).normal(size=(3, 25, 3)).astype(np.float32)
    lower, rotation, length = capsule_poses(joints)
    x, y, z, w = np.moveaxis(rotation, -1, 0)
    up = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)
    ends = lower[0] + up[0] * length[:, None]
    uppers = joints[0][[JOINTS.index(b) for _, b, _ in CAPSULES]]
    assert np.allclose(ends, uppers, atol=1e-4)
