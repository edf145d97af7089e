"""The MCAP file holds the values of the tables, as an independent reader finds them."""

import json

import numpy as np
import pytest

from sjasim.record.ros2 import mcap_export

pytest.importorskip("mcap_ros2")
highlevel = pytest.importorskip("rosbags.highlevel")


@pytest.fixture(scope="module")
def log(make_session_log):
    return make_session_log(iterations=2)


@pytest.fixture(scope="module")
def messages(log, tmp_path_factory):
    path = tmp_path_factory.mktemp("mcap") / "session.mcap"
    mcap_export.save_mcap(log, path)
    found = {}
    with highlevel.AnyReader([path]) as reader:
        for connection, t_ns, raw in reader.messages():
            items = found.setdefault(connection.topic, [])
            content = reader.deserialize(raw, connection.msgtype) if len(items) < 400 else raw
            items.append((t_ns / 1e9, content))
    return found


def test_odometry_equals_the_table(messages, log):
    assert len(messages["/odom"]) == len(log.odometry["t_s"])
    for row in range(0, 400, 37):
        t_s, content = messages["/odom"][row]
        assert t_s == pytest.approx(log.odometry["t_s"][row])
        assert content.header.stamp.sec + content.header.stamp.nanosec / 1e9 == pytest.approx(t_s)
        assert content.pose.pose.position.x == log.odometry["x_m"][row]
        turned = 2 * np.arctan2(content.pose.pose.orientation.z, content.pose.pose.orientation.w)
        assert np.cos(turned - log.odometry["heading_rad"][row]) == pytest.approx(1.0)


def test_events_and_decisions_equal_the_tables(messages, log):
    events = [json.loads(content.data) for _, content in messages["/events"]]
    assert sorted(item["t_s"] for item in events if item["agent"] != "robot") == sorted(e.t_s for e in log.events)
    assert [item["t_s"] for item in events if item["agent"] == "robot"] == [e.t_s for e in log.robot_events]
    persons = [json.loads(content.data)["person"] for _, content in messages["/decisions"]]
    assert persons == [item.person for item in log.decisions]


def test_skeletons_transforms_and_commands_are_written(messages, log):
    _, content = messages["/dancers"][3]
    assert [marker.text for marker in content.markers] == ["dancer_1", "dancer_2", "dancer_3"]
    first = content.markers[1].points[0]
    assert (first.x, first.y, first.z) == pytest.approx(log.joints[3 * mcap_export.DANCERS_EVERY, 1, 0])
    assert {item.child_frame_id for item in messages["/tf_static"][0][1].transforms} >= {"sensor_north"}
    assert messages["/tf"][0][1].transforms[0].child_frame_id == "base_link"
    assert len(messages["/cmd_vel"]) == len(log.commands)


def test_quaternions_rotate_like_their_matrices():
    from scipy.spatial.transform import Rotation

    for rotation in Rotation.random(20, random_state=0):
        found = mcap_export.quaternion(rotation.as_matrix())
        converted = Rotation.from_quat([found[key] for key in "xyzw"])
        assert (converted * rotation.inv()).magnitude() < 1e-6
