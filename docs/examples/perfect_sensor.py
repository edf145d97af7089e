"""A sensor in one file: it sees every joint of every dancer, without errors and through all obstacles.

python3 scripts/launch.py run --sensing perfect_sensor:PerfectSensor
"""

import numpy as np

from sjasim.choreography.layout import Mount
from sjasim.config import SessionConfig
from sjasim.core import TRACKED, BoolArray, IntArray, SceneView, Skeletons


class PerfectSensor:
    """Implements `SkeletonSource`: an upper bound for every other sensor.

    Args:
        mount: where the sensor is mounted.
        config: configuration of the session.
        rng: random generator of this sensor; it needs none.
    """

    def __init__(self, mount: Mount, config: SessionConfig, rng: np.random.Generator) -> None:
        self._mount = mount
        self.dancers: IntArray = np.arange(config.dancers)
        self.visible: BoolArray = np.ones((config.dancers, 25), dtype=bool)

    def sample(self, view: SceneView) -> Skeletons | None:
        """The true joints in the sensor's own axes: x to its left, y up, z away from it."""
        joints = (view.joints_m - self._mount.position) @ self._mount.world_from_sensor
        state = np.full(joints.shape[:2], TRACKED, dtype=np.int8)
        return Skeletons(self.dancers, joints, state)
