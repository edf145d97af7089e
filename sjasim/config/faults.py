"""Configuration of the faults that are injected in a session."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import one_of, within

FAULTS = {
    "dead_sensor": "sensor",
    "clock_jump": "sensor",
    "dancer_stops": "dancer",
    "dancer_late": "dancer",
    "robot_blocked": "robot",
    "dead_robot": "robot",
}
"""Kind of fault -> kind of its target."""


@dataclass(frozen=True, slots=True)
class FaultConfig:
    """A fault that is injected in a session.

    Attributes:
        kind: ``dead_sensor``, ``clock_jump``, ``dancer_stops``, ``dancer_late``, ``robot_blocked`` (the wheels do not
            turn) or ``dead_robot`` (the robot neither receives nor sends messages, and does not move). Use
            ``network.packet_loss`` for lost packets.
        target: name of a sensor (``north``...), of a dancer (``dancer_1``...), or ``robot``.
        t_s: session time at which the fault begins [s].
        value: size of a clock jump, or delay of a late dancer's moves [s]; not used by other kinds.
    """

    kind: str
    target: str
    t_s: float = 0.0
    value: float = 0.0

    def __post_init__(self) -> None:
        one_of("faults.kind", self.kind, tuple(FAULTS))
        within("faults.t_s", self.t_s, 0.0, 1e5)
        within("faults.value", self.value, -60.0, 60.0)
