"""Every error sjasim raises on purpose: one line that says what, the value got and what is allowed."""

from __future__ import annotations


class SjasimError(Exception):
    """Root of all errors raised on purpose; command lines print it as one line and exit with 2."""


class ConfigError(SjasimError):
    """A configuration field has a value that is not allowed.

    Args:
        field: dotted name of the field, such as ``robot.cruise_m_s``.
        value: what was given.
        allowed: what would be accepted, in words.
    """

    def __init__(self, field: str, value: object, allowed: str) -> None:
        super().__init__(f"{field} = {value!r} is not allowed: {allowed}")
        self.field = field
        self.value = value
        self.allowed = allowed


class UnknownNameError(SjasimError):
    """A plug-in name that nothing is registered under; the message lists what is."""

    def __init__(self, room: str, name: str, known: tuple[str, ...]) -> None:
        super().__init__(f"no {room} named {name!r}: known are {', '.join(known)}, or module:Class")
        self.room = room
        self.name = name
        self.known = known


class PluginError(SjasimError):
    """A plug-in was found but does not keep its contract."""


class HookError(PluginError):
    """A plug-in's own code failed; its exception is the cause, and command lines print its traceback too."""


class RecordError(SjasimError):
    """A session's folder cannot be written or read."""
