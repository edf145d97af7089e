"""Sensing route `depth`: skeletons estimated from simulated depth images alone."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..choreography.layout import Mount
from ..config import SessionConfig
from ..core import Array, BoolArray, Geoms, IntArray, SceneView, Skeletons
from ..core.registry import register
from . import kinect_noise
from .depth_camera import DepthCamera, Intrinsics, RenderedDepth
from .joint_occlusion import BODY_DEPTH_M
from .skeleton.estimator import SkeletonEstimator

NOT_A_DANCER = -1
"""Index of the dancer behind an estimated person that is near no dancer."""

IMAGE_MARGIN_M = 1.0
"""How much farther a depth image reaches than persons are tracked (assumed).

Without it, somebody who sways across the limit would be cut in half, which looks like a step. A Kinect v2's images
reach 8 m, of which 4.5 m count for persons.
"""

MAX_ASSIGNMENT_M = 0.60
"""A person farther than this from every dancer is assigned to none of them; for the record only (assumed)."""

_SPINE_BASE = JOINT_INDEX["SpineBase"]


@register("sensing", "depth")
class DepthSensing:
    """Skeletons of one sensor, estimated from simulated depth images.

    An exact depth image is rendered, gets the noise of a Kinect v2, and is handed to a `SkeletonEstimator`, which sees
    nothing of the truth. Only ``dancers``, ``visible`` and ``visibility`` use the truth, for the record.

    Args:
        mount: position and orientation of the sensor.
        config: the session; its ``sensors`` hold resolution, field of view, range and frame loss.
        rng: the sensor's own random stream.
    """

    def __init__(self, mount: Mount, config: SessionConfig, rng: np.random.Generator) -> None:
        self._noise_rng, self._loss_rng = rng.spawn(2)
        self._mount = mount
        self._config = config.sensors
        self.intrinsics = Intrinsics.from_field_of_view(
            config.sensors.width_px, config.sensors.horizontal_fov_rad, config.sensors.vertical_fov_rad
        )
        self._camera = DepthCamera(mount, self.intrinsics)
        self._last: _LastFrame | None = None

    @cached_property
    def _estimator(self) -> SkeletonEstimator:
        return SkeletonEstimator(self.intrinsics, float(self._mount.position[2]), self._config.max_range_m)

    def frame(self, view: SceneView) -> NDArray[np.uint16]:
        """Return the depth image of this instant: (H, W) whole millimetres, 0 where there is no depth."""
        # Joints are copied because the view changes with the scene; the image stays valid until the next frame.
        geoms = view.geoms
        image = self._camera.render(geoms)
        near_m = self._config.min_range_m
        far_m = self._config.max_range_m
        self._last = _LastFrame(self._mount, self.intrinsics, (near_m, far_m), image, geoms, np.array(view.joints_m))

        image_range_m = (near_m, far_m + IMAGE_MARGIN_M)
        return kinect_noise.add_kinect_noise(image, geoms.form, self.intrinsics.fx, image_range_m, self._noise_rng)

    def sample(self, view: SceneView) -> Skeletons | None:
        """Return the skeletons of all persons that are tracked at this instant, or None if the frame was lost.

        Args:
            view: the scene; its time must not decrease from one call to the next.
        """
        if self._config.frame_loss and self._loss_rng.random() < self._config.frame_loss:
            return None

        depth_mm = self.frame(view)
        skeletons = self._estimator.update(view.time_s, depth_mm)
        assert self._last is not None
        self._last.skeletons = skeletons
        return skeletons

    @property
    def dancers(self) -> IntArray:
        """(P,) index of the dancer behind each person of the last frame, -1 for none; for the record only."""
        return self._last.dancers if self._last else np.zeros(0, dtype=np.int64)

    @property
    def visibility(self) -> BoolArray:
        """(D, 25) whether the last frame could show each joint of every dancer, tracked or not; for the record only."""
        assert self._last is not None, "no frame has been rendered yet"
        return self._last.visible

    @property
    def visible(self) -> BoolArray:
        """(P, 25) the rows of ``visibility`` for the dancers behind the last frame's persons; for the record only."""
        if self._last is None:
            return np.zeros((0, len(JOINTS)), dtype=bool)

        # A row of its own, the last one, serves persons that are no dancer: their index is -1.
        nobody = np.zeros((1, len(JOINTS)), dtype=bool)
        return np.concatenate([self._last.visible, nobody])[self._last.dancers]


class _LastFrame:
    """True state at the last frame, evaluated only when the record asks; valid until the camera's next image."""

    def __init__(
        self,
        mount: Mount,
        intrinsics: Intrinsics,
        range_m: tuple[float, float],
        image: RenderedDepth,
        geoms: Geoms,
        joints_m: Array,
    ) -> None:
        self._intrinsics = intrinsics
        self._range_m = range_m
        self._image = image
        self._owner = geoms.owner
        self._joints_m = (joints_m - mount.position) @ mount.world_from_sensor
        self.skeletons: Skeletons | None = None

    @cached_property
    def dancers(self) -> IntArray:
        """(P,) nearest dancer by the floor distance of SpineBase, -1 where none is near."""
        if self.skeletons is None:
            return np.zeros(0, dtype=np.int64)

        estimated = self.skeletons.joints[:, _SPINE_BASE]
        true = self._joints_m[:, _SPINE_BASE]
        x = estimated[:, None, 0] - true[None, :, 0]
        z = estimated[:, None, 2] - true[None, :, 2]

        # A joint that is not tracked is NaN and near nobody.
        distance = np.nan_to_num(np.sqrt(x * x + z * z), nan=np.inf)
        return np.asarray(np.where(distance.min(axis=1) < MAX_ASSIGNMENT_M, distance.argmin(axis=1), NOT_A_DANCER))

    @cached_property
    def visible(self) -> BoolArray:
        """(D, 25) joints in range whose pixel shows nothing in front of them but the dancer's own body."""
        x, y, z = np.moveaxis(self._joints_m, 2, 0)
        near_m, far_m = self._range_m
        in_range = (near_m <= z) & (z <= far_m)
        # Joints out of range are replaced, so that none is divided by zero.
        depth = np.where(in_range, z, 1.0)

        height, width = self._image.geom.shape
        u = np.rint((width - 1) / 2 + self._intrinsics.fx * x / depth)
        v = np.rint((height - 1) / 2 - self._intrinsics.fy * y / depth)
        in_image = in_range & (u >= 0.0) & (u < width) & (v >= 0.0) & (v < height)

        out = np.zeros(in_image.shape, dtype=bool)
        dancer, joint = np.nonzero(in_image)
        row = v[in_image].astype(np.int64)
        column = u[in_image].astype(np.int64)
        geom = self._image.geom[row, column]
        own = (geom >= 0) & (self._owner[geom] == dancer)
        body_depth = np.where(own, BODY_DEPTH_M[joint], 0.0)
        out[in_image] = self._image.depth_m[row, column] >= z[in_image] - body_depth
        return out
