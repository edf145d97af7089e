"""A session as an MCAP file of ROS 2 messages, for Foxglove, rosbags and other tools of that world.

Times are the session's, counted from the epoch; frames are ``map`` (x, y, z up) and ``base_link``. Topics:

- ``/odom`` nav_msgs/msg/Odometry, as the robot believes; ``/truth/odom``, as it is
- ``/cmd_vel`` geometry_msgs/msg/TwistStamped: every command to the robot, as the speed it asks for
- ``/tf`` tf2_msgs/msg/TFMessage: map to base_link, true; ``/tf_static``: the sensors
- ``/dancers`` visualization_msgs/msg/MarkerArray: skeletons, one marker a dancer, as lines between joints
- ``/events``, ``/decisions`` std_msgs/msg/String: JSON, one object an event or decision, fields named as the tables'
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
from ...core import Move, dancer_name
from ...core.errors import RecordError
from ...core.session_log import SessionLog
from ..rerun.scene import BONES
from .messages import SCHEMAS

Message = tuple[float, str, str, dict[str, Any]]
"""Session time, topic, schema and content."""

MAP, BASE = "map", "base_link"
DANCERS_EVERY = 2
"""Of how many skeleton frames one is written."""


def save_mcap(log: SessionLog, path: Path) -> int:
    """Write a session as MCAP.

    Args:
        log: the session; without joints there is no ``/dancers``.
        path: the file, which is replaced.

    Returns:
        the number of messages.

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
            known = {name: writer.register_msgdef(name, text) for name, text in SCHEMAS.items()}
            for t_s, topic, schema, content in messages:
                stamp = round(t_s * 1e9)
                writer.write_message(topic, known[schema], content, log_time=stamp, publish_time=stamp)
            writer.finish()
        draft.replace(path)
    except OSError as error:
        raise RecordError(f"{path} cannot be written: {error.strerror or error}") from None
    finally:
        draft.unlink(missing_ok=True)
    return len(messages)


def _messages(log: SessionLog, config: SessionConfig) -> Iterator[Message]:
    yield from _robot(log)
    yield from _commands(log, config)
    yield from _sensors(config)
    yield from _dancers(log, config)
    for event in log.events:
        plain = {"agent": event.person, "kind": event.kind.value, "t_s": event.t_s, "t_arrival_s": event.t_arrival_s,
                 "early": event.early, "iteration": event.iteration, "source": event.sensor}  # fmt: skip
        yield (event.t_arrival_s, "/events", "std_msgs/msg/String", {"data": json.dumps(plain)})
    for deed in log.robot_events:
        plain = {"agent": deed.agent, "kind": deed.kind.value, "t_s": deed.t_s, "iteration": deed.iteration}
        yield (deed.t_s, "/events", "std_msgs/msg/String", {"data": json.dumps(plain)})
    for item in log.decisions:
        said = {"t_s": item.t_s, "iteration": item.iteration, "ordinal": item.ordinal, "kind": item.kind.value,
                 "action": item.action, "t_send_s": _finite(item.t_send_s), "person": item.person,
                 "why": item.why}  # fmt: skip
        yield (item.t_s, "/decisions", "std_msgs/msg/String", {"data": json.dumps(said)})


def _robot(log: SessionLog) -> Iterator[Message]:
    table = log.odometry
    if not table:
        return
    t_s = table["t_s"]
    speed = table["step_m"] / np.gradient(t_s) if len(t_s) > 1 else np.zeros(len(t_s))
    for row, time in enumerate(t_s.tolist()):
        twist = {"linear": _vector(float(speed[row])), "angular": _vector(0, 0, float(table["yaw_rate_rad_s"][row]))}
        header = {"stamp": stamp(time), "frame_id": MAP}
        for topic, names in (("/odom", ("x_m", "y_m", "heading_rad")),
                             ("/truth/odom", ("true_x_m", "true_y_m", "true_heading_rad"))):  # fmt: skip
            x, y, heading = (float(table[name][row]) for name in names)
            pose = {"position": _vector(x, y), "orientation": _about_z(heading)}
            content = {
                "header": header, "child_frame_id": BASE, "pose": {"pose": pose, "covariance": [0.0] * 36},
                "twist": {"twist": twist, "covariance": [0.0] * 36},
            }  # fmt: skip
            yield (time, topic, "nav_msgs/msg/Odometry", content)
        move = {"translation": _vector(x, y), "rotation": _about_z(heading)}
        transform = {"header": header, "child_frame_id": BASE, "transform": move}
        yield (time, "/tf", "tf2_msgs/msg/TFMessage", {"transforms": [transform]})


def _commands(log: SessionLog, config: SessionConfig) -> Iterator[Message]:
    for order in log.commands:
        sign = {Move.FORWARD: 1.0, Move.BACKWARD: -1.0}.get(order.move, 0.0)
        turn = config.robot.turn_rate_rad_s if order.move is Move.TURN else 0.0
        twist = {"linear": _vector(sign * order.speed_m_s), "angular": _vector(0, 0, turn)}
        header = {"stamp": stamp(order.t_start_s), "frame_id": BASE}
        yield (order.t_start_s, "/cmd_vel", "geometry_msgs/msg/TwistStamped", {"header": header, "twist": twist})


def _sensors(config: SessionConfig) -> Iterator[Message]:
    """The sensors' optical frames: right, down, forward."""
    transforms = []
    for mount in layout(config).mounts:
        turn = mount.world_from_sensor * np.array([-1.0, -1.0, 1.0])
        x, y, z = (float(value) for value in mount.position)
        transforms.append({
            "header": {"stamp": stamp(0.0), "frame_id": MAP}, "child_frame_id": f"sensor_{mount.name}",
            "transform": {"translation": _vector(x, y, z), "rotation": quaternion(turn)},
        })  # fmt: skip
    yield (0.0, "/tf_static", "tf2_msgs/msg/TFMessage", {"transforms": transforms})


def _dancers(log: SessionLog, config: SessionConfig) -> Iterator[Message]:
    if log.joints is None:
        return
    ends = np.array([[JOINT_INDEX[a], JOINT_INDEX[b]] for a, b in BONES]).ravel()
    for frame in range(0, len(log.joints), DANCERS_EVERY):
        t_s = frame / config.sensors.rate_hz
        markers = []
        for index, joints in enumerate(log.joints[frame]):
            red, green, blue = (value / 255 for value in dancer_colour(index))
            points = [{"x": x, "y": y, "z": z} for x, y, z in joints[ends].astype(float).tolist()]
            markers.append({
                "header": {"stamp": stamp(t_s), "frame_id": MAP}, "ns": dancer_name(index), "id": index, "type": 5,
                "action": 0, "pose": {"position": _vector(), "orientation": _about_z(0.0)},
                "scale": _vector(0.03), "color": {"r": red, "g": green, "b": blue, "a": 1.0},
                "lifetime": {"sec": 0, "nanosec": 0}, "frame_locked": False, "points": points, "colors": [],
                "text": dancer_name(index), "mesh_resource": "", "mesh_use_embedded_materials": False,
            })  # fmt: skip
        yield (t_s, "/dancers", "visualization_msgs/msg/MarkerArray", {"markers": markers})


def stamp(t_s: float) -> dict[str, int]:
    """Session time as a ROS time."""
    seconds, rest = divmod(round(t_s * 1e9), 10**9)
    return {"sec": seconds, "nanosec": rest}


def quaternion(turn: np.ndarray) -> dict[str, float]:
    """A rotation matrix as a quaternion."""
    w = math.sqrt(max(0.0, 1.0 + turn[0, 0] + turn[1, 1] + turn[2, 2])) / 2
    x = math.copysign(math.sqrt(max(0.0, 1.0 + turn[0, 0] - turn[1, 1] - turn[2, 2])) / 2, turn[2, 1] - turn[1, 2])
    y = math.copysign(math.sqrt(max(0.0, 1.0 - turn[0, 0] + turn[1, 1] - turn[2, 2])) / 2, turn[0, 2] - turn[2, 0])
    z = math.copysign(math.sqrt(max(0.0, 1.0 - turn[0, 0] - turn[1, 1] + turn[2, 2])) / 2, turn[1, 0] - turn[0, 1])
    return {"x": float(x), "y": float(y), "z": float(z), "w": float(w)}


def _about_z(angle: float) -> dict[str, float]:
    return {"x": 0.0, "y": 0.0, "z": math.sin(angle / 2), "w": math.cos(angle / 2)}


def _vector(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> dict[str, float]:
    return {"x": float(x), "y": float(y), "z": float(z)}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
