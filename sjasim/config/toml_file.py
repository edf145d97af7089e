"""Conversion of a configuration to and from plain data and TOML. Errors name the field and the allowed values."""

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
"""Type of a field -> description of its values, for error messages."""


def to_plain(config: SessionConfig) -> dict[str, object]:
    """Convert a configuration to dictionaries, lists, strings, numbers and booleans, as in JSON and TOML."""
    plain = _plain(config)
    assert isinstance(plain, dict)
    return plain


def from_plain(data: Mapping[str, object], base: SessionConfig | None = None, *, warn: bool = False) -> SessionConfig:
    """Create a configuration from plain data.

    Args:
        data: fields of `SessionConfig`, with tables as nested mappings. Former field names are accepted.
        base: configuration with the values of absent fields; None for the defaults.
        warn: whether to issue a `FutureWarning` for each former name.

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
    """Read a configuration file. Fields that it does not contain keep the value of ``base``.

    Raises:
        ConfigError: the file cannot be read, is not TOML, or contains an unknown field or an invalid value.
    """
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError("config", str(path), f"a readable TOML file ({error.strerror or error})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError("config", str(path), f"a TOML file ({error})") from error
    return from_plain(data, base, warn=True)


def to_toml(config: SessionConfig) -> str:
    """Convert a configuration to TOML text, from which `read_toml` restores an equal configuration."""
    return plain_to_toml(to_plain(config))


def plain_to_toml(data: Mapping[str, Any]) -> str:
    """Convert dictionaries, lists, strings, numbers and booleans to TOML text."""
    return tomli_w.dumps(data)


def checked_value(hint: Any, value: object, path: str) -> Any:
    """Convert a value from a file to the type of its field.

    Args:
        hint: the field's annotation.
        value: a number, a string, a boolean, a list or a mapping.
        path: dotted name of the field, for error messages.

    Raises:
        ConfigError: the value has another type.
    """
    return _parsed(hint, value, None, path)


def _plain(value: object) -> object:
    """Return the value with dataclasses replaced by dictionaries, and tuples by lists."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value


def _updated(base: Any, data: object, path: str) -> Any:
    """Return a dataclass of the configuration with the given fields.

    Args:
        base: an instance whose other fields are kept, or a class whose defaults are used.
        data: the given fields.
        path: dotted name of the dataclass; "" at the root.
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
    # Fields without a default must be given for a new object, such as an element of the list of faults.
    for field in dataclasses.fields(base):
        if field.name not in changes and field.default is field.default_factory is dataclasses.MISSING:
            raise ConfigError(prefix + field.name, None, "it must be given")
    return base(**changes)


def _parsed(hint: Any, value: object, current: object, path: str) -> object:
    """Convert a value to the annotated type; see `checked_value`. ``current`` is the field's old value, or None."""
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

    # In TOML and JSON a float field may be written without a decimal point, such as 120.
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if hint in WORDS and type(value) is not hint:
        raise ConfigError(path, value, WORDS[hint])
    return value


def _parsed_union(arguments: tuple[Any, ...], value: object, path: str) -> object:
    """Return the value if its type is one of the annotated ones. A boolean is not accepted as an integer."""
    if type(value) in arguments or (value is None and type(None) in arguments):
        return value
    raise ConfigError(path, value, " or ".join(WORDS.get(item, str(item)) for item in arguments))


def _parsed_tuple(arguments: tuple[Any, ...], value: object, path: str) -> tuple[object, ...]:
    """Convert a list to a tuple of the annotated length and types."""
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
    """Return the error text for an unknown field, with the closest field name and all field names."""
    close = difflib.get_close_matches(key, known, n=1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    return f"no such field; {hint}known are {', '.join(known)}"
