"""Exceptions of sjasim. Each message is one line with the problem, the given value and the allowed values."""

from __future__ import annotations


class SjasimError(Exception):
    """Base class of sjasim's exceptions. Commands print the message and exit with code 2."""


class ConfigError(SjasimError):
    """A configuration field has a value that is not allowed.

    Args:
        field: dotted name of the field, such as ``robot.cruise_m_s``.
        value: the given value.
        allowed: description of the accepted values.
    """

    def __init__(self, field: str, value: object, allowed: str) -> None:
        super().__init__(f"{field} = {value!r} is not allowed: {allowed}")
        self.field = field
        self.value = value
        self.allowed = allowed

    def __reduce__(self) -> tuple[type[ConfigError], tuple[str, object, str]]:
        """Pickle the arguments instead of the message, so that the error crosses processes."""
        return type(self), (self.field, self.value, self.allowed)


class UnknownNameError(SjasimError):
    """No plug-in is registered under a name; the message lists the registered names.

    Args:
        room: kind of plug-in.
        name: the requested name.
        known: the registered names.
    """

    def __init__(self, room: str, name: str, known: tuple[str, ...]) -> None:
        super().__init__(f"no {room} named {name!r}: known are {', '.join(known)}, or module:Name")
        self.room = room
        self.name = name
        self.known = known

    def __reduce__(self) -> tuple[type[UnknownNameError], tuple[str, str, tuple[str, ...]]]:
        """Pickle the arguments instead of the message, so that the error crosses processes."""
        return type(self), (self.room, self.name, self.known)


class PluginError(SjasimError):
    """A plug-in cannot be loaded or violates the protocol of its kind."""


class HookError(PluginError):
    """The code of a plug-in raised an exception, which is the ``__cause__`` of this one.

    Commands print its traceback as well.
    """


class RecordError(SjasimError):
    """A file or a session's folder cannot be written or read."""
