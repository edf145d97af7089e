"""One resolver for every kind of plug-in: a registered name, or ``package.module:Class`` from anywhere.

A plug-in inside sjasim is one file in its room that calls `register`; there is no list to edit. Rooms are
imported when a name is first asked for, never at ``import sjasim``.
"""

from __future__ import annotations

import importlib
import pkgutil
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from .errors import PluginError, UnknownNameError

T = TypeVar("T")

PACKAGE = "sjasim"

ROOMS = {
    "anticipation": "anticipation",
    "body": "humans.body",
    "choreography": "choreography",
    "humans": "humans.timing",
    "sensing": "sensors",
    "world": "session",
}
"""Kind of plug-in -> the room whose files may register one."""

APART = {("body", "cmu"): "interop.cmu_humanoid", ("world", "physics"): "simulation.physics_world"}
"""(kind, name) -> module that registers it once it is asked for: its room must not be imported
by rooms below it, or needs what may not be installed."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A resolved plug-in: the class or function, and the config dataclass it takes (or None)."""

    name: str
    factory: Callable[..., object]
    config: type | None


_ENTRIES: dict[str, dict[str, Entry]] = {kind: {} for kind in ROOMS}
_LOADED: set[str] = set()


def register(kind: str, name: str, config: type | None = None) -> Callable[[T], T]:
    """Class or function decorator that makes a plug-in known under a name.

    Args:
        kind: one of `ROOMS`.
        name: what users write, such as ``sia``.
        config: frozen dataclass of the plug-in's options; its defaults are used where none are given.

    Returns:
        the decorator, which returns its argument unchanged.

    Raises:
        PluginError: the kind does not exist or the name is taken by something else.
    """
    if kind not in ROOMS:
        raise PluginError(f"no kind of plug-in named {kind!r}: known are {', '.join(ROOMS)}")

    def keep(item: T) -> T:
        known = _ENTRIES[kind].get(name)
        if known is not None and getattr(known.factory, "__qualname__", "") != getattr(item, "__qualname__", ""):
            raise PluginError(f"{kind} {name!r} is registered already, by {known.factory!r}")
        assert callable(item)
        _ENTRIES[kind][name] = Entry(name, item, config)
        return item

    return keep


def names(kind: str) -> tuple[str, ...]:
    """Names registered for a kind, sorted; loads the room."""
    _load_room(kind)
    return tuple(sorted({*_ENTRIES[kind], *(name for other, name in APART if other == kind)}))


def resolve(kind: str, name: str) -> Entry:
    """Find a plug-in.

    Args:
        kind: one of `ROOMS`.
        name: a registered name or ``package.module:Attribute``.

    Returns:
        the entry; for an outside attribute its config is the attribute's ``config_type``, if it has one.

    Raises:
        UnknownNameError: no such name is registered.
        PluginError: the module cannot be imported or lacks the attribute.
    """
    if ":" in name:
        return _resolve_outside(kind, name)
    _load_room(kind)
    if (kind, name) in APART:
        try:
            importlib.import_module(f"{PACKAGE}.{APART[kind, name]}")
        except ImportError as error:
            raise PluginError(f"{kind} {name!r}: {error}") from error
    if name not in _ENTRIES[kind]:
        raise UnknownNameError(kind, name, names(kind))
    return _ENTRIES[kind][name]


def _resolve_outside(kind: str, name: str) -> Entry:
    module_name, _, attribute = name.partition(":")
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        raise PluginError(f"{kind} {name!r}: cannot import {module_name!r} ({_reason(error)})") from error
    try:
        item = getattr(module, attribute)
    except AttributeError as error:
        raise PluginError(f"{kind} {name!r}: module {module_name!r} has no {attribute!r}") from error
    for entry in _ENTRIES[kind].values():
        if entry.factory is item:
            return entry
    if not callable(item):
        raise PluginError(f"{kind} {name!r} is not a class or function")
    return Entry(name, item, getattr(item, "config_type", None))


def _reason(error: Exception) -> str:
    """Why a module cannot be imported, with the line of its own that is to blame."""
    if isinstance(error, SyntaxError):
        return str(error)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "importlib" not in frame.filename]
    where = f" at {frames[-1].filename}, line {frames[-1].lineno}" if frames[1:] else ""
    return f"{type(error).__name__}: {error}{where}"


def _load_room(kind: str) -> None:
    if kind in _LOADED:
        return
    room = importlib.import_module(f"{PACKAGE}.{ROOMS[kind]}")
    for module in pkgutil.iter_modules(room.__path__, prefix=f"{room.__name__}."):
        importlib.import_module(module.name)
    _LOADED.add(kind)
