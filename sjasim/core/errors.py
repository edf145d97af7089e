"""Errors that sjasim raises on purpose. Each message is one line: what is wrong, the value, what is allowed."""

from __future__ import annotations


class SjasimError(Exception):
    """Base class of all errors raised on purpose. Commands print the message and exit with 2."""


class ConfigError(SjasimError):
    """A configuration field has a value that is not allowed.

    Args:
        field: dotted name of the field, such as ``robot.cruise_m_s``.
        value: the value that was given.
        allowed: the values that would be accepted, in words.
    """

    def __init__(self, field: str, value: object, allowed: str) -> None:
        super().__init__(f"{field} = {value!r} is not allowed: {allowed}")
        self.field = field
        self.value = value
        self.allowed = allowed


class UnknownNameError(SjasimError):
    """No plug-in is registered under a name; the message lists the names that exist.

    Args:
        room: kind of plug-in.
        name: the name that was asked for.
        known: the registered names.
    """

    def __init__(self, room: str, name: str, known: tuple[str, ...]) -> None:
        super().__init__(f"no {room} named {name!r}: known are {', '.join(known)}, or module:Class")
        self.room = room
        self.name = name
        self.known = known


class PluginError(SjasimError):
    """A plug-in does not keep its contract."""


class HookError(PluginError):
    """A plug-in's own code raised an exception, which is this error's cause. Commands print its traceback as well."""


class RecordError(SjasimError):
    """A file or a session's folder cannot be written or read."""
