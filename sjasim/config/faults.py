"""Faults that a session can inject."""

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
    """A fault to inject.

    Attributes:
        kind: ``dead_sensor``, ``clock_jump``, ``dancer_stops``, ``dancer_late``, ``robot_blocked`` (its wheels do not
            turn) or ``dead_robot`` (it neither receives nor reports nor drives). Lost packets are
            ``network.packet_loss``.
        target: a sensor (``north``...), a dancer (``dancer_1``...) or ``robot``.
        t_s: session time at which the fault begins [s].
        value: size of a jump or of a lateness [s]; not used by other kinds.
    """

    kind: str
    target: str
    t_s: float = 0.0
    value: float = 0.0

    def __post_init__(self) -> None:
        one_of("faults.kind", self.kind, tuple(FAULTS))
        within("faults.t_s", self.t_s, 0.0, 1e5)
        within("faults.value", self.value, -60.0, 60.0)
