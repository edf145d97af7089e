"""The floor layout: slots of the dancers and the robot, and poses of the four sensors at the cardinal points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..assets.names import CARDINALS
from ..config import SceneConfig, SensorConfig, SessionConfig
from ..config.session import MAX_DANCERS
from ..core import Array
from ..core.errors import ConfigError

RING_SPACING_M = 0.75
"""Least distance between neighbours in a ring [m] (assumed)."""

MIN_SPACING_M = 0.6
"""Least distance between any two slots [m] (assumed)."""

ROW_LENGTH = 3
"""Slots in a row of the layout ``rows``, for more than three dancers."""


@dataclass(frozen=True, slots=True)
class Mount:
    """Pose of a sensor: level, at a height, with the viewing direction through the centre of the floor.

    Attributes:
        name: ``north``, ``west``, ``south`` or ``east``.
        position: (3,) optical centre [m].
        world_from_sensor: (3, 3) rotation. Its columns are the sensor's left, up and viewing direction, the axes of the
            Kinect's camera space.
    """

    name: str
    position: Array
    world_from_sensor: Array


@dataclass(frozen=True, slots=True)
class Layout:
    """Slots of the dancers and the robot, and poses of the sensors.

    Attributes:
        dancers: (D, 2) slots of the dancers [m].
        robot: (2,) slot of the robot [m].
        mounts: the four sensors in the order of `CARDINALS`.
    """

    dancers: Array
    robot: Array
    mounts: tuple[Mount, ...]


def layout(config: SessionConfig) -> Layout:
    """The layout that a configuration asks for.

    Args:
        config: its ``layout`` is ``square`` (turned so that no two bodies line up for a sensor; a ring for more than
            three dancers), ``rows`` (the paper's aligned rows; rows of three for more than three dancers) or ``custom``
            (``scene.slots_m``).

    Raises:
        ConfigError: the slots are too few or too close, or somebody would leave the range or the field of view of a
            sensor while it is faced.
    """
    return _shared_layout(config.layout, config.dancers, config.scene, config.sensors, config.dance.step_m)


@lru_cache(maxsize=64)
def _shared_layout(name: str, dancers: int, scene: SceneConfig, sensors: SensorConfig, step_m: float) -> Layout:
    """The layout of some options; sessions with the same options share it."""
    slots = _slots(name, dancers, scene)
    _check_spacing(slots, name)

    mounts = tuple(_mount(cardinal, index, scene) for index, cardinal in enumerate(CARDINALS))
    fields = "scene.slots_m" if name == "custom" else "scene.side_m"
    for mount in mounts:
        problem = _visibility_problem(slots, mount, sensors, step_m)
        if problem is not None:
            raise ConfigError("layout", name, f"{problem} (scene.sensor_distance_m, {fields})")

    for array in (slots, *(mount.position for mount in mounts), *(mount.world_from_sensor for mount in mounts)):
        array.flags.writeable = False
    return Layout(slots[:-1], slots[-1], mounts)


def _check_spacing(slots: Array, name: str) -> None:
    # Adding a large number to the diagonal leaves the distance of a slot from itself out of the minimum.
    gaps = np.linalg.norm(slots[:, None] - slots[None], axis=-1) + 9.0 * np.eye(len(slots))

    if gaps.min() < MIN_SPACING_M:
        raise ConfigError("layout", name, f"slots at least .6 m apart, not {gaps.min():.2f} m")


def _visibility_problem(slots: Array, mount: Mount, sensors: SensorConfig, step_m: float) -> str | None:
    """What one sensor requires and a layout does not give, or None.

    Args:
        slots: (N, 2) slots [m].
        mount: the sensor.
        sensors: range and field of view.
        step_m: length of a move forward, which brings bodies nearer to the sensor [m].
    """
    relative = np.c_[slots, np.zeros(len(slots))] - mount.position
    across, _, depth = (relative @ mount.world_from_sensor).T

    near = depth.min() - step_m
    far = depth.max()
    if near < sensors.min_range_m or far > sensors.max_range_m:
        return (
            f"bodies within {sensors.min_range_m:g} to {sensors.max_range_m:g} m of the {mount.name} sensor "
            f"while it is faced, not {near:.2f} to {far:.2f} m"
        )

    bearing = float(np.arctan2(np.abs(across), depth - step_m).max())
    if bearing > sensors.horizontal_fov_rad / 2:
        return (
            f"bodies within {np.degrees(sensors.horizontal_fov_rad / 2):.1f} degrees of the {mount.name} sensor's "
            f"axis, also after a move forward, not {np.degrees(bearing):.1f}"
        )

    return None


def _slots(name: str, dancers: int, scene: SceneConfig) -> Array:
    """(D + 1, 2) slots of a layout, the robot's last [m]."""
    if name == "custom":
        if len(scene.slots_m) != dancers + 1:
            raise ConfigError("scene.slots_m", scene.slots_m, f"{dancers + 1} slots: the dancers', then the robot's")
        return np.array(scene.slots_m, dtype=float)

    if scene.slots_m:
        raise ConfigError("scene.slots_m", scene.slots_m, f"only with layout custom; {name} has its own slots")
    if not 1 <= dancers <= MAX_DANCERS:
        raise ConfigError("dancers", dancers, f"1 to {MAX_DANCERS} dancers")
    if dancers > 3:
        return _ring(dancers + 1, scene) if name == "square" else _rows(dancers + 1, scene)

    return _corners(name, dancers, scene)


def _corners(name: str, dancers: int, scene: SceneConfig) -> Array:
    """Slots on the corners of a square, the robot's always on the fourth; groups below three leave corners empty."""
    half = scene.side_m / 2
    corners = np.array([[half, half], [-half, half], [half, -half], [-half, -half]])

    if name == "square":
        cos = np.cos(scene.turn_rad)
        sin = np.sin(scene.turn_rad)
        corners = corners @ np.array([[cos, sin], [-sin, cos]])

    return np.concatenate([corners[:dancers], corners[3:]])


def _ring(count: int, scene: SceneConfig) -> Array:
    """Slots on the circle through the square's corners, or on a wider one where they would be too close."""
    radius = max(scene.side_m / np.sqrt(2.0), RING_SPACING_M / 2 / np.sin(np.pi / count))
    bearings = np.pi / 4 + scene.turn_rad + 2 * np.pi * np.arange(count) / count
    return np.asarray(radius * np.stack([np.cos(bearings), np.sin(bearings)], axis=1))


def _rows(count: int, scene: SceneConfig) -> Array:
    """Slots in aligned rows of three, which are half as wide again as the square; the last slot is the robot's."""
    rows = -(-count // ROW_LENGTH)
    spacing = 0.75 * scene.side_m

    x = spacing * (1.0 - np.arange(ROW_LENGTH))
    y = spacing * ((rows - 1) / 2 - np.arange(rows))
    places = np.stack([np.tile(x, rows), np.repeat(y, ROW_LENGTH)], axis=1)

    # Where the last row is not full, the robot takes its far end.
    return np.concatenate([places[: count - 1], places[-1:]])


def _mount(name: str, index: int, scene: SceneConfig) -> Mount:
    """The ``index``-th sensor, counter-clockwise from north."""
    bearing = np.pi / 2 * (1 + index)
    outward = np.array([np.cos(bearing), np.sin(bearing), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    left = np.cross(up, -outward)

    position = scene.sensor_distance_m * outward + np.array([0.0, 0.0, scene.sensor_height_m])
    return Mount(name, position, np.stack([left, up, -outward], axis=1))
