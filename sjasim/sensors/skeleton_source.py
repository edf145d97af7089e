"""`SkeletonSource`: the interface of a sensor, which turns the scene into skeletons."""

from __future__ import annotations

from typing import Protocol

from ..core import BoolArray, IntArray, SceneView, Skeletons


class SkeletonSource(Protocol):
    """A sensor that delivers skeletons, such as `DepthSensing` and `JointSensing`.

    Implement this protocol to simulate a sensor of your own, and select it with ``--sensing my_module:MySensor``. One
    instance is made per sensor of the layout, as ``MySensor(mount, config, rng)``: where the sensor is mounted (a
    `Mount`), the configuration of the session (a `SessionConfig`) and a random generator of the sensor's own.

    ``dancers`` and ``visible`` tell the ground truth behind the last frame. They are written to the session's tables
    only: no client and no server reads them.
    """

    @property
    def dancers(self) -> IntArray:
        """(P,) index of the dancer behind each person of the last frame, -1 where a person is no dancer."""
        ...

    @property
    def visible(self) -> BoolArray:
        """(P, 25) whether the sensor had a free line of sight to each joint of these dancers in the last frame."""
        ...

    def sample(self, view: SceneView) -> Skeletons | None:
        """Capture one frame.

        Args:
            view: the scene at the time of the frame; times of successive calls do not decrease.

        Returns:
            the skeletons of all persons in the picture, or None if the frame is lost.
        """
        ...
