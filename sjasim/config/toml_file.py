"""Converts a configuration to and from plain data and TOML. An error names the field and what is allowed."""

from __future__ import annotations

import dataclasses
import difflib
import tomllib
import types
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Union, get_args, get_origin, get_type_hints

import tomli_w

from ..core.errors import ConfigError
from . import SessionConfig
from .renamed_fields import renamed_message, with_present_names

WORDS = {int: "a whole number", float: "a number", bool: "true or false", str: "a string"}
"""Type of a field -> the values it accepts, in words."""


def to_plain(config: SessionConfig) -> dict[str, object]:
    """The configuration as dictionaries, lists, strings, numbers and booleans, as JSON and TOML hold them."""
    plain = _plain(config)
    assert isinstance(plain, dict)
    return plain


def from_plain(data: Mapping[str, object], base: SessionConfig | None = None, *, warn: bool = False) -> SessionConfig:
    """Make a configuration from plain data.

    Args:
        data: fields of `SessionConfig`, tables as nested mappings. Former names of fields are accepted.
        base: gives the values of absent fields; the defaults if None.
        warn: whether a former name gives a warning.

    Raises:
        ConfigError: a key is unknown or a value has the wrong type or is out of range; the message names the field.
    """
    present, renamed = with_present_names(data)
    if warn:
        for former, name in renamed.items():
            warnings.warn(renamed_message(former, name), FutureWarning, stacklevel=2)
    config = _updated(base or SessionConfig(), present, "")
    assert isinstance(config, SessionConfig)
    return config


def read_toml(path: str | Path, base: SessionConfig | None = None) -> SessionConfig:
    """Read a configuration file. Fields that it does not contain keep the value of the base.

    Raises:
        ConfigError: the file cannot be read, is not TOML, or holds a wrong field.
    """
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError("config", str(path), f"a readable TOML file ({error.strerror or error})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError("config", str(path), f"a TOML file ({error})") from error
    return from_plain(data, base, warn=True)


def to_toml(config: SessionConfig) -> str:
    """The configuration as TOML text, from which `read_toml` makes an equal value."""
    return tomli_w.dumps(to_plain(config))


def checked_value(hint: Any, value: object, path: str) -> Any:
    """A value from a file as the type of the field that it is for.

    Args:
        hint: the field's annotation.
        value: a number, a string, a boolean, a list or a mapping.
        path: dotted name of the field, for the message.

    Raises:
        ConfigError: the value has another type.
    """
    return _parsed(hint, value, None, path)


def _plain(value: object) -> object:
    """The value without dataclasses and tuples."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value


def _updated(base: Any, data: object, path: str) -> Any:
    """A dataclass of the configuration with the given fields.

    Args:
        base: an instance, whose other fields are kept, or the class, whose defaults are used.
        data: the fields.
        path: dotted name of the dataclass, "" at the root.
    """
    if not isinstance(data, Mapping):
        raise ConfigError(path or "config", data, "a table of fields")

    hints = get_type_hints(type(base) if not isinstance(base, type) else base)
    prefix = f"{path}." if path else ""

    changes: dict[str, object] = {}
    for key, value in data.items():
        if key not in hints:
            raise ConfigError(f"{prefix}{key}", value, _known(str(key), tuple(hints)))
        current = None if isinstance(base, type) else getattr(base, key)
        changes[key] = _parsed(hints[key], value, current, f"{prefix}{key}")

    if not isinstance(base, type):
        return dataclasses.replace(base, **changes)
    # A new object, such as an element of a list of faults, must have every field that has no default.
    for field in dataclasses.fields(base):
        if field.name not in changes and field.default is field.default_factory is dataclasses.MISSING:
            raise ConfigError(prefix + field.name, None, "it must be given")
    return base(**changes)


def _parsed(hint: Any, value: object, current: object, path: str) -> object:
    """The value as the annotated type; see `checked_value`. ``current`` is the field's value so far, or None."""
    origin = get_origin(hint)
    arguments = get_args(hint)
    if dataclasses.is_dataclass(hint):
        return _updated(hint if current is None else current, value, path)
    if origin is tuple:
        return _parsed_tuple(arguments, value, path)
    if origin in (Union, types.UnionType):
        return _parsed_union(arguments, value, path)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            raise ConfigError(path, value, "a table")
        return {str(key): _parsed(arguments[1], item, None, f"{path}.{key}") for key, item in value.items()}

    # TOML and JSON write 120 for a number that happens to be whole.
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if hint in WORDS and type(value) is not hint:
        raise ConfigError(path, value, WORDS[hint])
    return value


def _parsed_union(arguments: tuple[Any, ...], value: object, path: str) -> object:
    """The value if it has exactly one of the types; a boolean is no whole number here."""
    if type(value) in arguments or (value is None and type(None) in arguments):
        return value
    raise ConfigError(path, value, " or ".join(WORDS.get(item, str(item)) for item in arguments))


def _parsed_tuple(arguments: tuple[Any, ...], value: object, path: str) -> tuple[object, ...]:
    """The list as a tuple of the annotated length and types."""
    if not isinstance(value, list | tuple):
        raise ConfigError(path, value, "a list")
    if len(arguments) == 2 and arguments[1] is Ellipsis:
        arguments = (arguments[0],) * len(value)
    if len(arguments) != len(value):
        raise ConfigError(path, value, f"a list of {len(arguments)}")
    return tuple(
        _parsed(hint, item, None, f"{path}[{index}]")
        for index, (hint, item) in enumerate(zip(arguments, value, strict=True))
    )


def _known(key: str, known: tuple[str, ...]) -> str:
    """What a message says of a key that is no field: the closest one, and all of them."""
    close = difflib.get_close_matches(key, known, n=1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    return f"no such field; {hint}known are {', '.join(known)}"
