"""A window that shows a dance while it goes on, where there is a display."""

from __future__ import annotations

import os
import sys
import threading
import time

import mujoco

from .physics import Physics
from .rendering import RenderError, free_camera

NO_DISPLAY = "render_mode 'human' needs a display, and there is none ({reason}): use 'rgb_array', or run under xvfb-run"


class ViewerWindow:
    """MuJoCo's own viewer, kept up to date with a stage, no faster than in real time.

    It shows a copy, so that looking at a dance does not change it.

    Args:
        stage: what is seen.

    Raises:
        RenderError: there is no display.
    """

    def __init__(self, physics: Physics) -> None:
        self.check()
        import mujoco.viewer

        self._physics = physics
        self._shown = mujoco.MjData(physics.model)
        others = set(threading.enumerate())
        self._viewer = mujoco.viewer.launch_passive(physics.model, self._shown, show_left_ui=False, show_right_ui=False)
        self._threads = set(threading.enumerate()) - others
        with self._viewer.lock():
            view = free_camera("room")
            for name in ("lookat", "distance", "azimuth", "elevation"):
                setattr(self._viewer.cam, name, getattr(view, name))
        self._began_s = time.monotonic() - physics.time_s

    @staticmethod
    def check() -> None:
        """Refuse where a window would end the process instead of raising.

        Raises:
            RenderError: there is no display, or none that answers.
        """
        if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise RenderError(NO_DISPLAY.format(reason="neither DISPLAY nor WAYLAND_DISPLAY is set"))
        import glfw

        if not glfw.init() or not glfw.get_primary_monitor():
            raise RenderError(NO_DISPLAY.format(reason="no monitor answers"))

    def frame(self) -> None:
        """Show the stage as it is now; after the user has closed the window nothing happens."""
        if not self._viewer.is_running():
            return
        with self._viewer.lock():
            mujoco.mj_copyData(self._shown, self._physics.model, self._physics.data)
        self._viewer.sync()
        ahead_s = self._began_s + self._physics.time_s - time.monotonic()
        if ahead_s > 0.0:
            time.sleep(ahead_s)

    def close(self) -> None:
        """Close the window, and wait for the viewer's own threads: another one must not begin beside them."""
        self._viewer.close()
        for thread in self._threads:
            thread.join(timeout=5.0)
