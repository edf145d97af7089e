"""Pictures of a stage: off-screen ones, and a window where there is a display."""

from __future__ import annotations

import os
import sys
import weakref

import mujoco
import numpy as np
from numpy.typing import NDArray

from .errors import SjasimError
from .stage import Stage

LOOK_AT_M = (0.0, 0.0, 0.75)
DISTANCE_M = 5.2
AZIMUTH_DEG, ELEVATION_DEG = 60.0, -22.0
"""Where the picture is taken from: over the group's shoulder, everyone in it; chosen by eye."""

NO_GL = (
    "no off-screen OpenGL on this machine ({reason}): on Debian or Ubuntu install the package libegl1 "
    "(apt-get install libegl1), or libosmesa6 and set MUJOCO_GL=osmesa"
)
NO_DISPLAY = (
    "render_mode 'human' needs a display, and there is none ({reason}): use 'rgb_array', or run under xvfb-run"
)


class Pictures:
    """Off-screen pictures of a stage.

    Args:
        stage: what is seen.
        width: [px].
        height: [px].

    Raises:
        SjasimError: neither EGL nor OSMesa works here; the message names the package to install.
    """

    def __init__(self, stage: Stage, width: int = 640, height: int = 480) -> None:
        self._stage = stage
        offscreen = stage.model.vis.global_
        if not (1 <= width <= offscreen.offwidth and 1 <= height <= offscreen.offheight):
            raise SjasimError(
                f"a picture of {width} x {height} is not allowed: up to {offscreen.offwidth} x {offscreen.offheight}"
            )
        try:
            self._renderer = mujoco.Renderer(stage.model, height, width)
        except (AttributeError, ImportError, RuntimeError, mujoco.FatalError) as problem:
            raise SjasimError(NO_GL.format(reason=str(problem).splitlines()[0])) from problem
        # Also at the interpreter's end, while OpenGL can still be told.
        self._finish = weakref.finalize(self, self._renderer.close)
        self._camera = camera()

    def picture(self) -> NDArray[np.uint8]:
        """(H, W, 3) what the camera sees now."""
        self._renderer.update_scene(self._stage.data, self._camera)
        return np.array(self._renderer.render(), dtype=np.uint8)

    def close(self) -> None:
        """Give the OpenGL context back."""
        self._finish()


class Window:
    """MuJoCo's own viewer, kept up to date with a stage.

    Args:
        stage: what is seen.

    Raises:
        SjasimError: there is no display.
    """

    def __init__(self, stage: Stage) -> None:
        self.check()
        import mujoco.viewer

        self._viewer = mujoco.viewer.launch_passive(stage.model, stage.data, show_left_ui=False, show_right_ui=False)
        with self._viewer.lock():
            view = camera()
            for name in ("lookat", "distance", "azimuth", "elevation"):
                setattr(self._viewer.cam, name, getattr(view, name))

    @staticmethod
    def check() -> None:
        """Refuse where a window would end the process instead of raising.

        Raises:
            SjasimError: there is no display, or none that answers.
        """
        if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise SjasimError(NO_DISPLAY.format(reason="neither DISPLAY nor WAYLAND_DISPLAY is set"))
        import glfw

        if not glfw.init() or not glfw.get_primary_monitor():
            raise SjasimError(NO_DISPLAY.format(reason="no monitor answers"))

    def picture(self) -> None:
        """Show the stage as it is now; after the user has closed the window nothing happens."""
        if self._viewer.is_running():
            self._viewer.sync()

    def close(self) -> None:
        """Close the window."""
        self._viewer.close()


def camera() -> mujoco.MjvCamera:
    """The view that pictures and windows begin with."""
    view = mujoco.MjvCamera()
    view.type = mujoco.mjtCamera.mjCAMERA_FREE
    view.lookat = LOOK_AT_M
    view.distance, view.azimuth, view.elevation = DISTANCE_M, AZIMUTH_DEG, ELEVATION_DEG
    return view
