"""One session, whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ..core.errors import ConfigError
from .checks import one_of, within
from .faults import FaultConfig
from .network import ClockConfig, NetworkConfig, SynchronyConfig
from .robot import RobotConfig
from .room import BodyConfig, DanceConfig, PhysicsConfig, SceneConfig
from .sensing import MOST_SEEN, DetectorConfig, SensorConfig

HELD_HZ = PhysicsConfig().rate_hz, PhysicsConfig().balance_hz
FREE_HZ = 240, 240
"""Rates of physics and balance with a tether and without one: who balances alone balances often. The former do not
keep anybody upright alone, and stand for the latter there."""


@dataclass(frozen=True, slots=True)
class SessionConfig:
    """One dance session, whole.

    Attributes:
        method: anticipation method: a registered name, module:Class, or ``none`` for humans only.
        humans: who dances: a preset of the human timing model, FILE.toml with own parameters, ``replay:FILE`` of an
            event table or a session's folder, or module:Class.
        fidelity: ``physics``.
        sensing: where skeletons come from: ``depth`` (nothing but simulated depth images) or ``joints`` (the truth,
            occluded, with errors fitted to those of ``depth``: seven to nine times as fast).
        iterations: how many iterations are danced after the rehearsal.
        layout: ``square``, ``rows`` or ``custom``.
        seed: of everything random in the session.
        performance: names the take; "" gives every method a fresh performance by the same people.
        group: number of dancers, up to 8; up to 6 with ``depth`` sensing.
        method_options: options of the method, by the names of its config's fields.
        faults: what is made to go wrong.
    """

    method: str = "sia"
    humans: str = "paper-entrainment"
    fidelity: str = "physics"
    sensing: str = "depth"
    iterations: int = 4
    layout: str = "square"
    seed: int = 0
    performance: str = ""
    group: int = 3
    method_options: Mapping[str, float | int | bool | str] = field(default_factory=dict)
    faults: tuple[FaultConfig, ...] = ()
    room: SceneConfig = SceneConfig()
    dance: DanceConfig = DanceConfig()
    body: BodyConfig = BodyConfig()
    stage: PhysicsConfig = PhysicsConfig()
    robot: RobotConfig = RobotConfig()
    sensors: SensorConfig = SensorConfig()
    detectors: DetectorConfig = DetectorConfig()
    network: NetworkConfig = NetworkConfig()
    clocks: ClockConfig = ClockConfig()
    synchrony: SynchronyConfig = SynchronyConfig()

    def __post_init__(self) -> None:
        one_of("fidelity", self.fidelity, ("physics",))
        one_of("layout", self.layout, ("square", "rows", "custom"))
        within("iterations", self.iterations, 1, 64)
        within("seed", self.seed, 0, 2**63 - 1)
        within("group", self.group, 1, 8)
        if self.sensing == "depth" and self.group > MOST_SEEN:
            raise ConfigError(
                "group",
                self.group,
                f"at most {MOST_SEEN} with depth sensing, which follows no more; or --sensing joints",
            )
        if isinstance(self.seed, float):
            raise ConfigError("seed", self.seed, "a whole number")
        if self.body.tether == "none" and (self.physics.rate_hz, self.physics.balance_hz) == HELD_HZ:
            rate_hz, balance_hz = FREE_HZ
            object.__setattr__(self, "stage", replace(self.physics, rate_hz=rate_hz, balance_hz=balance_hz))
