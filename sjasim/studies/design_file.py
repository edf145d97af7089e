"""Reading and writing the design of a study as TOML."""

from __future__ import annotations

import contextlib
import json
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, get_type_hints

from ..config.toml_file import checked_value, from_plain, plain_to_toml, to_plain
from ..core.errors import ConfigError
from .study_design import DESIGN_FIELDS, Level, StudyDesign

TABLES = ("session", "factors")
"""Fields of a design that are tables of its file."""


def read_design(path: str | Path, base: StudyDesign | None = None) -> StudyDesign:
    """Read a design from a TOML file. Fields that the file does not contain keep the values of ``base``.

    Raises:
        ConfigError: the file cannot be read, is not TOML, or holds an unknown field or a value that is not allowed.
    """
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError("design", str(path), f"a readable TOML file ({error.strerror or error})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError("design", str(path), f"a TOML file ({error})") from error
    return design_from_plain(data, base)


def design_from_plain(data: Mapping[str, Any], base: StudyDesign | None = None) -> StudyDesign:
    """Make a design from plain data, as a TOML file holds it; see `read_design`."""
    base = base or StudyDesign()
    hints = get_type_hints(StudyDesign)

    changes: dict[str, Any] = {}
    for name, value in data.items():
        if name not in hints:
            raise ConfigError(f"design.{name}", value, f"no such field; known are {', '.join(hints)}")
        if name not in TABLES:
            changes[name] = checked_value(hints[name], value, name)
            continue
        if not isinstance(value, Mapping):
            raise ConfigError(name, value, "a table")
        changes[name] = from_plain(value, base.session) if name == "session" else checked_factors(value)
    return replace(base, **changes)


def design_to_plain(design: StudyDesign) -> dict[str, Any]:
    """Convert a design to dictionaries, lists, strings, numbers and booleans, as in JSON and TOML."""
    plain: dict[str, Any] = {
        item.name: getattr(design, item.name) for item in fields(design) if item.name not in TABLES
    }
    plain = {name: list(value) if isinstance(value, tuple) else value for name, value in plain.items()}

    # What the design itself gives to every session does not stand among the common fields.
    session: dict[str, Any] = {
        name: value for name, value in to_plain(design.session).items() if name not in DESIGN_FIELDS
    }
    session["dance"] = {name: value for name, value in session["dance"].items() if name != "name"}
    factors = {name: json.loads(json.dumps(levels)) for name, levels in design.factors.items()}
    return {**plain, "session": session, "factors": factors}


def design_to_toml(design: StudyDesign) -> str:
    """Convert a design to TOML text, from which `read_design` restores an equal design."""
    return plain_to_toml(design_to_plain(design))


def design_from_toml(text: str) -> StudyDesign:
    """Restore a design from the text of `design_to_toml`."""
    return design_from_plain(tomllib.loads(text))


def checked_factors(data: Mapping[str, Any], table: str = "") -> dict[str, tuple[Level, ...]]:
    """Return the factors of a file: dotted names, also those that TOML reads as nested tables, and their levels.

    Args:
        data: the table of factors, or a table within it.
        table: dotted name of that table, with a dot at its end.

    Raises:
        ConfigError: a factor has no list of levels.
    """
    factors: dict[str, tuple[Level, ...]] = {}
    for name, value in data.items():
        if isinstance(value, Mapping):
            factors |= checked_factors(value, f"{table}{name}.")
        elif isinstance(value, list | tuple):
            factors[table + name] = tuple(value)
        else:
            raise ConfigError(f"factors.{table}{name}", value, "a list of levels")
    return factors


def factors_from_words(words: Sequence[str]) -> dict[str, tuple[Level, ...]]:
    """Read factors from a command line: ``NAME=LEVEL,LEVEL,...``; a level is written as in TOML, strings also plain.

    Raises:
        ConfigError: a word has no equals sign.
    """
    factors: dict[str, tuple[Level, ...]] = {}
    for word in words:
        name, equals, values = word.partition("=")
        if not equals:
            raise ConfigError("factors", word, "NAME=LEVEL,LEVEL,... such as dance.bpm=100,118")
        factors[name.replace("-", "_")] = _levels(values)
    return factors


def _levels(text: str) -> tuple[Level, ...]:
    """Levels that are separated by commas."""
    try:
        return tuple(tomllib.loads(f"levels = [{text}]")["levels"])
    except tomllib.TOMLDecodeError:
        return tuple(_level(item.strip()) for item in text.split(","))


def _level(text: str) -> Level:
    """One level: a value of TOML, else a number such as ``.2``, which TOML does not allow, else a string."""
    with contextlib.suppress(tomllib.TOMLDecodeError):
        level: Level = tomllib.loads(f"level = {text}")["level"]
        return level
    with contextlib.suppress(ValueError):
        return float(text)
    return text
