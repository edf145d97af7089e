"""The room of a recording: floor, dancers as bodies and as sensors see them, robot with its trail, sensors."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from ...assets.colours import ROBOT as ROBOT_COLOUR
from ...assets.colours import dancer_colour
from ...assets.names import JOINT_INDEX, JOINTS
from ...choreography.layout import Layout, Mount
from ...config import SensorConfig, SessionConfig
from ...core import INFERRED, TRACKED, dancer_name
from ...core.session_log import SessionLog

TIMELINE = "session_time"
Floats = NDArray[np.floating]

SEEN_EVERY = 2
"""Of how many frames one is recorded for bodies and estimated skeletons; true joints are kept at the full rate."""

TRAIL_S, TRAIL_HZ = 4.0, 5
ROBOT_RADIUS_M, ROBOT_HEIGHT_M = 0.177, 0.42
AMBER, GREEN, GREY, WHITE = (240, 168, 13), (60, 200, 90), (120, 120, 125), (245, 245, 245)
MAGENTA, RED = (220, 40, 160), (200, 40, 40)
REACH_M, STUB_M = 1.2, 0.3
"""Length of the frustum of the active sensor, and of the others."""

TETHER_HZ, NEWTONS_PER_M = 10, 50.0
"""How often the tethers' forces are recorded, and the force that an arrow of one metre stands for."""

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

CAPSULES = (
    ("SpineBase", "SpineMid", 0.115), ("SpineMid", "SpineShoulder", 0.125), ("Neck", "Head", 0.085),
    *((a + side, b + side, radius) for side in ("Left", "Right") for a, b, radius in (
        ("Knee", "Hip", 0.062), ("Ankle", "Knee", 0.046), ("Elbow", "Shoulder", 0.040), ("Wrist", "Elbow", 0.033),
    )),
)  # fmt: skip
"""Lower joint, upper joint and radius [m] of the parts of a body."""


@dataclass(frozen=True, slots=True)
class Span:
    """A stretch of session time: after ``since_s``, up to and with ``until_s``."""

    since_s: float = -np.inf
    until_s: float = np.inf

    def rows(self, t_s: Floats) -> NDArray[np.intp]:
        """Indices of the times inside."""
        return np.flatnonzero((t_s > self.since_s) & (t_s <= self.until_s))


@dataclass(frozen=True, slots=True)
class Pen:
    """A stream with a prefix before every entity, so that one recording can hold several sessions."""

    stream: rr.RecordingStream
    prefix: str = ""

    def path(self, entity: str) -> str:
        """An entity's full path."""
        return f"{self.prefix}/{entity}" if self.prefix else entity

    def fixed(self, entity: str, *values: object) -> None:
        """Log what never changes."""
        self.stream.log(self.path(entity), *values, static=True)

    def columns(self, entity: str, t_s: Floats | list[float], columns: Iterable[Any]) -> None:
        """Send columns on the session's clock; nothing for no times."""
        times = np.asarray(t_s, dtype=np.float64)
        if len(times):
            self.stream.send_columns(self.path(entity), [rr.TimeColumn(TIMELINE, duration=times)], columns)


def fix_scene(pen: Pen, config: SessionConfig, place: Layout) -> None:
    """Everything in the room that never changes."""
    pen.fixed("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    floor = rr.Boxes3D(
        half_sizes=[[4.0, 4.0, 0.01]], centers=[[0, 0, -0.012]], colors=[(196, 190, 182)], fill_mode="solid"
    )
    pen.fixed("world/floor", floor)
    links = [(JOINT_INDEX[a], JOINT_INDEX[b]) for a, b in BONES]
    keypoints = [rr.AnnotationInfo(id=index) for index in range(len(JOINTS))]
    colours = [dancer_colour(index) for index in range(config.dancers)] + [WHITE]
    classes = [
        rr.ClassDescription(
            info=rr.AnnotationInfo(id=index, color=colour),
            keypoint_annotations=keypoints,
            keypoint_connections=links,
        )
        for index, colour in enumerate(colours)
    ]
    classes.append(rr.ClassDescription(info=rr.AnnotationInfo(id=len(colours), color=MAGENTA)))
    pen.fixed("world", rr.AnnotationContext(classes))
    for index in range(config.dancers):
        fix_dancer(pen, index, config.dancers)
    if config.method != "none":
        fix_robot(pen)
    for mount in place.mounts:
        fix_sensor(pen, mount, config.sensors)


def fix_dancer(pen: Pen, index: int, group: int) -> None:
    """Colours, radii and names of one dancer's parts."""
    entity, ids = f"world/{dancer_name(index)}", np.arange(len(JOINTS))
    colour = dancer_colour(index)
    radii = [radius for _, _, radius in CAPSULES]
    pen.fixed(f"{entity}/true", rr.Points3D.from_fields(class_ids=[index], keypoint_ids=ids, radii=[0.012]))
    pen.fixed(f"{entity}/tracked", rr.Points3D.from_fields(colors=[WHITE], class_ids=[group], radii=[0.022]))
    pen.fixed(f"{entity}/inferred", rr.Points3D.from_fields(colors=[MAGENTA], class_ids=[group + 1], radii=[0.026]))
    pen.fixed(f"{entity}/body", rr.Capsules3D.from_fields(radii=radii, colors=[(*colour, 90)], fill_mode="solid"))
    pen.fixed(f"{entity}/tether", rr.Arrows3D.from_fields(colors=[RED], radii=[0.012]))
    name = rr.Points3D.from_fields(labels=[dancer_name(index)], colors=[colour], radii=[0.01], show_labels=True)
    pen.fixed(f"{entity}/name", name)


def fix_robot(pen: Pen) -> None:
    """The robot's shape, on its moving frame."""
    body = rr.Cylinders3D(
        lengths=[0.12, 0.01, ROBOT_HEIGHT_M - 0.14],
        radii=[ROBOT_RADIUS_M, 0.16, 0.10],
        centers=[[0, 0, 0.065], [0, 0, ROBOT_HEIGHT_M - 0.005], [0, 0, 0.27]],
        colors=[AMBER, ROBOT_COLOUR, ROBOT_COLOUR],
        fill_mode="solid",
    )
    front = rr.Arrows3D(vectors=[[0.38, 0, 0]], origins=[[0, 0, ROBOT_HEIGHT_M]], colors=[AMBER], radii=[0.018])
    label = rr.Points3D([[0, 0, ROBOT_HEIGHT_M + 0.1]], labels=["robot"], radii=[0.01], colors=[AMBER])
    for part, shape in (("body", body), ("front", front), ("name", label)):
        pen.fixed(f"world/robot/{part}", shape)
    pen.fixed("world/trail", rr.Points3D.from_fields(colors=[AMBER], radii=[0.018]))


def fix_sensor(pen: Pen, mount: Mount, sensors: SensorConfig) -> None:
    """A sensor's place and lens; its columns are left, up and forward, rerun's right, down and forward."""
    entity = f"world/sensors/{mount.name}"
    world_from_camera = mount.world_from_sensor * np.array([-1.0, -1.0, 1.0])
    pen.fixed(entity, rr.Transform3D(translation=mount.position, mat3x3=world_from_camera))
    half = np.tan(sensors.horizontal_fov_rad / 2), np.tan(sensors.vertical_fov_rad / 2)
    size, focal = (512.0, 512.0 * half[1] / half[0]), 256.0 / half[0]
    lens = rr.Pinhole.from_fields(
        image_from_camera=[[focal, 0, size[0] / 2], [0, focal, size[1] / 2], [0, 0, 1]], resolution=size
    )
    pen.fixed(entity, lens)


def send_sensors(pen: Pen, log: SessionLog, place: Layout, span: Span) -> None:
    """Which sensor is active: green with a long frustum, the others grey with a short one."""
    times = np.array([item.t_s for item in log.handovers], dtype=np.float64)
    for mount in place.mounts:
        entity = f"world/sensors/{mount.name}"
        if not len(times) and span.since_s < 0:
            pen.columns(entity, [0.0], rr.Pinhole.columns(color=[GREY], image_plane_distance=[STUB_M]))
        rows = span.rows(times)
        active = [log.handovers[row].sensor == mount.name for row in rows]
        colour = [GREEN if on else GREY for on in active]
        reach = [REACH_M if on else STUB_M for on in active]
        if active:
            pen.columns(entity, times[rows], rr.Pinhole.columns(color=colour, image_plane_distance=reach))


def send_dancers(pen: Pen, log: SessionLog, config: SessionConfig, span: Span) -> None:
    """Bodies and skeletons, or points where dancers stood when no joints were recorded."""
    for index in range(config.dancers):
        entity = f"world/{dancer_name(index)}"
        if log.joints is not None and index < log.joints.shape[1]:
            times = np.arange(len(log.joints)) / config.sensors.rate_hz
            _send_skeletons(pen, entity, times, log, index, span)
        elif len(log.truth.get("t_s", ())):
            mine = np.flatnonzero(log.truth["dancer"] == index)
            times = np.asarray(log.truth["t_s"], dtype=np.float64)[mine]
            rows = span.rows(times)
            where = np.stack([log.truth[name][mine[rows]] for name in ("x_m", "y_m", "z_m")], axis=1)
            if len(rows):
                pen.columns(f"{entity}/name", times[rows], rr.Points3D.columns(positions=where))


def send_tethers(pen: Pen, log: SessionLog, config: SessionConfig, span: Span) -> None:
    """The horizontal force of every dancer's tether, an arrow at the pelvis."""
    every = max(1, config.physics.ground_truth_hz // TETHER_HZ)
    for index in range(config.dancers if len(log.truth.get("t_s", ())) else 0):
        mine = np.flatnonzero(log.truth["dancer"] == index)[::every]
        times = np.asarray(log.truth["t_s"], dtype=np.float64)[mine]
        rows = mine[span.rows(times)]
        if len(rows):
            where = np.stack([log.truth[name][rows] for name in ("x_m", "y_m", "z_m")], axis=1)
            force = [np.asarray(log.truth[name], dtype=np.float64)[rows] for name in ("tether_x_n", "tether_y_n")]
            along = np.stack([*force, np.zeros(len(rows))], axis=1) / NEWTONS_PER_M
            arrows = rr.Arrows3D.columns(origins=where, vectors=along)
            pen.columns(f"world/{dancer_name(index)}/tether", times[span.rows(times)], arrows)


def _send_skeletons(pen: Pen, entity: str, times: Floats, log: SessionLog, index: int, span: Span) -> None:
    assert log.joints is not None
    rows = span.rows(times)
    if not len(rows):
        return
    true = log.joints[rows, index]
    pen.columns(
        f"{entity}/true",
        times[rows],
        rr.Points3D.columns(positions=true.reshape(-1, 3)).partition([len(JOINTS)] * len(rows)),
    )
    some = rows[rows % SEEN_EVERY == 0]
    joints = log.joints[some, index]
    if not len(some):
        return
    pen.columns(
        f"{entity}/name", times[some], rr.Points3D.columns(positions=joints[:, JOINT_INDEX["Head"]] + [0, 0, 0.2])
    )
    place, turn, length = capsules(joints)
    if rows[0] == 0:
        pen.fixed(f"{entity}/body", rr.Capsules3D.from_fields(lengths=length))
    poses = rr.InstancePoses3D.columns(translations=place.reshape(-1, 3), quaternions=turn.reshape(-1, 4))
    pen.columns(f"{entity}/body", times[some], poses.partition([len(CAPSULES)] * len(some)))
    if log.skeletons is None:
        return
    seen = log.skeletons[some, index]
    for name, state in (("tracked", TRACKED), ("inferred", INFERRED)):
        kept = seen[..., 3] == state
        ids = np.broadcast_to(np.arange(len(JOINTS)), kept.shape)[kept]
        columns = rr.Points3D.columns(positions=seen[kept, :3], keypoint_ids=ids.astype(np.uint16))
        pen.columns(f"{entity}/{name}", times[some], columns.partition(kept.sum(axis=1)))


def capsules(joints: Floats) -> tuple[Floats, Floats, Floats]:
    """Where a body's capsules lie.

    Args:
        joints: (N, 25, 3) [m].

    Returns:
        (N, C, 3) lower ends [m], (N, C, 4) rotations (x, y, z, w) that turn z along each capsule, and (C,) lengths
        in the first frame [m].
    """
    low = joints[:, [JOINT_INDEX[a] for a, _, _ in CAPSULES]]
    along = joints[:, [JOINT_INDEX[b] for _, b, _ in CAPSULES]] - low
    length = np.sqrt((along**2).sum(axis=-1, keepdims=True))
    along = along / np.maximum(length, 1e-6)
    turn = np.stack([-along[..., 1], along[..., 0], 0 * along[..., 0], 1.0 + along[..., 2] + 1e-6], axis=-1)
    turn /= np.sqrt((turn**2).sum(axis=-1, keepdims=True))
    return low, turn.astype(np.float32), length[0, :, 0]


def send_robot(pen: Pen, log: SessionLog, span: Span) -> None:
    """The robot's true pose and the way it came; nothing in a humans-only session."""
    if not len(log.odometry.get("t_s", ())):
        return
    t_s, heading = log.odometry["t_s"], log.odometry["true_heading_rad"]
    where = np.stack([log.odometry["true_x_m"], log.odometry["true_y_m"], np.zeros(len(t_s))], axis=1)
    turned = np.stack([0 * heading, 0 * heading, np.sin(heading / 2), np.cos(heading / 2)], axis=1)
    rows = span.rows(t_s)
    if len(rows):
        pose = rr.Transform3D.columns(translation=where[rows], quaternion=turned[rows])
        pen.columns("world/robot", t_s[rows], pose)
    stride = max(1, round(rate_of(t_s) / TRAIL_HZ))
    ends = np.arange(stride, len(t_s), stride)
    ends = ends[span.rows(t_s[ends])]
    dots = round(TRAIL_S * TRAIL_HZ)
    behind = np.maximum(ends[:, None] - stride * np.arange(dots), 0)
    if len(ends):
        trail = rr.Points3D.columns(positions=where[behind].reshape(-1, 3)).partition([dots] * len(ends))
        pen.columns("world/trail", t_s[ends], trail)


def rate_of(t_s: Floats) -> float:
    """Samples per second of evenly spaced times; 1 for a single one."""
    return 1 / float(np.median(np.diff(t_s))) if len(t_s) > 1 else 1.0


def send_depth(pen: Pen, log: SessionLog, span: Span) -> None:
    """Depth images of the active sensor."""
    times = np.array([picture.t_s for picture in log.depth])
    rows = span.rows(times)
    if len(rows):
        pen.fixed("depth", rr.EncodedDepthImage.from_fields(media_type="image/png", meter=1000.0))
        blobs = [np.frombuffer(log.depth[row].png, dtype=np.uint8) for row in rows]
        pen.columns("depth", times[rows], rr.EncodedDepthImage.columns(blob=blobs))
