"""Reads the command line of ``sjasim study``: a design, and the common fields of its sessions' configuration."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, get_type_hints

from ..commands.flags import INLINE, Flags, Metavar, attribute_texts
from ..commands.former_flags import present_flags
from ..commands.options import UsageError, parse_flags
from ..commands.session_options import value_of
from ..config.toml_file import read_toml
from ..core.errors import SjasimError
from ..core.registry import resolve
from .design_file import factors_from_words, read_design
from .study_design import StudyDesign
from .study_execution import Execution
from .study_folder import stored_design

FIRST = ("groups", "methods", "humans", "fidelity", "out", "backend", "jobs", "resume", "design", "factors")
"""Options that come first in the help."""

OMITTED = ("SessionConfig.method", "SessionConfig.humans", "SessionConfig.seed", "SessionConfig.performance",
           "DanceConfig.name")  # fmt: skip
"""Fields that the design gives to every session."""


@dataclass(frozen=True)
class Options:
    """Options of ``sjasim study``.

    Attributes:
        plan: the design.
        execution: where and how it is computed.
        design: TOML file with a design; flags override it.
        factors: factors to sweep: NAME=LEVEL,LEVEL,... such as ``dance.bpm=100,118``.
        dry_run: print the sessions of a group, the computing time and the room on disk, and stop.
        json: print study.json on stdout, and nothing else.
        config: TOML file with the common fields of the sessions' configuration; flags override it.
    """

    plan: Annotated[StudyDesign, INLINE] = field(default_factory=StudyDesign)
    execution: Annotated[Execution, INLINE] = field(default_factory=Execution)
    design: Annotated[Path | None, Metavar("FILE.toml")] = None
    factors: Annotated[tuple[str, ...], Metavar("NAME=LEVELS ...")] = ()
    dry_run: bool = False
    json: bool = False
    config: Annotated[Path | None, Metavar("FILE.toml")] = None


def parse_study(arguments: Sequence[str], program: str, about: str) -> Options:
    """Read a command line.

    With ``--resume`` and no design of its own, the command continues the design that is stored in the folder.

    Args:
        arguments: the command line without the program's name.
        program: what the user typed, for the help and for messages.
        about: what the command does, for the help.

    Raises:
        UsageError: an argument is unknown or malformed.
        ConfigError: a file cannot be read, or a value is not allowed.
    """
    if value_of("method", arguments) is not None:
        raise UsageError("--method is an option of other commands; a study compares --methods")
    base = _base_design(arguments)
    table = _method_options(_methods(arguments) or base.methods)
    tables = {"method_options": table} if set(base.session.method_options) <= _field_names(table) else {}
    flags = Flags(Options, Options(plan=base), first=FIRST, omitted=OMITTED, tables=tables)
    options = parse_flags(flags, present_flags(arguments), program, about)

    plan = replace(options.plan, factors={**options.plan.factors, **factors_from_words(options.factors)})
    if options.execution.resume and options.execution.out is not None and plan == StudyDesign():
        plan = stored_design(options.execution.out) or plan
    return replace(options, plan=plan)


def _base_design(arguments: Sequence[str]) -> StudyDesign:
    """The design of the files that the command line names; the default one without them."""
    design = StudyDesign()
    common = value_of("config", arguments)
    if common is not None:
        design = replace(design, session=read_toml(common, design.session))
    path = value_of("design", arguments)
    return design if path is None else read_design(path, design)


def _methods(arguments: Sequence[str]) -> tuple[str, ...]:
    """The methods that a command line names: their options get flags, so they are read before the line is parsed."""
    words = list(arguments)
    found: list[str] = []
    for index, word in enumerate(words):
        if word.startswith("--methods="):
            found = [word.partition("=")[2]]
        elif word == "--methods":
            following = words[index + 1 :]
            end = next((place for place, item in enumerate(following) if item.startswith("--")), len(following))
            found = following[:end]
    return tuple(found)


def _method_options(methods: Sequence[str]) -> type:
    """A dataclass with the options of all methods; of options with the same name, those of the first method."""
    rows: dict[str, tuple[str, Any, Any]] = {}
    texts: dict[str, str] = {}
    for config in _option_classes(methods):
        hints = _hints(config)
        for item in dataclasses.fields(config):
            default: Any = dataclasses.field(default=item.default, default_factory=item.default_factory)
            rows.setdefault(item.name, (item.name, hints.get(item.name), default))
        texts = {**attribute_texts(config), **texts}

    made: type = dataclasses.make_dataclass("MethodOptions", list(rows.values()), kw_only=True)
    lines = [f"    {name}: {text}" for name, text in texts.items()]
    made.__doc__ = "\n".join(["Options of the methods.", "", "Attributes:", *lines])
    return made


def _option_classes(methods: Sequence[str]) -> list[type]:
    """The dataclasses of the methods' options. A method that does not exist is refused with the design, in one line."""
    classes = []
    for method in methods:
        with contextlib.suppress(SjasimError):
            config = resolve("anticipation", method).config
            if config is not None and dataclasses.is_dataclass(config):
                classes.append(config)
    return classes


def _hints(config: type) -> dict[str, object]:
    """Annotations of a dataclass; none if a user's annotations name what does not exist at run time."""
    try:
        return dict(get_type_hints(config))
    except Exception:
        return {}


def _field_names(table: type) -> set[str]:
    return {item.name for item in dataclasses.fields(table)}
