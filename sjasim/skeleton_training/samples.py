"""Training samples: pixels of random scenes with their features, nearest joint, and offsets to all joints."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..choreography.layout import Mount
from ..config import SensorConfig
from ..core import Array
from ..core.clock import stream
from ..sensors import kinect_noise
from ..sensors.depth_camera import DepthCamera, Intrinsics
from ..sensors.skeleton import segmentation
from ..sensors.skeleton.estimator import person_features, scale_from_stature
from ..sensors.skeleton.foreground import Foreground, extract_foreground
from ..sensors.skeleton.forest import point_features
from ..sensors.skeleton.person_measures import measure_persons
from .scenes import Scene

WIDTH_PX = 256
"""Columns of the depth image."""

TRUNK_ERROR_M = 0.04
"""Standard deviation of the predicted place of a trunk, by which pixels are assigned to persons."""

JOINT_ERROR_M = 0.04
"""Standard deviation of the predicted place of a joint."""

YAW_ERROR_RAD = math.radians(9.0)
"""Standard deviation of the tracked heading."""

LARGE_YAW_ERROR_RAD = math.radians(30.0)
"""Standard deviation of the tracked heading after tracking has gone astray."""

LARGE_YAW_ERROR_SHARE = 0.15
"""Share of persons with the large heading error."""

SCALE_ERROR = 0.015
"""Standard deviation of the estimated over the true stature."""

MIN_PIXELS = 40
"""Smallest number of pixels of a person from which samples are drawn."""

_BASE = JOINT_INDEX["SpineBase"]


@dataclass(frozen=True, slots=True)
class ObservedScene:
    """One scene of D dancers as the sensor sees it.

    Attributes:
        foreground: points of the foreground with their owners; valid until the next scene.
        owner: (N,) true owner of each point, -1 for no dancer.
        joints: (D, 25, 3) true joints as points: x, height, z [m].
        yaw_rad: (D,) true headings relative to facing the sensor.
        persons: (D, 6) rows of person features for the forests, with tracking errors.
        counts: (D,) number of points of each dancer.
        prior: (D, 25, 3) predicted joints [m].
    """

    foreground: Foreground
    owner: NDArray[np.int64]
    joints: Array
    yaw_rad: Array
    persons: Array
    counts: Array
    prior: Array


class TrainingSensor:
    """A depth sensor with the segmentation of depth sensing and simulated tracking errors.

    Args:
        seed: seed of depth noise and tracking errors.
        name: name of the random stream.

    Attributes:
        intrinsics: intrinsics of the camera.
    """

    def __init__(self, seed: int, name: str) -> None:
        config = SensorConfig()
        self._range_m = (config.min_range_m, config.max_range_m)
        self.intrinsics = Intrinsics.from_field_of_view(WIDTH_PX, config.horizontal_fov_rad, config.vertical_fov_rad)
        self._rng = stream(seed, "training", name, "sensor")
        self._foreground = Foreground.allocate(self.intrinsics)
        self._camera: DepthCamera | None = None

    def observe_scene(self, mount: Mount, scene: Scene) -> ObservedScene:
        """Return a scene as the sensor sees it; its foreground is valid until the next call."""
        rng = self._rng
        joints = joint_points(mount, scene)

        geom = self._render_foreground(mount, scene)
        places = joints[:, _BASE][:, [0, 2]] + TRUNK_ERROR_M * rng.standard_normal((len(joints), 2))
        # The prediction of a joint has the error of the trunk and one of its own.
        shift = TRUNK_ERROR_M * rng.standard_normal((len(joints), 1, 3))
        prior = joints + shift + JOINT_ERROR_M * rng.standard_normal(joints.shape)
        segmentation.assign_owners(self._foreground, places, prior, np.full(2, np.nan))

        pixel = self._foreground.pixel[: self._foreground.count]
        point_geom = geom[pixel[:, 0], pixel[:, 1]]
        owner = np.where(point_geom >= 0, scene.geoms.owner[point_geom], -1)

        # Tracking sometimes follows a wrong heading; the forests have to cope with that.
        large_error = rng.random(len(joints)) < LARGE_YAW_ERROR_SHARE
        yaw_error = np.where(large_error, LARGE_YAW_ERROR_RAD, YAW_ERROR_RAD)
        yaw = scene.yaw_rad + yaw_error * rng.standard_normal(len(joints))
        scales = scale_from_stature(scene.stature_m) * (1.0 + SCALE_ERROR * rng.standard_normal(len(joints)))
        per_pixel = 1.0 / (self.intrinsics.fx * self.intrinsics.fy)
        body = measure_persons(self._foreground, places, scales, per_pixel)
        persons = person_features(body, scales, yaw)
        return ObservedScene(self._foreground, owner, joints, scene.yaw_rad, persons, body[:, 0], prior)

    def _render_foreground(self, mount: Mount, scene: Scene) -> NDArray[np.int16]:
        """Extract the foreground of a noisy depth image; return (H, W) the geom of each pixel, -1 for none."""
        # All scenes have the same mount.
        if self._camera is None:
            self._camera = DepthCamera(mount, self.intrinsics)
        picture = self._camera.render(scene.geoms)
        depth = kinect_noise.add_kinect_noise(picture, scene.geoms.form, self.intrinsics.fx, self._range_m, self._rng)
        extract_foreground(depth, self.intrinsics, float(mount.position[2]), self._foreground)
        return picture.geom


@dataclass(frozen=True, slots=True)
class Samples:
    """Pixels to learn from.

    Attributes:
        features: (N, F + 9) features of each pixel.
        joint: (N,) nearest joint.
        offset: (N, 25, 3) offsets to all joints: forward, up, left, over the person's scale [m].
        yaw: (N, 2) cosine and sine of the true heading.
    """

    features: NDArray[np.float32]
    joint: NDArray[np.int64]
    offset: NDArray[np.float16]
    yaw: NDArray[np.float32]


def joint_points(mount: Mount, scene: Scene) -> Array:
    """Return (D, 25, 3) true joints as the sensor's points: x to its left, height, z away from it [m]."""
    joints = (scene.joints_m - mount.position) @ mount.world_from_sensor
    joints[:, :, 1] += mount.position[2]
    return np.asarray(joints)


def in_person_frame(displacement: Array, persons: Array) -> Array:
    """Return displacements in the frame of a person: forward, up, left, over the person's scale [m].

    Args:
        displacement: (..., 3) x, height, z [m].
        persons: (..., 6) rows of person features, of which scale and cosine and sine of the heading are used.
    """
    # Forward is the direction of the heading, which is 0 when the person faces the sensor.
    x, up, z = np.moveaxis(displacement, -1, 0)
    scale = persons[..., 3]
    cos = persons[..., 4]
    sin = persons[..., 5]
    return np.stack([-sin * x - cos * z, up, -cos * x + sin * z], axis=-1) / scale[..., None]


def draw_samples(
    scenes: Iterable[tuple[Mount, Scene]], probes: NDArray[np.float16], each: int, seed: int, name: str
) -> Samples:
    """Draw pixels of all dancers of some scenes.

    Pixels of joints that have few pixels are drawn with a larger probability.

    Args:
        scenes: the scenes, with the mount of the sensor.
        probes: (F, 4) offsets of the depth-difference features [m].
        each: number of pixels per dancer and scene.
        seed: seed of noise and drawing.
        name: name of the random stream.
    """
    sensor = TrainingSensor(seed, name)
    rng = stream(seed, "training", name, "pixels")
    parts: list[tuple[NDArray[Any], ...]] = []
    for mount, scene in scenes:
        observed = sensor.observe_scene(mount, scene)
        foreground = observed.foreground
        for k in range(len(observed.joints)):
            # Pixels that belong to the dancer and that segmentation assigned correctly.
            rows = np.flatnonzero((observed.owner == k) & (foreground.owner[: foreground.count] == k))
            if len(rows) < MIN_PIXELS:
                continue
            offsets = observed.joints[k][None] - foreground.point[rows].astype(float)[:, None]
            nearest = (offsets**2).sum(axis=2).argmin(axis=1)
            drawn = _draw_evenly(rng, nearest, each)

            person = observed.persons[k]
            features = point_features(foreground, rows[drawn], probes, sensor.intrinsics.fx, person)
            offset = in_person_frame(offsets[drawn], person)
            heading = [math.cos(observed.yaw_rad[k]), math.sin(observed.yaw_rad[k])]
            yaw = np.tile(heading, (len(drawn), 1))
            parts.append((features, nearest[drawn], offset.astype(np.float16), yaw.astype(np.float32)))
    return Samples(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _draw_evenly(rng: np.random.Generator, nearest: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return indices of pixels; the weight of a pixel falls with the square root of its joint's number of pixels."""
    pixels_of_joint = np.bincount(nearest, minlength=len(JOINTS))[nearest]
    weight = 1.0 / np.sqrt(pixels_of_joint)
    return rng.choice(len(nearest), min(len(nearest), count), replace=False, p=weight / weight.sum())
