"""Offscreen pictures of a scene, for stills, videos and the ``rgb_array`` mode of environments."""

from __future__ import annotations

import atexit
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..choreography.layout import Mount
from ..core.errors import SjasimError
from .physics import Physics

Picture = NDArray[np.uint8]
"""(H, W, 3) red, green and blue."""

FOV_DEG = 38.0
"""Vertical field of view of every camera [degrees]. A wider one would make the dancers in front look too large."""

MIN_PX = 16
"""Smallest width and height of a picture [pixels]."""

MAX_WIDTH_PX = 3840
"""Largest width of a picture [pixels]."""

MAX_HEIGHT_PX = 2160
"""Largest height of a picture [pixels]."""

HOUSING_M = (0.125, 0.035, 0.035)
"""Half the width, height and depth of a drawn sensor [m]."""

POST_RADIUS_M = 0.014
"""Radius of a drawn sensor's post [m]."""

FOOT_M = (0.14, 0.008)
"""Radius and half the height of the foot of that post [m]."""

POST_SETBACK_M = 0.05
"""Distance of the post behind the sensor's origin [m]."""

INACTIVE_RGBA = (0.20, 0.20, 0.22, 1.0)
"""Colour of a drawn sensor and its post."""

ACTIVE_RGBA = (0.20, 0.80, 0.35, 1.0)
"""Colour of the active sensor."""


class RenderError(SjasimError):
    """A picture cannot be rendered: no OpenGL or display, a size that is not allowed, or an unknown camera."""


@dataclass(frozen=True, slots=True)
class Camera:
    """Pose of a camera.

    Attributes:
        look_at: the point in the middle of the picture [m].
        distance_m: distance of the camera from that point.
        azimuth_rad: direction of view on the floor; 0 looks along world x.
        elevation_rad: positive looks down.
    """

    look_at: tuple[float, float, float] = (0.0, 0.0, 0.75)
    distance_m: float = 5.6
    azimuth_rad: float = -2.2
    elevation_rad: float = 0.38


CAMERAS = {
    "scene": Camera((0.0, 0.1, 0.55), 8.4, -2.08, 0.46),
    "dancers": Camera((0.0, 0.1, 0.78), 4.8, -2.08, 0.24),
    "north": Camera((0.0, 0.0, 0.80), 5.2, -np.pi / 2, 0.16),
    "top": Camera((0.0, 0.0, 0.0), 6.5, np.pi / 2, np.pi / 2 - 0.01),
}
"""Cameras by name: the whole scene from a corner, the dancers alone, from the north sensor, and from above."""


class Renderer:
    """Renders pictures of a scene without a display, and without any change to its state.

    Args:
        physics: the physics to render.
        width: width of the pictures [pixels].
        height: height of the pictures [pixels].
        mounts: sensors to draw. They are not part of the MuJoCo model.
        fine: whether to use detailed shadows and antialiasing, which takes two to three times as long.

    Raises:
        RenderError: there is no OpenGL, or the size is not allowed.
    """

    def __init__(
        self, physics: Physics, width: int = 960, height: int = 540, mounts: Sequence[Mount] = (), *, fine: bool = True
    ) -> None:
        self.check_size(width, height)
        self._physics = physics
        self._mounts = tuple(mounts)
        _set_quality(physics.model, width, height, fine=fine)
        try:
            self._renderer = mujoco.Renderer(physics.model, height, width)
        except (mujoco.FatalError, AttributeError, ImportError, RuntimeError, OSError) as error:
            raise RenderError(
                f"no OpenGL to draw pictures with ({_first_line(error)}): on Debian and Ubuntu install libegl1 "
                "(apt-get install libegl1), and leave MUJOCO_GL alone or set it to egl"
            ) from None

        _OPEN_RENDERERS.add(self)
        # Exit functions run in reverse order. MuJoCo registers its own with the first context, so ours must be
        # registered again after it.
        atexit.unregister(_close_all)
        atexit.register(_close_all)

        # Hide the sites, and the geoms that only collide.
        self._option = mujoco.MjvOption()
        self._option.sitegroup[:] = 0
        self._option.geomgroup[3] = 0

    @staticmethod
    def check_size(width: int, height: int) -> None:
        """Check that a picture of this size can be rendered.

        Raises:
            RenderError: the size is not allowed.
        """
        whole = isinstance(width, int) and isinstance(height, int)
        if not (whole and MIN_PX <= width <= MAX_WIDTH_PX and MIN_PX <= height <= MAX_HEIGHT_PX):
            allowed = f"{MIN_PX} x {MIN_PX} to {MAX_WIDTH_PX} x {MAX_HEIGHT_PX} pixels"
            raise RenderError(f"a picture of {width} x {height} is not allowed: {allowed}")

    def render(self, camera: str | Camera = "scene", active: str = "") -> Picture:
        """Render the present state.

        Args:
            camera: a name of `CAMERAS`, or a camera.
            active: name of the sensor that is drawn as active.

        Returns:
            (H, W, 3) uint8.

        Raises:
            RenderError: there is no camera of that name.
        """
        self._renderer.update_scene(self._physics.data, free_camera(camera), self._option)
        for mount in self._mounts:
            self._draw_sensor(mount, active=mount.name == active)
        return np.asarray(self._renderer.render(), dtype=np.uint8)

    def _draw_sensor(self, mount: Mount, *, active: bool) -> None:
        """Add a sensor and its post to the rendered scene."""
        middle_m = mount.position[2] / 2
        x_m, y_m, z_m = mount.position - POST_SETBACK_M * mount.world_from_sensor[:, 2]
        box = mujoco.mjtGeom.mjGEOM_BOX
        cylinder = mujoco.mjtGeom.mjGEOM_CYLINDER
        upright = np.eye(3)
        foot_radius_m, foot_half_m = FOOT_M

        colour = ACTIVE_RGBA if active else INACTIVE_RGBA
        self._add_geom(box, HOUSING_M, (x_m, y_m, z_m), mount.world_from_sensor, colour)
        self._add_geom(cylinder, (POST_RADIUS_M, middle_m, 0.0), (x_m, y_m, middle_m), upright, INACTIVE_RGBA)
        self._add_geom(cylinder, (foot_radius_m, foot_half_m, 0.0), (x_m, y_m, foot_half_m), upright, INACTIVE_RGBA)

    def _add_geom(
        self,
        shape: mujoco.mjtGeom,
        size_m: tuple[float, float, float],
        position_m: tuple[float, float, float],
        rotation: NDArray[np.float64],
        rgba: tuple[float, float, float, float],
    ) -> None:
        scene = self._renderer.scene
        geom = scene.geoms[scene.ngeom]
        mujoco.mjv_initGeom(geom, shape, np.array(size_m), np.array(position_m), rotation.ravel(), np.array(rgba))
        scene.ngeom += 1

    def close(self) -> None:
        """Release the graphics memory."""
        _OPEN_RENDERERS.discard(self)
        self._renderer.close()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


_OPEN_RENDERERS: weakref.WeakSet[Renderer] = weakref.WeakSet()
"""Renderers whose OpenGL contexts have not been released."""


def _close_all() -> None:
    """Release all OpenGL contexts at exit, before MuJoCo closes the display that they need."""
    for renderer in tuple(_OPEN_RENDERERS):
        renderer.close()


def _set_quality(model: mujoco.MjModel, width: int, height: int, *, fine: bool) -> None:
    """Set size, field of view, shadows and antialiasing of a model's pictures."""
    visual = model.vis.global_
    visual.offwidth = max(visual.offwidth, width)
    visual.offheight = max(visual.offheight, height)
    visual.fovy = FOV_DEG

    quality = model.vis.quality
    quality.shadowsize = 4096 if fine else 1024
    quality.offsamples = 4 if fine else 0


def free_camera(camera: str | Camera) -> mujoco.MjvCamera:
    """MuJoCo's camera for a `Camera`, or for a name of `CAMERAS`.

    Raises:
        RenderError: there is no camera of that name.
    """
    if isinstance(camera, str):
        if camera not in CAMERAS:
            raise RenderError(f"no camera named {camera!r}: known are {', '.join(CAMERAS)}")
        camera = CAMERAS[camera]

    view = mujoco.MjvCamera()
    view.type = mujoco.mjtCamera.mjCAMERA_FREE
    view.lookat[:] = camera.look_at
    view.distance = camera.distance_m
    view.azimuth = np.degrees(camera.azimuth_rad)
    # MuJoCo counts the elevation of the view upwards.
    view.elevation = -np.degrees(camera.elevation_rad)
    return view


def _first_line(error: BaseException) -> str:
    return str(error).partition("\n")[0] or type(error).__name__
