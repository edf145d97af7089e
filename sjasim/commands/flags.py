"""Command-line flags of a dataclass of options.

tyro makes flags of any dataclass. `Flags` gives it a copy of the dataclass whose fields are in the order a user needs
them and whose help texts fit a terminal, and makes the real options of what tyro has parsed.
"""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import tyro

from ..config.toml_file import checked_value

T = TypeVar("T")

INLINE = "inline"
"""Annotation of a field of `Options` whose own fields become flags without a prefix."""

SCALAR = float | int | bool | str
"""What an option of a plug-in may be, where its annotation says nothing that a command line can parse."""


class Flags(Generic[T]):
    """The flags of a dataclass of options.

    Args:
        options: the dataclass. Fields that are dataclasses themselves become groups of flags ``--field.name``, or flags
            without a prefix where they are annotated with `INLINE`. Tuples of dataclasses get no flags.
        default: values of what is not given; None for the dataclass's own.
        first: names of the fields that come first in the help.
        omitted: names of the fields that get no flag; ``Class.field`` names a field of one dataclass only.
        tables: field that holds a mapping -> the dataclass whose fields are its keys. Other mappings get no flags.
    """

    def __init__(
        self,
        options: type[T],
        default: T | None = None,
        *,
        first: Sequence[str] = (),
        omitted: Sequence[str] = (),
        tables: Mapping[str, type] | None = None,
    ) -> None:
        self._options = options
        self._default = default
        self._omitted = tuple(omitted)
        self._tables = dict(tables or {})
        rows = self._rows(options, default)
        # The sort is stable: fields that are not named keep their order.
        rows.sort(key=lambda row: first.index(row[0]) if row[0] in first else len(first))
        self.parsed_type = _make(options.__name__, rows)
        """The dataclass for tyro."""

    def options(self, parsed: object) -> T:
        """The options of what tyro has parsed.

        Raises:
            ConfigError: a value is not allowed.
        """
        options: T = self._built(self._options, self._default, parsed)
        return options

    def _rows(self, options: type, default: object) -> list[tuple[str, Any, Any]]:
        """(name, annotation, default) of every flag or group of flags."""
        hints = get_type_hints(options, include_extras=True)
        texts = attribute_texts(options)
        rows: list[tuple[str, Any, Any]] = []

        for field in dataclasses.fields(options):
            hint, extras = _split(hints[field.name])
            value = _value(field, default)
            text = texts.get(field.name, "")

            if field.name in self._tables:
                table = self._tables[field.name]
                # A copy of the dataclass: its own checks run, guarded, where the plug-in is made.
                group = _make(table.__name__, _table_rows(table, value))
                rows.append((field.name, Annotated[group, tyro.conf.arg(help=text)], dataclasses.MISSING))
            elif dataclasses.is_dataclass(hint) and INLINE in extras:
                rows += self._rows(hint, value)  # type: ignore[arg-type]
            elif dataclasses.is_dataclass(hint):
                group = _make(hint.__name__, self._rows(hint, value))  # type: ignore[union-attr,arg-type]
                rows.append((field.name, Annotated[group, tyro.conf.arg(help=text)], dataclasses.MISSING))
            elif not self._without_flag(options, field.name, hint):
                rows.append((field.name, _annotated(hint, extras, value, text), value))
        return rows

    def _built(self, options: Any, default: object, parsed: Any) -> Any:
        """An instance of the dataclass with the parsed values, and the defaults of fields without flags."""
        values = {}
        for field in dataclasses.fields(options):
            hint, extras = _split(get_type_hints(options, include_extras=True)[field.name])
            value = _value(field, default)

            if field.name in self._tables:
                values[field.name] = _changed(self._tables[field.name], value, getattr(parsed, field.name))
            elif dataclasses.is_dataclass(hint):
                nested = parsed if INLINE in extras else getattr(parsed, field.name)
                values[field.name] = self._built(hint, value, nested)
            elif self._without_flag(options, field.name, hint):
                values[field.name] = value
            else:
                values[field.name] = getattr(parsed, field.name)
        return options(**values)

    def _without_flag(self, options: type, name: str, hint: Any) -> bool:
        """Whether a field of a dataclass gets no flag: an omitted one, a mapping, or a tuple of dataclasses."""
        origin = get_origin(hint)
        if isinstance(origin, type) and issubclass(origin, Mapping):
            return True
        of_dataclasses = origin is tuple and any(dataclasses.is_dataclass(item) for item in get_args(hint))
        return of_dataclasses or name in self._omitted or f"{options.__name__}.{name}" in self._omitted


def attribute_texts(options: type) -> dict[str, str]:
    """Field -> what the ``Attributes:`` or ``Args:`` section of a Google-style docstring says of it, as one line.

    Backticks are left out: they mean nothing on a terminal.
    """
    texts: dict[str, str] = {}
    field = ""
    indent = None
    for line in (options.__doc__ or "").expandtabs().splitlines():
        depth = len(line) - len(line.lstrip())
        words = line.strip()

        if words in ("Attributes:", "Args:"):
            indent = None  # that of the first field decides
            field = "start"
        elif not field or not words:
            continue
        elif indent is not None and depth < indent:  # the section is over
            field = ""
        elif indent is None or depth == indent:
            indent = depth
            name, _, text = words.partition(":")
            field = name.partition(" ")[0]
            texts[field] = text.strip()
        else:  # a deeper line continues the text of the field
            texts[field] = f"{texts[field]} {words}".strip()
    return {name: text.replace("`", "") for name, text in texts.items()}


def _make(name: str, rows: Sequence[tuple[str, Any, Any]]) -> type:
    """A keyword-only dataclass of (name, annotation, default); groups of flags get their own defaults."""
    fields = []
    for field, hint, default in rows:
        group = _split(hint)[0]
        # A group has a default only if each of its fields has one.
        if dataclasses.is_dataclass(group):
            needed = any(
                item.default is dataclasses.MISSING and item.default_factory is dataclasses.MISSING
                for item in dataclasses.fields(group)
            )
            given = {} if needed else {"default_factory": group}
        else:
            given = {} if default is dataclasses.MISSING else {"default": default}
        fields.append((field, hint, dataclasses.field(**given)))  # type: ignore[call-overload]
    return dataclasses.make_dataclass(name, fields, kw_only=True, frozen=True, namespace={"__doc__": ""})


def _table_rows(table: type, given: Mapping[str, object]) -> list[tuple[str, Any, Any]]:
    """(name, annotation, default) of a plug-in's options.

    Raises:
        ConfigError: a given value is not of the option's type.
    """
    texts = attribute_texts(table)
    rows = []
    for field, hint in _plug_in_fields(table):
        value = _value(field, None)
        if field.name in given:
            value = checked_value(hint, given[field.name], f"method_options.{field.name}")
        rows.append((field.name, _annotated(hint, (), value, texts.get(field.name, "")), value))
    return rows


def _plug_in_fields(table: type) -> list[tuple[dataclasses.Field[Any], Any]]:
    """The options of a plug-in that a command line can give, and annotations that it can parse."""
    try:
        hints = get_type_hints(table)
    except Exception:  # a user's annotations may name what does not exist at run time
        hints = {}

    out = []
    for field in dataclasses.fields(table):
        value = _value(field, None)
        hint = hints.get(field.name)
        # tyro refuses a default that does not fit the annotation, so that one is widened.
        if value is None:
            hint = SCALAR | None
        elif hint not in (float, int, bool, str) and get_origin(hint) is not Literal:
            hint = SCALAR
        if value in (None, dataclasses.MISSING) or isinstance(value, SCALAR):
            out.append((field, hint))
    return out


def _changed(table: type, given: Mapping[str, object], parsed: object) -> dict[str, object]:
    """The mapping with what was given: its keys so far, and every value that is not the plug-in's default."""
    out = dict(given)
    for field, _ in _plug_in_fields(table):
        value = getattr(parsed, field.name)
        if field.name in given or value != _value(field, None):
            out[field.name] = value
    return out


def _annotated(hint: Any, extras: Sequence[Any], default: object, text: str) -> Any:
    """The annotation with its help text, a metavar without ``None``, and the default as people write it."""
    settings: dict[str, Any] = {"help": text}
    if default is dataclasses.MISSING:
        settings["help_behavior_hint"] = "(required)"
    else:
        settings["help_behavior_hint"] = _hint_of_default(default)

    # A user cannot type None, so the metavar does not offer it.
    kinds = [kind for kind in get_args(hint) if kind is not type(None)]
    optional = get_origin(hint) in (Union, types.UnionType) and len(kinds) == 1
    own_metavar = [item for item in extras if isinstance(item, Metavar)]
    if own_metavar:
        settings["metavar"] = own_metavar[0].text
    elif optional and kinds[0] in (Path, str, float, int):
        settings["metavar"] = kinds[0].__name__.upper()
    elif set(kinds) == set(get_args(SCALAR)):
        settings["metavar"] = "VALUE"

    out: Any = Annotated[hint, tyro.conf.arg(**settings)]
    for item in extras:
        if not isinstance(item, Metavar):
            out = Annotated[out, item]
    return out


@dataclasses.dataclass(frozen=True)
class Metavar:
    """Annotation of a field: what stands for its value in the help, such as ``DIR``."""

    text: str


def _hint_of_default(default: object) -> str:
    """``(default: 1.4)``; "" for what is not given unless asked for, and for switches."""
    if default is None or isinstance(default, bool) or default in ("", ()):
        return ""
    return f"(default: {_written(default)})"


def _written(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(_written(item) for item in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _value(field: dataclasses.Field[Any], default: object) -> Any:
    """A field's default: that of an instance if there is one; MISSING if it has none."""
    if default is not None:
        return getattr(default, field.name)
    return field.default if field.default_factory is dataclasses.MISSING else field.default_factory()


def _split(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    """An annotation and what ``Annotated`` adds to it."""
    if get_origin(hint) is Annotated:
        inner, *extras = get_args(hint)
        return inner, tuple(extras)
    return hint, ()
