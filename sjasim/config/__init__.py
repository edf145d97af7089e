"""Configuration: a frozen dataclass for each part of the system; `SessionConfig` holds them all.

Every value is checked when the object is made, so that a wrong one is refused before a session starts. A default that
no source supports is marked ``assumed``. `toml_file` converts to and from plain data and TOML.
"""

from .body import BodyConfig
from .clocks import ClockConfig
from .dance import DanceConfig
from .detectors import DetectorConfig
from .faults import FAULTS, FaultConfig
from .joint_noise import JointNoiseConfig
from .network import NetworkConfig
from .physics import PhysicsConfig
from .robot import RobotConfig
from .scene import SceneConfig
from .sensors import MAX_TRACKED_PERSONS, SensorConfig
from .session import HUMANS_ONLY, SessionConfig
from .synchrony import SynchronyConfig

__all__ = [
    "FAULTS",
    "HUMANS_ONLY",
    "MAX_TRACKED_PERSONS",
    "BodyConfig",
    "ClockConfig",
    "DanceConfig",
    "DetectorConfig",
    "FaultConfig",
    "JointNoiseConfig",
    "NetworkConfig",
    "PhysicsConfig",
    "RobotConfig",
    "SceneConfig",
    "SensorConfig",
    "SessionConfig",
    "SynchronyConfig",
]
