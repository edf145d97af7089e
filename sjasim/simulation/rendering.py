"""Offscreen pictures of a stage, for stills, films and environments that show themselves."""

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
"""(H, W, 3) red, green, blue."""

FOV_DEG = 38.0
"""Vertical field of view of every camera; a moderate lens, so that the dancers in front do not dwarf the others."""


_HOUSING_M = (0.125, 0.035, 0.035)
_DARK, _GREEN = (0.20, 0.20, 0.22, 1.0), (0.20, 0.80, 0.35, 1.0)


class RenderError(SjasimError):
    """No picture can be made on this machine, or none of this size or from this camera."""


@dataclass(frozen=True, slots=True)
class Camera:
    """Where a picture is taken from.

    Attributes:
        look_at: the point in the picture's middle [m].
        distance_m: from the camera to it.
        azimuth_rad: direction of view on the floor; 0 looks along world x.
        elevation_rad: positive looks down.
    """

    look_at: tuple[float, float, float] = (0.0, 0.0, 0.75)
    distance_m: float = 5.6
    azimuth_rad: float = -2.2
    elevation_rad: float = 0.38


CAMERAS = {
    "room": Camera((0.0, 0.1, 0.55), 8.4, -2.08, 0.46),
    "dancers": Camera((0.0, 0.1, 0.78), 4.8, -2.08, 0.24),
    "north": Camera((0.0, 0.0, 0.80), 5.2, -np.pi / 2, 0.16),
    "top": Camera((0.0, 0.0, 0.0), 6.5, np.pi / 2, np.pi / 2 - 0.01),
}
"""Cameras by name: the whole room from a corner, the group alone, from the north sensor, and from above."""


class Renderer:
    """Takes pictures of a stage without a display. It never changes the stage.

    Args:
        stage: what to take pictures of.
        width: of the picture, in pixels.
        height: the same.
        mounts: sensors to draw, which are no part of the stage.
        fine: sharp shadows and smooth edges, at two to three times the cost.

    Raises:
        RenderError: there is no OpenGL to draw with, or the size is not allowed.
    """

    def __init__(
        self, physics: Physics, width: int = 960, height: int = 540, mounts: Sequence[Mount] = (), *, fine: bool = True
    ) -> None:
        self.check(width, height)
        self._physics, self._mounts = physics, tuple(mounts)
        visual = physics.model.vis.global_
        visual.offwidth, visual.offheight = max(visual.offwidth, width), max(visual.offheight, height)
        visual.fovy = FOV_DEG
        quality = physics.model.vis.quality
        quality.shadowsize, quality.offsamples = (4096, 4) if fine else (1024, 0)
        try:
            self._renderer = mujoco.Renderer(physics.model, height, width)
        except (mujoco.FatalError, AttributeError, ImportError, RuntimeError, OSError) as error:
            raise RenderError(
                f"no OpenGL to draw pictures with ({_first_line(error)}): on Debian and Ubuntu install libegl1 "
                "(apt-get install libegl1), and leave MUJOCO_GL alone or set it to egl"
            ) from None
        _OPEN.add(self)
        atexit.unregister(_close_all)
        atexit.register(_close_all)
        self._option = mujoco.MjvOption()
        self._option.sitegroup[:] = 0
        self._option.geomgroup[3] = 0

    @staticmethod
    def check(width: int, height: int) -> None:
        """Whether there can be a picture of this size.

        Raises:
            RenderError: there cannot.
        """
        whole = isinstance(width, int) and isinstance(height, int)
        if not (whole and 16 <= width <= 3840 and 16 <= height <= 2160):
            raise RenderError(f"a picture of {width} x {height} is not allowed: 16 x 16 to 3840 x 2160 pixels")

    def frame(self, camera: str | Camera = "room", active: str = "") -> Picture:
        """A picture of this moment.

        Args:
            camera: one of `CAMERAS`, or a camera.
            active: name of the sensor whose light is on.

        Returns:
            (H, W, 3) uint8.

        Raises:
            RenderError: no camera of that name.
        """
        self._renderer.update_scene(self._physics.data, free_camera(camera), self._option)
        for mount in self._mounts:
            self._draw(mount, mount.name == active)
        return np.asarray(self._renderer.render(), dtype=np.uint8)

    def _draw(self, mount: Mount, active: bool) -> None:
        """A sensor on its post; its lamp is green while it is active."""
        height = mount.position[2]
        stand = mount.position - 0.05 * mount.world_from_sensor[:, 2]
        post = mujoco.mjtGeom.mjGEOM_CYLINDER
        parts = [
            (mujoco.mjtGeom.mjGEOM_BOX, _HOUSING_M, stand, _GREEN if active else _DARK),
            (post, (0.014, height / 2, 0.0), np.array([stand[0], stand[1], height / 2]), _DARK),
            (post, (0.14, 0.008, 0.0), np.array([stand[0], stand[1], 0.008]), _DARK),
        ]
        for form, size, place, colour in parts:
            scene = self._renderer.scene
            turn = mount.world_from_sensor if form == mujoco.mjtGeom.mjGEOM_BOX else np.eye(3)
            mujoco.mjv_initGeom(scene.geoms[scene.ngeom], form, np.array(size), place, turn.ravel(), np.array(colour))
            scene.ngeom += 1

    def close(self) -> None:
        """Give the graphics memory back."""
        _OPEN.discard(self)
        self._renderer.close()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


_OPEN: weakref.WeakSet[Renderer] = weakref.WeakSet()


def _close_all() -> None:
    """At the interpreter's end, before MuJoCo takes the OpenGL display away from contexts that are still open.

    What is registered last runs first, and MuJoCo registers its own with the first context.
    """
    for renderer in tuple(_OPEN):
        renderer.close()


def free_camera(camera: str | Camera) -> mujoco.MjvCamera:
    """MuJoCo's camera for one of ours, or the one of a name.

    Raises:
        RenderError: no camera of that name.
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
    view.elevation = -np.degrees(camera.elevation_rad)
    return view


def _first_line(error: BaseException) -> str:
    return str(error).partition("\n")[0] or type(error).__name__
