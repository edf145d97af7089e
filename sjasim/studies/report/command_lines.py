"""Command lines that repeat what a page reports."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from typing import Any

from ...config import SessionConfig
from ...config.toml_file import to_plain


def changed_fields(config: Mapping[str, Any]) -> dict[str, Any]:
    """Dotted name -> value of the fields of a session's configuration that differ from the default.

    Args:
        config: the configuration as plain data.
    """
    return dict(_differences(config, to_plain(SessionConfig()), ""))


def session_command(config: Mapping[str, Any]) -> str:
    """The command line that simulates a session again; faults have no flags and are left out.

    Args:
        config: the configuration as plain data.
    """
    words = ["sjasim", "run", "--method", config["method"], "--seed", str(config["seed"])]
    for name, value in changed_fields(config).items():
        if name not in ("method", "seed") and not _is_table_list(value):
            words += _flag(name, value)
    return shlex.join([*words, "--out", "DIR"])


def has_unnamed_fields(config: Mapping[str, Any]) -> bool:
    """Whether a configuration has fields that no flag can give."""
    return any(_is_table_list(value) for value in changed_fields(config).values())


def _differences(given: Mapping[str, Any], default: object, prefix: str) -> Iterator[tuple[str, Any]]:
    known = default if isinstance(default, Mapping) else {}
    for name, value in given.items():
        if isinstance(value, Mapping):
            yield from _differences(value, known.get(name), f"{prefix}{name}.")
        elif name not in known or value != known[name]:
            yield f"{prefix}{name}", value


def _flag(name: str, value: object) -> list[str]:
    """Words of a flag: a switch for a boolean, several values for a list."""
    flag = name.replace("_", "-")
    if isinstance(value, bool):
        head, dot, last = flag.rpartition(".")
        return [f"--{head}{dot}{'' if value else 'no-'}{last}"]
    values = _flat(value) if isinstance(value, list) else [str(value)]
    return [f"--{flag}", *values]


def _flat(values: list[Any]) -> list[str]:
    """Values of a list, and of lists in it, as words."""
    return [word for value in values for word in (_flat(value) if isinstance(value, list) else [str(value)])]


def _is_table_list(value: object) -> bool:
    return isinstance(value, list) and any(isinstance(item, Mapping) for item in value)
