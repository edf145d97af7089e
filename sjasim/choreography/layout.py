"""Where everyone stands: slots of dancers and robot, and the four sensors at the cardinal points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..assets.names import CARDINALS
from ..config import SceneConfig, SessionConfig
from ..core import Array
from ..core.errors import ConfigError

APART_M = 0.75
"""Neighbours in a ring stand at least so far apart [m] (assumed)."""


@dataclass(frozen=True, slots=True)
class Mount:
    """A sensor's known place: level, at a height, looking at the centre.

    Attributes:
        name: ``north``, ``west``, ``south`` or ``east``.
        position: (3,) optical centre [m].
        world_from_sensor: (3, 3) rotation; columns are the sensor's left, up, and the viewing
            direction (the Kinect's camera space).
    """

    name: str
    position: Array
    world_from_sensor: Array


@dataclass(frozen=True, slots=True)
class Layout:
    """Slots and sensors.

    Attributes:
        dancers: (D, 2) slots of the dancers [m].
        robot: (2,) the robot's slot [m].
        mounts: the four sensors in the order of `CARDINALS`.
    """

    dancers: Array
    robot: Array
    mounts: tuple[Mount, ...]


def layout(config: SessionConfig) -> Layout:
    """Places of dancers, robot and sensors.

    Args:
        config: its ``layout`` is ``square`` (turned so that bodies stand apart from every sensor; a ring for more than
            three dancers), ``rows`` (the paper's aligned rows; of three for more than three dancers) or ``custom``
            (``scene.slots_m``). Every slot and move must lie within range and view of the sensor that is faced.

    Raises:
        ConfigError: slots are too few or too close, or someone would leave the active sensor's range or view.
    """
    name, scene, sensors = config.layout, config.scene, config.sensors
    slots = _slots(name, config.dancers, scene)
    gaps = np.linalg.norm(slots[:, None] - slots[None], axis=-1) + 9.0 * np.eye(len(slots))
    if gaps.min() < 0.6:
        raise ConfigError("layout", name, f"slots at least .6 m apart, not {gaps.min():.2f} m")
    fields = "scene.slots_m" if name == "custom" else "scene.side_m"
    mounts = tuple(_mount(cardinal, index, scene) for index, cardinal in enumerate(CARDINALS))
    for mount in mounts:
        across, _, depth = ((np.c_[slots, np.zeros(len(slots))] - mount.position) @ mount.world_from_sensor).T
        near, far = depth.min() - config.dance.step_m, depth.max()
        if near < sensors.min_range_m or far > sensors.max_range_m:
            raise ConfigError(
                "layout",
                name,
                f"bodies within {sensors.min_range_m:g} to {sensors.max_range_m:g} m of the {mount.name} sensor "
                f"while it is faced, not {near:.2f} to {far:.2f} m (scene.sensor_distance_m, {fields})",
            )
        aside = float(np.arctan2(np.abs(across), depth - config.dance.step_m).max())
        if aside > sensors.horizontal_fov_rad / 2:
            raise ConfigError(
                "layout",
                name,
                f"bodies within {np.degrees(sensors.horizontal_fov_rad / 2):.1f} degrees of the {mount.name} sensor's "
                f"axis, also after a move forward, not {np.degrees(aside):.1f} (scene.sensor_distance_m, {fields})",
            )
    return Layout(slots[:-1], slots[-1], mounts)


def _slots(name: str, group: int, scene: SceneConfig) -> Array:
    if name == "custom":
        if len(scene.slots_m) != group + 1:
            raise ConfigError("scene.slots_m", scene.slots_m, f"{group + 1} slots: the dancers', then the robot's")
        return np.array(scene.slots_m, dtype=float)
    if scene.slots_m:
        raise ConfigError("scene.slots_m", scene.slots_m, f"only with layout custom; {name} has its own slots")
    if not 1 <= group <= 8:
        raise ConfigError("dancers", group, "1 to 8 dancers")
    if group > 3:
        return _ring(group + 1, scene) if name == "square" else _rows(group + 1, scene)
    half = scene.side_m / 2
    corners = np.array([[half, half], [-half, half], [half, -half], [-half, -half]])
    if name == "square":
        cos, sin = np.cos(scene.turn_rad), np.sin(scene.turn_rad)
        corners = corners @ np.array([[cos, sin], [-sin, cos]])
    return np.concatenate([corners[:group], corners[3:]])


def _ring(count: int, scene: SceneConfig) -> Array:
    """Slots on the circle through the square's corners, or on a wider one where they would be too close."""
    radius = max(scene.side_m / np.sqrt(2.0), APART_M / 2 / np.sin(np.pi / count))
    bearings = np.pi / 4 + scene.turn_rad + 2 * np.pi * np.arange(count) / count
    return np.asarray(radius * np.stack([np.cos(bearings), np.sin(bearings)], axis=1))


def _rows(count: int, scene: SceneConfig) -> Array:
    """Slots in aligned rows of three, as wide as two slots of the small groups and half of that again."""
    columns, lines = 3, -(-count // 3)
    gap = 0.75 * scene.side_m
    x = gap * (1.0 - np.arange(columns))
    y = gap * ((lines - 1) / 2 - np.arange(lines))
    places = np.stack([np.tile(x, lines), np.repeat(y, columns)], axis=1)
    return np.concatenate([places[: count - 1], places[-1:]])


def _mount(name: str, index: int, scene: SceneConfig) -> Mount:
    bearing = np.pi / 2 * (1 + index)
    outward = np.array([np.cos(bearing), np.sin(bearing), 0.0])
    position = scene.sensor_distance_m * outward + np.array([0.0, 0.0, scene.sensor_height_m])
    up = np.array([0.0, 0.0, 1.0])
    left = np.cross(up, -outward)
    return Mount(name, position, np.stack([left, up, -outward], axis=1))
