"""Pictures of a stage: off-screen ones, and a window where there is a display."""

from __future__ import annotations

import atexit
import os
import sys
import threading
import time
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
NO_DISPLAY = "render_mode 'human' needs a display, and there is none ({reason}): use 'rgb_array', or run under xvfb-run"


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
        self._camera = camera()
        _OPEN.add(self)
        atexit.unregister(_close_all)
        atexit.register(_close_all)

    def picture(self) -> NDArray[np.uint8]:
        """(H, W, 3) what the camera sees now."""
        self._renderer.update_scene(self._stage.data, self._camera)
        return np.array(self._renderer.render(), dtype=np.uint8)

    def close(self) -> None:
        """Give the OpenGL context back."""
        _OPEN.discard(self)
        self._renderer.close()


_OPEN: weakref.WeakSet[Pictures] = weakref.WeakSet()


def _close_all() -> None:
    """At the interpreter's end, before MuJoCo takes the OpenGL display away from contexts that are still open.

    What is registered last runs first, and MuJoCo registers its own with the first context.
    """
    for pictures in tuple(_OPEN):
        pictures.close()


class Window:
    """MuJoCo's own viewer, kept up to date with a stage, no faster than in real time.

    It shows a copy, so that looking at a dance does not change it.

    Args:
        stage: what is seen.

    Raises:
        SjasimError: there is no display.
    """

    def __init__(self, stage: Stage) -> None:
        self.check()
        import mujoco.viewer

        self._stage = stage
        self._shown = mujoco.MjData(stage.model)
        others = set(threading.enumerate())
        self._viewer = mujoco.viewer.launch_passive(stage.model, self._shown, show_left_ui=False, show_right_ui=False)
        self._threads = set(threading.enumerate()) - others
        with self._viewer.lock():
            view = camera()
            for name in ("lookat", "distance", "azimuth", "elevation"):
                setattr(self._viewer.cam, name, getattr(view, name))
        self._began_s = time.monotonic() - stage.time_s

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
        if not self._viewer.is_running():
            return
        with self._viewer.lock():
            mujoco.mj_copyData(self._shown, self._stage.model, self._stage.data)
        self._viewer.sync()
        ahead_s = self._began_s + self._stage.time_s - time.monotonic()
        if ahead_s > 0.0:
            time.sleep(ahead_s)

    def close(self) -> None:
        """Close the window, and wait for the viewer's own threads: another one must not begin beside them."""
        self._viewer.close()
        for thread in self._threads:
            thread.join(timeout=5.0)


def camera() -> mujoco.MjvCamera:
    """The view that pictures and windows begin with."""
    view = mujoco.MjvCamera()
    view.type = mujoco.mjtCamera.mjCAMERA_FREE
    view.lookat = LOOK_AT_M
    view.distance, view.azimuth, view.elevation = DISTANCE_M, AZIMUTH_DEG, ELEVATION_DEG
    return view
