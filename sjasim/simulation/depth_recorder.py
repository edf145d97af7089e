"""Watches a session through the active sensor's depth camera, a few pictures a second, for the recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

import imageio.v3 as imageio
import numpy as np

from ..core.clock import stream
from ..core.session_log import DepthPicture
from ..sensors.depth_sensing import DepthSensing
from .physics_world import physics_of

if TYPE_CHECKING:
    from ..session.session import Session

PICTURES_HZ = 5
STEP_MM = 10
"""Depths are kept in steps of this: noise does not compress, and finer is below it."""
EVERY_PIXEL = 2
"""Of the camera's rows and columns one in so many is kept."""


class DepthRecorder:
    """Keeps pictures of a session; add `tick` to its world's watchers before it begins.

    It has cameras and noise of its own, so that watching changes nothing.

    Args:
        session: what to watch.

    Attributes:
        pictures: what has been kept so far, oldest first.
    """

    def __init__(self, session: Session) -> None:
        config = session.config
        self._session = session
        self._every = max(1, config.sensors.rate_hz // PICTURES_HZ)
        self._frames = 0
        self._cameras = {
            mount.name: DepthSensing(mount, config, stream(config.seed, "depth_watch", mount.name))
            for mount in session.layout.mounts
        }
        self.pictures: list[DepthPicture] = []

    def tick(self, now: float) -> None:
        """A camera frame of the session."""
        if self._frames % self._every == 0:
            sensor = self._session.server.active
            depth_mm = self._cameras[sensor].frame(physics_of(self._session).physics)[::EVERY_PIXEL, ::EVERY_PIXEL]
            coarse = (np.round(depth_mm / STEP_MM) * STEP_MM).astype(np.uint16)
            png = imageio.imwrite("<bytes>", np.ascontiguousarray(coarse), extension=".png")
            self.pictures.append(DepthPicture(now, sensor, png))
        self._frames += 1
