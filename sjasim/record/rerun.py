"""A session as a rerun recording: figures, robot, sensors, event lanes and group indices on the session's clock.

Everything is sent by column once the session is over. Entities:

- ``world/dancer_1``...: skeletons, joined up by the annotation context; without recorded joints, where they stood
- ``world/robot``: pose, with ``body`` and ``trail``
- ``world/sensors/north``...: pinholes
- ``events/AGENT``: a lane of what each agent did, as logged; ``events/iteration``
- ``measures/gsi``, ``gsi_full_edges``, ``gsi_truth``: at the close of each iteration
- ``log/decisions``, ``log/notices``: text
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..assets.names import JOINT_INDEX, JOINTS
from ..choreography.layout import Mount, layout
from ..choreography.timetable import timetable
from ..config import SensorConfig, SessionConfig
from ..config_io import from_plain
from ..logs import SessionLog
from ..types import (
    ROBOT,
    dancer_name,
)

TIMELINE = "session_time"
FRAME_HZ = 30
"""Rate of the recorded joints."""

TRAIL_S = 4.0
TRAIL_HZ = 10
ROBOT_RADIUS_M, ROBOT_HEIGHT_M = 0.177, 0.42
GROUP_INDICES = ("gsi", "gsi_full_edges", "gsi_truth")
COLOURS = ((230, 120, 60), (70, 150, 220), (110, 180, 80), (190, 110, 200), (220, 190, 60), (90, 190, 190))

BONES = (
    ("SpineBase", "SpineMid"), ("SpineMid", "SpineShoulder"), ("SpineShoulder", "Neck"), ("Neck", "Head"),
    *((a + side, b + side) for side in ("Left", "Right") for a, b in (
        ("Shoulder", "Elbow"), ("Elbow", "Wrist"), ("Wrist", "Hand"), ("Hand", "HandTip"), ("Wrist", "Thumb"),
        ("Hip", "Knee"), ("Knee", "Ankle"), ("Ankle", "Foot"),
    )),
    *((trunk, limb + side) for side in ("Left", "Right") for trunk, limb in (
        ("SpineShoulder", "Shoulder"), ("SpineBase", "Hip"),
    )),
)  # fmt: skip
"""Pairs of joints that a skeleton's lines connect."""


def save(log: SessionLog, path: Path, summary: Mapping[str, Any]) -> None:
    """Write a session's recording.

    Args:
        log: the session; its ``joints`` may be None.
        path: the .rrd file.
        summary: session.json's content, for the group indices.
    """
    config = from_plain(log.config)
    name = f"{config.method}-{config.seed}"
    stream = rr.RecordingStream("sjasim", recording_id=name, send_properties=False)
    stream.save(path, default_blueprint=blueprint(config))
    try:
        stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        send_dancers(stream, log, config.group)
        send_robot(stream, log)
        place = layout(config.layout, config.group, config.room, config.sensors)
        for mount in place.mounts:
            send_sensor(stream, mount, config.sensors)
        send_events(stream, log, config)
        send_measures(stream, summary, config)
        send_texts(stream, log)
        stream.flush()
    finally:
        stream.disconnect()


def blueprint(config: SessionConfig) -> rrb.Blueprint:
    """The layout of the viewer: the room on the left, lanes, indices and log on the right."""
    agents = [dancer_name(index) for index in range(config.group)] + [ROBOT]
    lanes = [f"/events/{agent}" for agent in ("iteration", *agents)]
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Spatial3DView(origin="/world", name="Room"),
            rrb.Vertical(
                rrb.StateTimelineView(origin="/events", contents=lanes, name="Events"),
                rrb.TimeSeriesView(origin="/measures", name="Group synchronisation index"),
                rrb.TextLogView(origin="/log", name="Decisions and notices"),
                row_shares=[3, 2, 2],
            ),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
    )


def send_dancers(stream: rr.RecordingStream, log: SessionLog, group: int) -> None:
    """Skeletons at the recorded rate, or points where dancers stood when no joints were recorded."""
    links = [(JOINT_INDEX[a], JOINT_INDEX[b]) for a, b in BONES]
    keypoints = [rr.AnnotationInfo(id=index, label=joint) for index, joint in enumerate(JOINTS)]
    classes = [
        rr.ClassDescription(
            info=rr.AnnotationInfo(id=index, label=dancer_name(index), color=COLOURS[index % len(COLOURS)]),
            keypoint_annotations=keypoints,
            keypoint_connections=links,
        )
        for index in range(group)
    ]
    stream.log("world", rr.AnnotationContext(classes), static=True)
    for index in range(group):
        entity = f"world/{dancer_name(index)}"
        if log.joints is not None and index < log.joints.shape[1]:
            joints = log.joints[:, index]
            times = np.arange(len(joints)) / FRAME_HZ
            ids = np.arange(len(JOINTS))
            stream.log(entity, rr.Points3D.from_fields(class_ids=[index], keypoint_ids=ids, radii=[0.02]), static=True)
            columns = rr.Points3D.columns(positions=joints.reshape(-1, 3)).partition([len(JOINTS)] * len(joints))
        elif len(log.truth.get("t_s", ())):
            mine = log.truth["dancer"] == index
            times = log.truth["t_s"][mine].astype(np.float64)
            stream.log(entity, rr.Points3D.from_fields(class_ids=[index], radii=[0.08]), static=True)
            where = np.stack([log.truth[name][mine] for name in ("x_m", "y_m", "z_m")], axis=1)
            columns = rr.Points3D.columns(positions=where)
        else:
            continue
        stream.send_columns(entity, _times(times), columns)


def send_robot(stream: rr.RecordingStream, log: SessionLog) -> None:
    """The robot's true pose with a cylinder on it, and the way it came; nothing in a humans-only session."""
    if not len(log.odometry.get("t_s", ())):
        return
    t_s, heading = log.odometry["t_s"], log.odometry["true_heading_rad"]
    where = np.stack([log.odometry["true_x_m"], log.odometry["true_y_m"], np.zeros(len(t_s))], axis=1)
    turned = np.stack([0 * heading, 0 * heading, np.sin(heading / 2), np.cos(heading / 2)], axis=1)
    pose = rr.Transform3D.columns(translation=where, quaternion=turned)
    stream.send_columns("world/robot", _times(t_s), pose)
    body = rr.Cylinders3D(
        lengths=[ROBOT_HEIGHT_M], radii=[ROBOT_RADIUS_M], centers=[[0, 0, ROBOT_HEIGHT_M / 2]], colors=[(90, 90, 100)]
    )
    stream.log("world/robot/body", body, static=True)
    stream.log("world/robot/front", rr.Arrows3D(vectors=[[0.35, 0, 0]], origins=[[0, 0, ROBOT_HEIGHT_M]]), static=True)
    rate = 1 / float(np.median(np.diff(t_s))) if len(t_s) > 1 else 1.0
    stride = max(1, round(rate / TRAIL_HZ))
    ends = np.arange(stride, len(t_s), stride)
    if len(ends):
        trails = [where[max(0, end - round(TRAIL_S * rate)) : end + 1 : stride] for end in ends]
        columns = rr.LineStrips3D.columns(strips=trails, colors=[(150, 150, 160)] * len(trails))
        stream.send_columns("world/trail", _times(t_s[ends]), columns)


def send_sensor(stream: rr.RecordingStream, mount: Mount, sensors: SensorConfig) -> None:
    """A sensor's place and field of view; its columns are left, up and forward, rerun's right, down and forward."""
    entity = f"world/sensors/{mount.name}"
    world_from_camera = mount.world_from_sensor * np.array([-1.0, -1.0, 1.0])
    stream.log(entity, rr.Transform3D(translation=mount.position, mat3x3=world_from_camera), static=True)
    aspect = np.tan(sensors.horizontal_fov_rad / 2) / np.tan(sensors.vertical_fov_rad / 2)
    lens = rr.Pinhole(fov_y=sensors.vertical_fov_rad, aspect_ratio=float(aspect), image_plane_distance=0.4)
    stream.log(entity, lens, static=True)


def send_events(stream: rr.RecordingStream, log: SessionLog, config: SessionConfig) -> None:
    """One lane per agent with its logged regular events, and one with the iterations."""
    found: dict[str, list[tuple[float, str]]] = {}
    for event in log.events:
        if not event.early:
            found.setdefault(event.person, []).append((event.t_s, event.kind.value))
    for deed in log.robot_events:
        found.setdefault(deed.agent, []).append((deed.t_s, deed.kind.value))
    table = timetable(config)
    numbers = range(table.first, table.last + 1)
    found["iteration"] = [
        (table.start_s(number), f"iteration {number}" if number else "rehearsal") for number in numbers
    ]
    for agent, events in found.items():
        events.sort()
        states = rr.StateChange.columns(state=[state for _, state in events])
        stream.send_columns(f"events/{agent}", _times([t_s for t_s, _ in events]), states)


def send_measures(stream: rr.RecordingStream, summary: Mapping[str, Any], config: SessionConfig) -> None:
    """Group indices, each at the close of its iteration's window."""
    rows = summary.get("iterations") or []
    table = timetable(config)
    for name in GROUP_INDICES:
        known = [(table.close_s(row["index"]), row[name]) for row in rows if row.get(name) is not None]
        if known:
            columns = rr.Scalars.columns(scalars=[value for _, value in known])
            stream.send_columns(f"measures/{name}", _times([t_s for t_s, _ in known]), columns)


def send_texts(stream: rr.RecordingStream, log: SessionLog) -> None:
    """Decisions and notices as text."""
    decisions = [
        (item.t_s, f"{item.iteration}.{item.ordinal} {item.kind}: {item.action} {item.person} {item.why}", "INFO")
        for item in log.decisions
    ]
    notices = [(item.t_s, f"{item.source}: {item.what}", "WARN") for item in log.notices]
    for entity, lines in (("log/decisions", decisions), ("log/notices", notices)):
        if lines:
            times, texts, levels = zip(*lines, strict=True)
            columns = rr.TextLog.columns(text=list(texts), level=list(levels))
            stream.send_columns(entity, _times(times), columns)


def _times(t_s: Sequence[float] | Any) -> list[rr.TimeColumn]:
    return [rr.TimeColumn(TIMELINE, duration=np.asarray(t_s, dtype=np.float64))]
