"""Validation of single configuration values."""

from __future__ import annotations

from ..core.errors import ConfigError


def within(name: str, value: float, low: float, high: float) -> None:
    """Check that a value is a number from ``low`` to ``high``, both included. NaN and booleans are not allowed.

    Raises:
        ConfigError: the message names the field, the value and the range.
    """
    # bool is a subclass of int, so that True would otherwise pass as 1.
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ConfigError(name, value, f"a number from {low:g} to {high:g}")


def one_of(name: str, value: str, allowed: tuple[str, ...]) -> None:
    """Check that a string is one of the allowed values.

    Raises:
        ConfigError: the message names the field, the value and the allowed values.
    """
    if value not in allowed:
        raise ConfigError(name, value, f"one of {', '.join(allowed)}")
