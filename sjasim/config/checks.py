"""Checks that every configuration makes of its fields."""

from __future__ import annotations

from ..core.errors import ConfigError


def within(name: str, value: float, low: float, high: float) -> None:
    """Refuse what is not a number from ``low`` to ``high``.

    Raises:
        ConfigError: naming the field, the value and the range.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ConfigError(name, value, f"a number from {low:g} to {high:g}")


def one_of(name: str, value: str, allowed: tuple[str, ...]) -> None:
    """Refuse what is not among the words that are allowed.

    Raises:
        ConfigError: naming the field, the value and the words.
    """
    if value not in allowed:
        raise ConfigError(name, value, f"one of {', '.join(allowed)}")
