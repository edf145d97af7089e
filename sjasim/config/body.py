"""The dancers' bodies and what supports their balance."""

from __future__ import annotations

from dataclasses import dataclass

from ..core.errors import ConfigError
from .checks import one_of, within


@dataclass(frozen=True, slots=True)
class BodyConfig:
    """The dancers' builds and the tether.

    Attributes:
        model: ``sjasim`` (our own), ``cmu`` (dm_control's CMU humanoid; needs dm-control) or module:Class.
        stature_m: lowest and highest stature to draw from.
        mass_kg: lowest and highest mass to draw from.
        balance_support: ``weak`` (saturating) or ``none``: balance alone; physics and balance then run at 240 Hz, unless other
            rates are given than the 150 and 50 Hz of a tether, at which nobody stands alone.
        support_force_n: most horizontal force of the tether, each axis.
        support_torque_nm: most torque of the tether, each axis.
    """

    model: str = "sjasim"
    stature_m: tuple[float, float] = (1.60, 1.85)
    mass_kg: tuple[float, float] = (58.0, 88.0)
    balance_support: str = "weak"
    support_force_n: float = 42.0
    support_torque_nm: float = 30.0

    def __post_init__(self) -> None:
        for name, (low, high), least, most in (
            ("body.stature_m", self.stature_m, 1.50, 1.95),
            ("body.mass_kg", self.mass_kg, 50.0, 100.0),
        ):
            if not least <= low <= high <= most:
                raise ConfigError(name, (low, high), f"two rising numbers from {least:g} to {most:g}")
        one_of("body.balance_support", self.balance_support, ("weak", "none"))
        within("body.support_force_n", self.support_force_n, 0.0, 200.0)
        within("body.support_torque_nm", self.support_torque_nm, 0.0, 200.0)
