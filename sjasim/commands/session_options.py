"""Reads a command line of which a session's configuration is a part."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, TypeVar

from ..config import SessionConfig
from ..config.toml_file import read_toml
from ..core.errors import SjasimError
from ..core.registry import resolve
from .flags import Flags
from .former_flags import present_flags
from .options import parse_flags


class SessionOptions(Protocol):
    """Options of a command that simulates sessions."""

    @property
    def session(self) -> SessionConfig:
        """The configuration of the session."""
        ...


Options = TypeVar("Options", bound=SessionOptions)


def parse_session(
    options: Callable[[SessionConfig], Options],
    arguments: Sequence[str],
    program: str,
    about: str,
    first: Sequence[str] = (),
    omitted: Sequence[str] = (),
) -> Options:
    """Read a command line with the fields of a session's configuration, and of its method's options, as flags.

    The file of ``--config FILE.toml`` gives the values that no flag gives.

    Args:
        options: dataclass whose first field is the configuration; the others have defaults.
        arguments: the command line without the program's name.
        program: what the user typed, for the help and for messages.
        about: what the command does, for the help.
        first: names of the fields that come first in the help.
        omitted: names of the fields of the configuration that get no flag.

    Raises:
        UsageError: an argument is unknown or malformed.
        ConfigError: the file cannot be read, or a value is not allowed.
    """
    # The file and the method decide which flags there are, so both are read before the command line is parsed.
    base = config_from(arguments)
    method = value_of("method", arguments) or base.method
    default = options(base)
    tables = method_tables(method, base.method_options)
    flags = Flags(type(default), default, first=first, omitted=omitted, tables=tables)
    return parse_flags(flags, present_flags(arguments, method), program, about)


def config_from(arguments: Sequence[str]) -> SessionConfig:
    """The configuration that ``--config FILE.toml`` names; the defaults without it.

    Raises:
        ConfigError: the file cannot be read or holds a wrong field.
    """
    path = value_of("config", arguments)
    return SessionConfig() if path is None else read_toml(path)


def value_of(name: str, arguments: Sequence[str]) -> str | None:
    """The last value that a command line gives to a flag, as ``--name VALUE`` or ``--name=VALUE``; None without one."""
    found = None
    for index, word in enumerate(arguments):
        flag, equals, value = word.partition("=")
        if flag == f"--{name}" and (equals or index + 1 < len(arguments)):
            found = value if equals else arguments[index + 1]
    return found


def method_tables(method: str, given: Mapping[str, object]) -> dict[str, type]:
    """The dataclass of a method's options, as `parse` takes it; empty where no flags can be made.

    That is so for a session without a robot, for a method without options, and for a method that does not exist or
    lacks one of the given options, which is refused when the method is made.
    """
    try:
        config = resolve("anticipation", method).config
    except SjasimError:
        return {}

    if config is None or not dataclasses.is_dataclass(config):
        return {}
    known = {field.name for field in dataclasses.fields(config)}
    return {"method_options": config} if set(given) <= known else {}
