"""Complete configuration of one session."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ..core.errors import ConfigError
from .body import BodyConfig
from .checks import one_of, within
from .clocks import ClockConfig
from .dance import DanceConfig
from .detectors import DetectorConfig
from .faults import FaultConfig
from .joint_noise import JointNoiseConfig
from .network import NetworkConfig
from .physics import PhysicsConfig
from .robot import RobotConfig
from .scene import SceneConfig
from .sensors import MAX_TRACKED_PERSONS, SensorConfig
from .synchrony import SynchronyConfig
from .timing import TimingConfig

MAX_DANCERS = 8
"""Largest number of dancers."""

HUMANS_ONLY = "none"
"""Value of `SessionConfig.method` for a session without a robot."""

SUPPORTED_RATES_HZ = (PhysicsConfig().rate_hz, PhysicsConfig().control_hz)
"""Default rates of physics and balance control for dancers with balance support."""

UNSUPPORTED_RATES_HZ = (240, 240)
"""Rates that replace the default ones without balance support, because dancers fall at the default rates."""


@dataclass(frozen=True, slots=True)
class SessionConfig:
    """Configuration of one session.

    Attributes:
        method: anticipation method: a registered name, module:Class, or ``none`` for a session without a robot.
        humans: human timing model: the name of a preset, ``adam`` or ``ashle`` for another model of timing,
            ``expertise:NUMBER`` from 0 (novices) to 1 (musicians), FILE.toml with parameters, ``replay:FILE`` with an
            event table or a session's folder, or module:Class.
        seed: seed of all random numbers of the session.
        dancers: number of dancers, up to 8; up to 6 with ``depth`` sensing.
        sensing: source of the skeletons: ``depth`` (simulated depth images and nothing else) or ``joints`` (true
            joints that are not occluded, with errors fitted to those of ``depth``; seven to nine times as fast).
        iterations: number of iterations after the rehearsal.
        layout: arrangement of the slots: ``square``, ``rows`` or ``custom``.
        performance: name of the performance. Sessions with the same seed and name have the same performance under every
            method. With "", each method has a different performance by the same persons.
        fidelity: world that is simulated: ``physics`` (bodies, robot and sensors in MuJoCo) or ``timing`` (events in
            time only, some thousand times as fast; delays and misses are drawn from what was measured in physics).
        method_options: option -> value, by the names of the fields of the method's configuration.
        faults: faults to inject.
        scene: positions of dancers, robot and sensors.
        dance: choreography and music.
        body: bodies of the dancers.
        physics: rates of the simulation.
        robot: dimensions, limits and errors of the robot's base.
        sensors: rates, fields of view and ranges of the depth sensors.
        joint_noise: errors of the skeletons of ``joints`` sensing.
        detectors: thresholds of the event detectors.
        network: delays and losses of messages.
        clocks: errors of the sensor clients' clocks.
        synchrony: parameters of the synchrony measures.
        timing: statistics that ``fidelity = timing`` draws from.
    """

    method: str = "sia"
    humans: str = "paper-entrainment"
    seed: int = 0
    dancers: int = 3
    sensing: str = "depth"
    iterations: int = 4
    layout: str = "square"
    performance: str = ""
    fidelity: str = "physics"
    method_options: Mapping[str, float | int | bool | str] = field(default_factory=dict)
    faults: tuple[FaultConfig, ...] = ()
    scene: SceneConfig = SceneConfig()
    dance: DanceConfig = DanceConfig()
    body: BodyConfig = BodyConfig()
    physics: PhysicsConfig = PhysicsConfig()
    robot: RobotConfig = RobotConfig()
    sensors: SensorConfig = SensorConfig()
    joint_noise: JointNoiseConfig = JointNoiseConfig()
    detectors: DetectorConfig = DetectorConfig()
    network: NetworkConfig = NetworkConfig()
    clocks: ClockConfig = ClockConfig()
    synchrony: SynchronyConfig = SynchronyConfig()
    timing: TimingConfig = TimingConfig()

    def __post_init__(self) -> None:
        one_of("fidelity", self.fidelity, ("physics", "timing"))
        one_of("layout", self.layout, ("square", "rows", "custom"))
        within("iterations", self.iterations, 1, 64)
        within("seed", self.seed, 0, 2**63 - 1)
        within("dancers", self.dancers, 1, MAX_DANCERS)
        if self.sensing == "depth" and self.dancers > MAX_TRACKED_PERSONS:
            allowed = f"at most {MAX_TRACKED_PERSONS} with depth sensing, which tracks no more; or --sensing joints"
            raise ConfigError("dancers", self.dancers, allowed)
        if isinstance(self.seed, float):
            raise ConfigError("seed", self.seed, "a whole number")

        # object.__setattr__ is needed because the dataclass is frozen.
        rates_hz = (self.physics.rate_hz, self.physics.control_hz)
        if self.body.balance_support == "none" and rates_hz == SUPPORTED_RATES_HZ:
            rate_hz, control_hz = UNSUPPORTED_RATES_HZ
            object.__setattr__(self, "physics", replace(self.physics, rate_hz=rate_hz, control_hz=control_hz))
