"""Checks of single configuration values."""

from __future__ import annotations

from ..core.errors import ConfigError


def within(name: str, value: float, low: float, high: float) -> None:
    """Refuse a value that is not a number from ``low`` to ``high``; NaN is refused as well.

    Raises:
        ConfigError: the message names the field, the value and the range.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ConfigError(name, value, f"a number from {low:g} to {high:g}")


def one_of(name: str, value: str, allowed: tuple[str, ...]) -> None:
    """Refuse a word that is not allowed.

    Raises:
        ConfigError: the message names the field, the value and the allowed words.
    """
    if value not in allowed:
        raise ConfigError(name, value, f"one of {', '.join(allowed)}")
