"""Depth sensing: what a sensor makes of the stage with nothing but its depth images."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..choreography.layout import Mount
from ..config import SessionConfig
from ..core import Array, Geoms, IntArray, SceneView, Skeletons
from ..core.registry import register
from . import kinect_noise
from .depth_camera import DepthCamera, Intrinsics, RenderedDepth
from .joint_occlusion import BODY_DEPTH_M
from .skeleton.estimator import SkeletonEstimator

BoolArray = NDArray[np.bool_]

NOT_A_DANCER = -1
IMAGE_MARGIN_M = 1.0
"""So much farther than the farthest tracked person a depth image reaches: who sways beyond that is not cut in half,
which would look like a step, but inferred (assumed; a Kinect v2's images reach 8 m, of which 4.5 count for persons)."""
MAX_ASSIGNMENT_M = 0.60
"""A person farther than this from every dancer is nobody (for the record only)."""
_BASE = JOINT_INDEX["SpineBase"]


@register("sensing", "depth")
class DepthSensing:
    """One sensor's skeletons from simulated depth images.

    A frame is exact depth, made as bad as a Kinect v2's, and handed to a `SkeletonEstimator`; nothing of the truth
    reaches that. Only ``dancers`` and ``visible`` look at the truth, when the record asks for them.

    Args:
        mount: where the sensor is.
        config: the session, whose ``sensors`` say resolution, field of view, range and loss.
        rng: the sensor's own random stream.
    """

    def __init__(self, mount: Mount, config: SessionConfig, rng: np.random.Generator) -> None:
        self._noises, self._losses = rng.spawn(2)
        self._mount = mount
        self._config = sensors = config.sensors
        self.intrinsics = Intrinsics.from_field_of_view(
            sensors.width_px, sensors.horizontal_fov_rad, sensors.vertical_fov_rad
        )
        self._camera = DepthCamera(mount, self.intrinsics)
        self._last: _Last | None = None

    @cached_property
    def _estimator(self) -> SkeletonEstimator:
        return SkeletonEstimator(self.intrinsics, float(self._mount.position[2]), self._config.max_range_m)

    def frame(self, view: SceneView) -> NDArray[np.uint16]:
        """(H, W) depth image of this instant in whole millimetres, 0 where there is none."""
        geoms = view.geoms
        picture = self._camera.render(geoms)
        near_m, far_m = self._config.min_range_m, self._config.max_range_m
        self._last = _Last(self._mount, self.intrinsics, (near_m, far_m), picture, geoms, np.array(view.joints_m))
        return kinect_noise.add_kinect_noise(
            picture, geoms.form, self.intrinsics.fx, (near_m, far_m + IMAGE_MARGIN_M), self._noises
        )

    def sample(self, view: SceneView) -> Skeletons | None:
        """See the stage at this instant.

        Args:
            view: the stage; times of successive calls must not fall.

        Returns:
            the skeletons of everybody who is followed, or None if the frame was lost.
        """
        if self._config.frame_loss and self._losses.random() < self._config.frame_loss:
            return None
        depth_mm = self.frame(view)
        skeletons = self._estimator.update(view.time_s, depth_mm)
        assert self._last is not None
        self._last.skeletons = skeletons
        return skeletons

    @property
    def dancers(self) -> IntArray:
        """(P,) index of the dancer behind each row of the last frame, -1 for nobody; only for the record."""
        return self._last.dancers if self._last else np.zeros(0, dtype=np.int64)

    @property
    def visibility(self) -> BoolArray:
        """(D, 25) which joints of every dancer the last frame could see, tracked or not; only for the record."""
        assert self._last is not None, "no frame has been taken yet"
        return self._last.visible

    @property
    def visible(self) -> BoolArray:
        """(P, 25) which joints of those dancers the last frame could see; only for the record."""
        if self._last is None:
            return np.zeros((0, len(JOINTS)), dtype=bool)
        seen = np.concatenate([self._last.visible, np.zeros((1, len(JOINTS)), dtype=bool)])
        return seen[self._last.dancers]


@njit(cache=True, error_model="numpy")
def _look(
    joints: Array, fx: float, fy: float, range_m: tuple[float, float], geom: NDArray[np.int16], depth: Array,
    owner: IntArray, out: BoolArray,
) -> None:  # fmt: skip
    """Mark the joints (D, 25, 3) in range whose pixel shows nothing before them but their own dancer's flesh."""
    height, width = geom.shape
    for d in range(joints.shape[0]):
        for j in range(joints.shape[1]):
            x, y, z = joints[d, j]
            if range_m[0] <= z <= range_m[1]:
                u, v = np.rint((width - 1) / 2 + fx * x / z), np.rint((height - 1) / 2 - fy * y / z)
                if 0.0 <= u < width and 0.0 <= v < height:
                    row, column = int(v), int(u)
                    g = geom[row, column]
                    own = g >= 0 and owner[g] == d
                    out[d, j] = depth[row, column] >= z - (BODY_DEPTH_M[j] if own else 0.0)


@njit(cache=True)
def _name(seen: Array, joints: Array, out: IntArray) -> None:
    """Write which dancer of (D, 25, 3) is nearest to each person of (P, 25, 3), by SpineBase over the floor."""
    for p in range(len(seen)):
        best = MAX_ASSIGNMENT_M
        for d in range(len(joints)):
            x, z = seen[p, _BASE, 0] - joints[d, _BASE, 0], seen[p, _BASE, 2] - joints[d, _BASE, 2]
            away = math.sqrt(x * x + z * z)
            if away < best:
                best, out[p] = away, d


class _Last:
    """The last frame's truth, looked at when somebody asks; valid until the camera's next picture."""

    def __init__(
        self, mount: Mount, intrinsics: Intrinsics, range_m: tuple[float, float], picture: RenderedDepth, geoms: Geoms,
        joints_m: Array,
    ) -> None:  # fmt: skip
        self._intrinsics, self._range_m = intrinsics, range_m
        self._picture = picture
        self._owner = geoms.owner
        self._joints = (joints_m - mount.position) @ mount.world_from_sensor
        self.skeletons: Skeletons | None = None

    @cached_property
    def dancers(self) -> IntArray:
        """(P,) nearest dancer by SpineBase, -1 for nobody near."""
        out = np.full(0 if self.skeletons is None else len(self.skeletons.persons), NOT_A_DANCER, dtype=np.int64)
        if self.skeletons is not None:
            _name(self.skeletons.joints, self._joints, out)
        return out

    @cached_property
    def visible(self) -> BoolArray:
        """(D, 25) joints whose pixel shows nothing before them but their own dancer's flesh."""
        pinhole, picture = self._intrinsics, self._picture
        out = np.zeros(self._joints.shape[:2], dtype=bool)
        _look(self._joints, pinhole.fx, pinhole.fy, self._range_m, picture.geom, picture.depth_m, self._owner, out)
        return out
