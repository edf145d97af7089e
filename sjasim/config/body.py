"""Configuration of the dancers' bodies and of the balance support."""

from __future__ import annotations

from dataclasses import dataclass

from ..core.errors import ConfigError
from .checks import one_of, within


@dataclass(frozen=True, slots=True)
class BodyConfig:
    """Bodies of the dancers, and the support of their balance.

    Attributes:
        model: ``sjasim`` (sjasim's own), ``cmu`` (the CMU humanoid of dm_control, which must be installed) or
            module:Class.
        stature_m: smallest and largest stature [m]; the stature of each dancer is drawn uniformly between them.
        mass_kg: smallest and largest mass [kg]; the mass of each dancer is drawn uniformly between them.
        balance_support: ``weak``: limited forces and torques at the pelvis help the dancers to stay upright. ``none``:
            dancers balance without support. Default rates of physics and balance control are then replaced by 240 Hz,
            because dancers without support fall at the default rates.
        support_force_n: largest horizontal force of the balance support along each axis [N].
        support_torque_nm: largest torque of the balance support about each axis [Nm].
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
