"""Configuration of sessions: one frozen dataclass for each part of the system, and `SessionConfig` with all of them.

Each dataclass checks its values when it is created, so that an invalid configuration fails before a session starts.
Defaults without a source are marked ``assumed``. `toml_file` converts a configuration to and from plain data and TOML.
The docstrings are also the help texts of the command line.
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
from .timing import TimingConfig

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
    "TimingConfig",
]
