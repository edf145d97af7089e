"""Records depth images of the active sensor for the rerun recording, a few each second."""

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
"""Rate of the recorded images [Hz]."""

STEP_MM = 10
"""Resolution of the recorded depth [mm]. Finer steps would only store the camera's noise, which does not compress."""

PIXEL_STRIDE = 2
"""Interval between the recorded rows and columns of the camera's image."""


class DepthRecorder:
    """Records depth images of a session. Add `tick` to the watchers of its world before the session starts.

    It has its own cameras and noise, so that recording does not change the session.

    Args:
        session: the session to record.

    Attributes:
        pictures: the images so far, oldest first.
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
        """Record an image of the active sensor if one is due.

        Args:
            now: session time of a frame [s].
        """
        if self._frames % self._every == 0:
            sensor = self._session.server.active
            depth_mm = self._cameras[sensor].frame(physics_of(self._session).physics)
            sampled_mm = depth_mm[::PIXEL_STRIDE, ::PIXEL_STRIDE]
            rounded_mm = (np.round(sampled_mm / STEP_MM) * STEP_MM).astype(np.uint16)
            png = imageio.imwrite("<bytes>", np.ascontiguousarray(rounded_mm), extension=".png")
            self.pictures.append(DepthPicture(now, sensor, png))
        self._frames += 1
