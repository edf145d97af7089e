"""Writes a session as an MCAP file of ROS 2 messages, for Foxglove, rosbags and other tools.

Times are session times, counted from the epoch. Frames are ``map`` (x, y, z up), ``base_link`` and ``sensor_NAME``. The
topics are:

- ``/odom`` nav_msgs/msg/Odometry: the robot's odometry estimate; ``/truth/odom``: its true pose
- ``/cmd_vel`` geometry_msgs/msg/TwistStamped: every command to the robot, as the speed that it asks for
- ``/tf`` tf2_msgs/msg/TFMessage: map to base_link, true; ``/tf_static``: the sensors
- ``/dancers`` visualization_msgs/msg/MarkerArray: skeletons, one marker a dancer, as lines between joints
- ``/events``, ``/decisions`` std_msgs/msg/String: one event or decision as JSON, with the fields of the tables
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...assets.colours import dancer_colour
from ...assets.names import JOINT_INDEX
from ...choreography.layout import layout
from ...config import SessionConfig
from ...config.toml_file import from_plain
from ...core import Array, Move, dancer_name
from ...core.errors import RecordError
from ...core.session_log import SessionLog
from ..body_shapes import BONES
from .messages import SCHEMAS

Message = tuple[float, str, str, dict[str, Any]]
"""Session time [s], topic, schema and content."""

MAP_FRAME = "map"
BASE_FRAME = "base_link"

DANCERS_EVERY = 2
"""Skeletons are written in every n-th frame."""

LINE_LIST = 5
"""Type of a marker that draws lines between pairs of points (visualization_msgs/msg/Marker.LINE_LIST)."""


def save_mcap(log: SessionLog, path: Path) -> int:
    """Write a session as an MCAP file, which appears complete or not at all.

    Args:
        log: the session; without joints, the topic ``/dancers`` is absent.
        path: the file to write; an existing one is replaced.

    Returns:
        Number of messages.

    Raises:
        RecordError: the package that writes MCAP is missing, or the file cannot be written.
    """
    try:
        from mcap_ros2.writer import Writer
    except ImportError:
        raise RecordError("MCAP needs mcap-ros2-support: pip install mcap mcap-ros2-support") from None

    config = from_plain(log.config)
    messages = sorted(_messages(log, config), key=lambda message: message[0])
    draft = path.with_name(f".{path.name}.partial")

    try:
        with draft.open("wb") as file:
            writer = Writer(file)
            schemas = {name: writer.register_msgdef(name, text) for name, text in SCHEMAS.items()}
            for t_s, topic, schema, content in messages:
                t_ns = round(t_s * 1e9)
                writer.write_message(topic, schemas[schema], content, log_time=t_ns, publish_time=t_ns)
            writer.finish()
        draft.replace(path)
    except OSError as error:
        raise RecordError(f"{path} cannot be written: {error.strerror or error}") from None
    finally:
        draft.unlink(missing_ok=True)

    return len(messages)


def stamp(t_s: float) -> dict[str, int]:
    """Session time [s] as a ROS time."""
    seconds, nanoseconds = divmod(round(t_s * 1e9), 10**9)
    return {"sec": seconds, "nanosec": nanoseconds}


def quaternion(rotation: Array) -> dict[str, float]:
    """A (3, 3) rotation matrix as a unit quaternion.

    Each component's size follows from the diagonal, and its sign from the opposite elements; rounding may make a square
    slightly negative.
    """
    xx, yy, zz = np.diag(rotation)
    w = math.sqrt(max(0.0, 1.0 + xx + yy + zz)) / 2
    x = math.copysign(math.sqrt(max(0.0, 1.0 + xx - yy - zz)) / 2, rotation[2, 1] - rotation[1, 2])
    y = math.copysign(math.sqrt(max(0.0, 1.0 - xx + yy - zz)) / 2, rotation[0, 2] - rotation[2, 0])
    z = math.copysign(math.sqrt(max(0.0, 1.0 - xx - yy + zz)) / 2, rotation[1, 0] - rotation[0, 1])
    return {"x": float(x), "y": float(y), "z": float(z), "w": float(w)}


def _messages(log: SessionLog, config: SessionConfig) -> Iterator[Message]:
    """All messages of a session, by topic."""
    yield from _robot_messages(log)
    yield from _command_messages(log, config)
    yield _sensor_message(config)
    yield from _dancer_messages(log, config)
    yield from _event_messages(log)
    yield from _decision_messages(log)


def _robot_messages(log: SessionLog) -> Iterator[Message]:
    """Estimated and true odometry, and the true transform of the robot, for every row of the odometry table."""
    table = log.odometry
    if not table:
        return
    times = table["t_s"]
    speed = table["step_m"] / np.gradient(times) if len(times) > 1 else np.zeros(len(times))

    for row, t_s in enumerate(times.tolist()):
        twist = {"linear": _vector(float(speed[row])), "angular": _vector(0, 0, float(table["yaw_rate_rad_s"][row]))}
        header = {"stamp": stamp(t_s), "frame_id": MAP_FRAME}

        for topic, prefix in (("/odom", ""), ("/truth/odom", "true_")):
            x, y, heading = (float(table[f"{prefix}{name}"][row]) for name in ("x_m", "y_m", "heading_rad"))
            pose = {"position": _vector(x, y), "orientation": _yaw_quaternion(heading)}
            # In ROS, a covariance of zeros means that it is unknown.
            content = {
                "header": header, "child_frame_id": BASE_FRAME, "pose": {"pose": pose, "covariance": [0.0] * 36},
                "twist": {"twist": twist, "covariance": [0.0] * 36},
            }  # fmt: skip
            yield (t_s, topic, "nav_msgs/msg/Odometry", content)

        # The true pose is the last one of the loop.
        pose = {"translation": _vector(x, y), "rotation": _yaw_quaternion(heading)}
        transform = {"header": header, "child_frame_id": BASE_FRAME, "transform": pose}
        yield (t_s, "/tf", "tf2_msgs/msg/TFMessage", {"transforms": [transform]})


def _command_messages(log: SessionLog, config: SessionConfig) -> Iterator[Message]:
    """Commands as speeds: forward and backward along x, turns about z, stops as zero."""
    signs = {Move.FORWARD: 1.0, Move.BACKWARD: -1.0}
    for command in log.commands:
        speed_m_s = signs.get(command.move, 0.0) * command.speed_m_s
        turn_rate_rad_s = config.robot.turn_rate_rad_s if command.move is Move.TURN else 0.0
        twist = {"linear": _vector(speed_m_s), "angular": _vector(0, 0, turn_rate_rad_s)}
        header = {"stamp": stamp(command.t_start_s), "frame_id": BASE_FRAME}
        yield (command.t_start_s, "/cmd_vel", "geometry_msgs/msg/TwistStamped", {"header": header, "twist": twist})


def _sensor_message(config: SessionConfig) -> Message:
    """Transforms to the sensors' optical frames (x right, y down, z forward)."""
    transforms = []
    for mount in layout(config).mounts:
        # The sensor's own axes are left, up, forward.
        rotation = mount.world_from_sensor * np.array([-1.0, -1.0, 1.0])
        x, y, z = (float(value) for value in mount.position)
        transforms.append({
            "header": {"stamp": stamp(0.0), "frame_id": MAP_FRAME}, "child_frame_id": f"sensor_{mount.name}",
            "transform": {"translation": _vector(x, y, z), "rotation": quaternion(rotation)},
        })  # fmt: skip
    return (0.0, "/tf_static", "tf2_msgs/msg/TFMessage", {"transforms": transforms})


def _dancer_messages(log: SessionLog, config: SessionConfig) -> Iterator[Message]:
    """Skeletons of all dancers, one message for each recorded frame."""
    if log.joints is None:
        return

    bone_ends = np.array([[JOINT_INDEX[a], JOINT_INDEX[b]] for a, b in BONES]).ravel()
    for frame in range(0, len(log.joints), DANCERS_EVERY):
        t_s = frame / config.sensors.rate_hz
        markers = [
            _skeleton_marker(index, joints[bone_ends].astype(float), t_s)
            for index, joints in enumerate(log.joints[frame])
        ]
        yield (t_s, "/dancers", "visualization_msgs/msg/MarkerArray", {"markers": markers})


def _skeleton_marker(index: int, bone_ends_m: Array, t_s: float) -> dict[str, Any]:
    """Marker of one dancer; ``bone_ends_m`` (2 B, 3) has both ends of every bone in turn."""
    red, green, blue = (value / 255 for value in dancer_colour(index))
    return {
        "header": {"stamp": stamp(t_s), "frame_id": MAP_FRAME}, "ns": dancer_name(index), "id": index,
        "type": LINE_LIST, "action": 0, "pose": {"position": _vector(), "orientation": _yaw_quaternion(0.0)},
        "scale": _vector(0.03), "color": {"r": red, "g": green, "b": blue, "a": 1.0},
        "lifetime": {"sec": 0, "nanosec": 0}, "frame_locked": False,
        "points": [{"x": x, "y": y, "z": z} for x, y, z in bone_ends_m.tolist()], "colors": [],
        "text": dancer_name(index), "mesh_resource": "", "mesh_use_embedded_materials": False,
    }  # fmt: skip


def _event_messages(log: SessionLog) -> Iterator[Message]:
    """Dancers' events at their arrival at the server, and the robot's events when they happened."""
    for event in log.events:
        content = {
            "agent": event.person, "kind": event.kind.value, "t_s": event.t_s, "t_arrival_s": event.t_arrival_s,
            "early": event.early, "iteration": event.iteration, "source": event.sensor,
        }  # fmt: skip
        yield (event.t_arrival_s, "/events", "std_msgs/msg/String", {"data": json.dumps(content)})

    for robot_event in log.robot_events:
        content = {
            "agent": robot_event.agent, "kind": robot_event.kind.value, "t_s": robot_event.t_s,
            "iteration": robot_event.iteration,
        }  # fmt: skip
        yield (robot_event.t_s, "/events", "std_msgs/msg/String", {"data": json.dumps(content)})


def _decision_messages(log: SessionLog) -> Iterator[Message]:
    """The method's decisions."""
    for decision in log.decisions:
        content = {
            "t_s": decision.t_s, "iteration": decision.iteration, "ordinal": decision.ordinal,
            "kind": decision.kind.value, "action": decision.action, "t_send_s": _finite_or_none(decision.t_send_s),
            "person": decision.person, "why": decision.why,
        }  # fmt: skip
        yield (decision.t_s, "/decisions", "std_msgs/msg/String", {"data": json.dumps(content)})


def _yaw_quaternion(angle: float) -> dict[str, float]:
    """Rotation about z by an angle [rad]."""
    return {"x": 0.0, "y": 0.0, "z": math.sin(angle / 2), "w": math.cos(angle / 2)}


def _vector(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> dict[str, float]:
    """A geometry_msgs vector or point."""
    return {"x": float(x), "y": float(y), "z": float(z)}


def _finite_or_none(value: float) -> float | None:
    """A number for JSON, which has no infinity."""
    return value if math.isfinite(value) else None
