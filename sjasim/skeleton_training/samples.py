"""From scenes to what a forest learns from: features of pixels, the joint they belong to, where all joints are."""

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

WIDTH = 256
PLACE_M, JOINT_M = 0.04, 0.04
"""Standard deviations of the predicted place of a trunk and of a joint that pixels are shared out with."""
YAW_RAD, YAW_LOOSE_RAD, LOOSE = math.radians(9.0), math.radians(30.0), 0.15
"""Standard deviations of the tracked yaw, and of the share of cases in which it has gone astray."""
SCALE = 0.015
"""Standard deviation of the estimated over the true stature."""
_BASE = JOINT_INDEX["SpineBase"]


@dataclass(frozen=True, slots=True)
class ObservedScene:
    """One scene as the sensor takes it.

    Attributes:
        scene: foreground with owners.
        owner: (N,) true owner of every point, -1 for no dancer.
        joints: (D, 25, 3) true joints as points [m].
        yaw_rad: (D,) true yaws.
        persons: (D, 6) rows for the forests, with errors as tracking has them.
        counts: (D,) points of each.
        prior: (D, 25, 3) predicted joints.
    """

    scene: Foreground
    owner: NDArray[np.int64]
    joints: Array
    yaw_rad: Array
    persons: Array
    counts: Array
    prior: Array


class TrainingSensor:
    """A sensor that takes scenes.

    Args:
        seed: of its noise and of the errors of tracking.
        name: of the random stream.
    """

    def __init__(self, seed: int, name: str) -> None:
        config = SensorConfig()
        self._config = config
        self.intrinsics = Intrinsics.from_field_of_view(WIDTH, config.horizontal_fov_rad, config.vertical_fov_rad)
        self._rng = stream(seed, "training", name, "sensor")
        self._scene = Foreground.allocate(self.intrinsics)
        self._camera: DepthCamera | None = None

    def see(self, mount: Mount, scene: Scene) -> ObservedScene:
        """Take one scene; the foreground is valid until the next."""
        rng = self._rng
        if self._camera is None:
            self._camera = DepthCamera(mount, self.intrinsics)
        picture = self._camera.render(scene.geoms)
        limits = (self._config.min_range_m, self._config.max_range_m)
        depth = kinect_noise.add_kinect_noise(picture, scene.geoms.form, self.intrinsics.fx, limits, rng)
        extract_foreground(depth, self.intrinsics, float(mount.position[2]), self._scene)
        joints = (scene.joints_m - mount.position) @ mount.world_from_sensor
        joints[:, :, 1] += mount.position[2]
        places = joints[:, _BASE][:, [0, 2]] + PLACE_M * rng.standard_normal((len(joints), 2))
        shift = PLACE_M * rng.standard_normal((len(joints), 1, 3))
        prior = joints + shift + JOINT_M * rng.standard_normal(joints.shape)
        segmentation.assign_owners(self._scene, places, prior, np.full(2, np.nan))
        count = self._scene.count
        pixel = self._scene.pixel[:count]
        geom = picture.geom[pixel[:, 0], pixel[:, 1]]
        owner = np.where(geom >= 0, scene.geoms.owner[geom], -1)
        loose = rng.random(len(joints)) < LOOSE
        yaw = scene.yaw_rad + np.where(loose, YAW_LOOSE_RAD, YAW_RAD) * rng.standard_normal(len(joints))
        scales = scale_from_stature(scene.stature_m) * (1.0 + SCALE * rng.standard_normal(len(joints)))
        per_pixel = 1.0 / (self.intrinsics.fx * self.intrinsics.fy)
        body = measure_persons(self._scene, places, scales, per_pixel)
        return ObservedScene(
            self._scene, owner, joints, scene.yaw_rad, person_features(body, scales, yaw), body[:, 0], prior
        )


@dataclass(frozen=True, slots=True)
class Samples:
    """Pixels to learn from.

    Attributes:
        features: (N, F + 9).
        joint: (N,) nearest joint.
        offset: (N, 25, 3) to all joints: forward, up, left, over the scale [m].
        yaw: (N, 2) cosine and sine of the true yaw.
    """

    features: NDArray[np.float32]
    joint: NDArray[np.int64]
    offset: NDArray[np.float16]
    yaw: NDArray[np.float32]


def in_body(displacement: Array, persons: Array) -> Array:
    """Displacements (..., 3) of points in a person's frame, over their scale: forward, up, left [m].

    Args:
        displacement: x, height, z [m].
        persons: (..., 6) rows whose scale, cosine and sine count, without the coordinates' axis.
    """
    x, up, z = np.moveaxis(displacement, -1, 0)
    scale, cos, sin = persons[..., 3], persons[..., 4], persons[..., 5]
    return np.stack([-sin * x - cos * z, up, -cos * x + sin * z], axis=-1) / scale[..., None]


def gather(
    scenes: Iterable[tuple[Mount, Scene]], probes: NDArray[np.float16], each: int, seed: int, name: str
) -> Samples:
    """Draw pixels from scenes; rare joints' pixels are drawn more often than they come.

    Args:
        scenes: what to look at.
        probes: (F, 4) offsets of the features [m].
        each: pixels per person and scene.
        seed: of noise and drawing.
        name: of the random stream.
    """
    watcher, rng = TrainingSensor(seed, name), stream(seed, "training", name, "pixels")
    parts: list[tuple[NDArray[Any], ...]] = []
    for mount, scene in scenes:
        seen = watcher.see(mount, scene)
        count = seen.scene.count
        for k in range(len(seen.joints)):
            rows = np.flatnonzero((seen.owner == k) & (seen.scene.owner[:count] == k))
            if len(rows) < 40:
                continue
            points = seen.scene.point[rows].astype(float)
            away = seen.joints[k][None] - points[:, None]
            nearest = (away**2).sum(axis=2).argmin(axis=1)
            often = np.bincount(nearest, minlength=len(JOINTS))[nearest]
            chance = 1.0 / np.sqrt(often)
            drawn = rng.choice(len(rows), min(len(rows), each), replace=False, p=chance / chance.sum())
            features = point_features(seen.scene, rows[drawn], probes, watcher.intrinsics.fx, seen.persons[k])
            offset = in_body(away[drawn], seen.persons[k])
            yaw = np.tile([math.cos(seen.yaw_rad[k]), math.sin(seen.yaw_rad[k])], (len(drawn), 1))
            parts.append((features, nearest[drawn], offset.astype(np.float16), yaw.astype(np.float32)))
    return Samples(*(np.concatenate(column) for column in zip(*parts, strict=True)))
