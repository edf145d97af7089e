"""Configuration: one frozen dataclass per room, all gathered in `SessionConfig`.

Every value is checked when the object is made, so a wrong one stops a session before anything is written.
A default that no source supports says ``assumed``. To and from plain data and TOML: `config_io`.
"""

from .faults import FAULTS, FaultConfig
from .network import ClockConfig, NetworkConfig, SynchronyConfig
from .robot import RobotConfig
from .room import BodyConfig, DanceConfig, PhysicsConfig, SceneConfig
from .sensing import MOST_SEEN, DetectorConfig, SensorConfig
from .session import SessionConfig

__all__ = [
    "FAULTS",
    "MOST_SEEN",
    "BodyConfig",
    "ClockConfig",
    "DanceConfig",
    "DetectorConfig",
    "FaultConfig",
    "NetworkConfig",
    "PhysicsConfig",
    "RobotConfig",
    "SceneConfig",
    "SensorConfig",
    "SessionConfig",
    "SynchronyConfig",
]
