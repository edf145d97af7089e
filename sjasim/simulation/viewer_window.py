"""A window that shows a session in MuJoCo's viewer while it runs."""

from __future__ import annotations

import os
import sys
import threading
import time

import mujoco

from .physics import Physics
from .rendering import RenderError, free_camera

NO_DISPLAY = "render_mode 'human' needs a display, and there is none ({reason}): use 'rgb_array', or run under xvfb-run"
"""Error message of `ViewerWindow.check_display`."""

JOIN_TIMEOUT_S = 5.0
"""Longest wait for each thread of the viewer when the window is closed [s]."""


class ViewerWindow:
    """MuJoCo's passive viewer of a scene. It slows the session down to real time, if it is faster.

    The window shows a copy of the state, so that a user who drags bodies in it does not change the session.

    Args:
        physics: the physics to show.

    Raises:
        RenderError: there is no display.
    """

    def __init__(self, physics: Physics) -> None:
        self.check_display()
        import mujoco.viewer

        self._physics = physics
        self._copy = mujoco.MjData(physics.model)
        before = set(threading.enumerate())
        self._viewer = mujoco.viewer.launch_passive(physics.model, self._copy, show_left_ui=False, show_right_ui=False)
        self._threads = set(threading.enumerate()) - before

        with self._viewer.lock():
            view = free_camera("scene")
            for name in ("lookat", "distance", "azimuth", "elevation"):
                setattr(self._viewer.cam, name, getattr(view, name))
        self._start_s = time.monotonic() - physics.time_s

    @staticmethod
    def check_display() -> None:
        """Check that a window can be opened; without a display MuJoCo's viewer would end the process.

        Raises:
            RenderError: there is no display, or it does not respond.
        """
        if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise RenderError(NO_DISPLAY.format(reason="neither DISPLAY nor WAYLAND_DISPLAY is set"))
        import glfw

        if not glfw.init() or not glfw.get_primary_monitor():
            raise RenderError(NO_DISPLAY.format(reason="no monitor answers"))

    def render(self) -> None:
        """Show the present state; does nothing once the user has closed the window."""
        if not self._viewer.is_running():
            return
        with self._viewer.lock():
            mujoco.mj_copyData(self._copy, self._physics.model, self._physics.data)
        self._viewer.sync()

        ahead_s = self._start_s + self._physics.time_s - time.monotonic()
        if ahead_s > 0.0:
            time.sleep(ahead_s)

    def close(self) -> None:
        """Close the window and wait for the threads of the viewer, which must end before another viewer starts."""
        self._viewer.close()
        for thread in self._threads:
            thread.join(timeout=JOIN_TIMEOUT_S)
