"""The 3D scene of a recording: floor, dancers' bodies, true and estimated joints, robot with its trail, sensors."""

from __future__ import annotations

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
from ..body_shapes import BONES, CAPSULES, capsule_poses
from .entity_stream import AMBER, GREEN, GREY, MAGENTA, RED, WHITE, EntityStream, Floats, Span

Indices = NDArray[np.intp]

BODY_EVERY = 2
"""Bodies and estimated skeletons are recorded in every n-th frame; true joints in every frame."""

TRAIL_S = 4.0
"""Time that the robot's trail covers [s]."""

TRAIL_HZ = 5
"""Points of the trail per second [Hz]."""

ROBOT_RADIUS_M = 0.177
ROBOT_HEIGHT_M = 0.42

ACTIVE_FRUSTUM_M = 1.2
"""Length of the frustum that is drawn for the active sensor [m]."""

IDLE_FRUSTUM_M = 0.3
"""Length of the frustum that is drawn for the other sensors [m]."""

TETHER_HZ = 10
"""Rate at which the forces of the balance support are recorded [Hz]."""

NEWTONS_PER_M = 50.0
"""Force that an arrow of one metre stands for [N/m]."""


def log_static_scene(stream: EntityStream, config: SessionConfig, layout: Layout) -> None:
    """Log what never changes: floor, class descriptions, colours and shapes of dancers, robot and sensors."""
    stream.log_static("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    floor = rr.Boxes3D(
        half_sizes=[[4.0, 4.0, 0.01]], centers=[[0, 0, -0.012]], colors=[(196, 190, 182)], fill_mode="solid"
    )
    stream.log_static("world/floor", floor)
    stream.log_static("world", _skeleton_classes(config.dancers))

    for index in range(config.dancers):
        _log_static_dancer(stream, index, config.dancers)
    if config.method != "none":
        _log_static_robot(stream)
    for mount in layout.mounts:
        _log_static_sensor(stream, mount, config.sensors)


def send_sensors(stream: EntityStream, log: SessionLog, layout: Layout, span: Span) -> None:
    """Send which sensor is active: green with a long frustum; the others are grey with a short one."""
    times = np.array([handover.t_s for handover in log.handovers], dtype=np.float64)
    rows = span.rows(times)

    for mount in layout.mounts:
        entity = f"world/sensors/{mount.name}"
        if not len(times) and span.since_s < 0:
            idle = rr.Pinhole.columns(color=[GREY], image_plane_distance=[IDLE_FRUSTUM_M])
            stream.send_columns(entity, [0.0], idle)

        active = [log.handovers[row].sensor == mount.name for row in rows]
        if active:
            colours = [GREEN if is_active else GREY for is_active in active]
            lengths = [ACTIVE_FRUSTUM_M if is_active else IDLE_FRUSTUM_M for is_active in active]
            columns = rr.Pinhole.columns(color=colours, image_plane_distance=lengths)
            stream.send_columns(entity, times[rows], columns)


def send_dancers(stream: EntityStream, log: SessionLog, config: SessionConfig, span: Span) -> None:
    """Send bodies and skeletons; without joints in the log, only the positions of the dancers' names."""
    for index in range(config.dancers):
        if log.joints is not None and index < log.joints.shape[1]:
            rows = span.rows(np.arange(len(log.joints)) / config.sensors.rate_hz)
            if len(rows):
                _send_body(stream, log, config, index, rows)
        elif len(log.truth.get("t_s", ())):
            of_dancer = np.flatnonzero(log.truth["dancer"] == index)
            times = np.asarray(log.truth["t_s"], dtype=np.float64)[of_dancer]
            rows = span.rows(times)
            positions = _pelvis_positions(log, of_dancer[rows])
            if len(rows):
                names = rr.Points3D.columns(positions=positions)
                stream.send_columns(f"world/{dancer_name(index)}/name", times[rows], names)


def send_balance_support(stream: EntityStream, log: SessionLog, config: SessionConfig, span: Span) -> None:
    """Send the horizontal force of every dancer's balance support, as an arrow at the pelvis."""
    if not len(log.truth.get("t_s", ())):
        return

    every = max(1, config.physics.ground_truth_hz // TETHER_HZ)
    for index in range(config.dancers):
        of_dancer = np.flatnonzero(log.truth["dancer"] == index)[::every]
        times = np.asarray(log.truth["t_s"], dtype=np.float64)[of_dancer]
        inside = span.rows(times)
        rows = of_dancer[inside]
        if len(rows):
            force = [np.asarray(log.truth[name], dtype=np.float64)[rows] for name in ("tether_x_n", "tether_y_n")]
            vectors = np.stack([*force, np.zeros(len(rows))], axis=1) / NEWTONS_PER_M
            arrows = rr.Arrows3D.columns(origins=_pelvis_positions(log, rows), vectors=vectors)
            stream.send_columns(f"world/{dancer_name(index)}/tether", times[inside], arrows)


def send_robot(stream: EntityStream, log: SessionLog, span: Span) -> None:
    """Send the robot's true pose and its trail; nothing in a humans-only session."""
    if not len(log.odometry.get("t_s", ())):
        return

    t_s = log.odometry["t_s"]
    heading = log.odometry["true_heading_rad"]
    positions = np.stack([log.odometry["true_x_m"], log.odometry["true_y_m"], np.zeros(len(t_s))], axis=1)
    rotations = np.stack([0 * heading, 0 * heading, np.sin(heading / 2), np.cos(heading / 2)], axis=1)
    rows = span.rows(t_s)
    if len(rows):
        pose = rr.Transform3D.columns(translation=positions[rows], quaternion=rotations[rows])
        stream.send_columns("world/robot", t_s[rows], pose)

    # Each row of the trail is a cloud of the last positions, the newest first.
    stride = max(1, round(_sampling_rate_hz(t_s) / TRAIL_HZ))
    ends = np.arange(stride, len(t_s), stride)
    ends = ends[span.rows(t_s[ends])]
    point_count = round(TRAIL_S * TRAIL_HZ)
    trail_rows = np.maximum(ends[:, None] - stride * np.arange(point_count), 0)
    if len(ends):
        points = rr.Points3D.columns(positions=positions[trail_rows].reshape(-1, 3))
        stream.send_columns("world/trail", t_s[ends], points.partition([point_count] * len(ends)))


def send_depth(stream: EntityStream, log: SessionLog, span: Span) -> None:
    """Send the depth images of the active sensor, if the log has any."""
    times = np.array([picture.t_s for picture in log.depth])
    rows = span.rows(times)
    if len(rows):
        # Pixels are whole millimetres.
        stream.log_static("depth", rr.EncodedDepthImage.from_fields(media_type="image/png", meter=1000.0))
        blobs = [np.frombuffer(log.depth[row].png, dtype=np.uint8) for row in rows]
        stream.send_columns("depth", times[rows], rr.EncodedDepthImage.columns(blob=blobs))


def _skeleton_classes(dancers: int) -> rr.AnnotationContext:
    """Classes of points: one per dancer, one for tracked joints (white), one for inferred joints (magenta).

    The first two kinds have the lines between joints, so that the viewer draws skeletons.
    """
    bones = [(JOINT_INDEX[a], JOINT_INDEX[b]) for a, b in BONES]
    keypoints = [rr.AnnotationInfo(id=index) for index in range(len(JOINTS))]
    colours = [dancer_colour(index) for index in range(dancers)] + [WHITE]

    classes = [
        rr.ClassDescription(
            info=rr.AnnotationInfo(id=index, color=colour),
            keypoint_annotations=keypoints,
            keypoint_connections=bones,
        )
        for index, colour in enumerate(colours)
    ]
    classes.append(rr.ClassDescription(info=rr.AnnotationInfo(id=len(colours), color=MAGENTA)))
    return rr.AnnotationContext(classes)


def _log_static_dancer(stream: EntityStream, index: int, dancers: int) -> None:
    """Log colours, radii and names of one dancer's entities; ``dancers`` is the number of dancers."""
    entity = f"world/{dancer_name(index)}"
    colour = dancer_colour(index)
    tracked_class = dancers
    inferred_class = dancers + 1

    true = rr.Points3D.from_fields(class_ids=[index], keypoint_ids=np.arange(len(JOINTS)), radii=[0.012])
    tracked = rr.Points3D.from_fields(colors=[WHITE], class_ids=[tracked_class], radii=[0.022])
    inferred = rr.Points3D.from_fields(colors=[MAGENTA], class_ids=[inferred_class], radii=[0.026])
    capsule_radii = [radius for _, _, radius in CAPSULES]
    body = rr.Capsules3D.from_fields(radii=capsule_radii, colors=[(*colour, 90)], fill_mode="solid")
    force = rr.Arrows3D.from_fields(colors=[RED], radii=[0.012])
    name = rr.Points3D.from_fields(labels=[dancer_name(index)], colors=[colour], radii=[0.01], show_labels=True)

    stream.log_static(f"{entity}/true", true)
    stream.log_static(f"{entity}/tracked", tracked)
    stream.log_static(f"{entity}/inferred", inferred)
    stream.log_static(f"{entity}/body", body)
    stream.log_static(f"{entity}/tether", force)
    stream.log_static(f"{entity}/name", name)


def _log_static_robot(stream: EntityStream) -> None:
    """Log the robot's shape in its own frame, and the style of its trail."""
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
        stream.log_static(f"world/robot/{part}", shape)
    stream.log_static("world/trail", rr.Points3D.from_fields(colors=[AMBER], radii=[0.018]))


def _log_static_sensor(stream: EntityStream, mount: Mount, sensors: SensorConfig) -> None:
    """Log a sensor's pose and field of view."""
    entity = f"world/sensors/{mount.name}"
    # The sensor's axes are left, up, forward; rerun's camera has right, down, forward.
    world_from_camera = mount.world_from_sensor * np.array([-1.0, -1.0, 1.0])
    stream.log_static(entity, rr.Transform3D(translation=mount.position, mat3x3=world_from_camera))

    half_width = np.tan(sensors.horizontal_fov_rad / 2)
    half_height = np.tan(sensors.vertical_fov_rad / 2)
    size = (512.0, 512.0 * half_height / half_width)
    focal = 256.0 / half_width
    pinhole = rr.Pinhole.from_fields(
        image_from_camera=[[focal, 0, size[0] / 2], [0, focal, size[1] / 2], [0, 0, 1]], resolution=size
    )
    stream.log_static(entity, pinhole)


def _send_body(stream: EntityStream, log: SessionLog, config: SessionConfig, index: int, rows: Indices) -> None:
    """Send one dancer's true joints, name, body and estimated skeleton in some frames."""
    assert log.joints is not None
    entity = f"world/{dancer_name(index)}"
    times = np.arange(len(log.joints)) / config.sensors.rate_hz

    # Positions are sent as one flat list; `partition` says how many of them belong to each time.
    true = rr.Points3D.columns(positions=log.joints[rows, index].reshape(-1, 3))
    stream.send_columns(f"{entity}/true", times[rows], true.partition([len(JOINTS)] * len(rows)))

    body_rows = rows[rows % BODY_EVERY == 0]
    if not len(body_rows):
        return
    joints = log.joints[body_rows, index]
    name = rr.Points3D.columns(positions=joints[:, JOINT_INDEX["Head"]] + [0, 0, 0.2])
    stream.send_columns(f"{entity}/name", times[body_rows], name)

    position, rotation, length = capsule_poses(joints)
    if rows[0] == 0:
        # Bones do not change their lengths, so those of the first frame hold for the session.
        stream.log_static(f"{entity}/body", rr.Capsules3D.from_fields(lengths=length))
    poses = rr.InstancePoses3D.columns(translations=position.reshape(-1, 3), quaternions=rotation.reshape(-1, 4))
    stream.send_columns(f"{entity}/body", times[body_rows], poses.partition([len(CAPSULES)] * len(body_rows)))

    if log.skeletons is not None:
        _send_estimated_joints(stream, entity, times[body_rows], log.skeletons[body_rows, index])


def _send_estimated_joints(stream: EntityStream, entity: str, t_s: Floats, skeletons: Floats) -> None:
    """Send the joints that the active client tracked and inferred.

    Args:
        stream: where to write.
        entity: of the dancer.
        t_s: (N,) times [s].
        skeletons: (N, 25, 4) positions [m] and tracking states.
    """
    for name, state in (("tracked", TRACKED), ("inferred", INFERRED)):
        in_state = skeletons[..., 3] == state
        ids = np.broadcast_to(np.arange(len(JOINTS)), in_state.shape)[in_state]
        points = rr.Points3D.columns(positions=skeletons[in_state, :3], keypoint_ids=ids.astype(np.uint16))
        stream.send_columns(f"{entity}/{name}", t_s, points.partition(in_state.sum(axis=1)))


def _pelvis_positions(log: SessionLog, rows: Indices) -> Floats:
    """(N, 3) position in some rows of the ground-truth table [m]."""
    return np.stack([log.truth[name][rows] for name in ("x_m", "y_m", "z_m")], axis=1)


def _sampling_rate_hz(t_s: Floats) -> float:
    """Samples per second of evenly spaced times; 1 for a single time."""
    return 1 / float(np.median(np.diff(t_s))) if len(t_s) > 1 else 1.0
