"""Registry of plug-ins, which are found by a registered name or as ``package.module:Class``.

A plug-in that is part of sjasim is one file in the folder of its kind, which calls `register`; no list has to be
edited. The modules of a folder are imported when a name of its kind is first resolved, not by ``import sjasim``, which
keeps that import fast.
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

FOLDERS = {
    "anticipation": "anticipation",
    "body": "humans.body",
    "choreography": "choreography",
    "humans": "humans.timing",
    "sensing": "sensors",
    "world": "session",
}
"""Kind of plug-in -> package, relative to ``sjasim``, whose modules register plug-ins of this kind."""

WORDS = {"anticipation": "method", "choreography": "dance"}
"""Kind of plug-in -> what messages to users call it, where that is not the kind itself."""

REGISTERED_ELSEWHERE = {("body", "cmu"): "interop.cmu_humanoid", ("world", "physics"): "simulation.physics_world"}
"""(kind, name) -> module outside the kind's folder that registers this plug-in.

The module is imported only when the name is resolved, because it needs optional packages, or packages of sjasim that
the kind's folder must not import.
"""


@dataclass(frozen=True, slots=True)
class Entry:
    """A resolved plug-in: its name, its class or function, and the dataclass of its options (None without options)."""

    name: str
    factory: Callable[..., object]
    config: type | None


_ENTRIES: dict[str, dict[str, Entry]] = {kind: {} for kind in FOLDERS}
_LOADED: set[str] = set()


def register(kind: str, name: str, config: type | None = None) -> Callable[[T], T]:
    """Return a decorator that registers a class or function under a name.

    Args:
        kind: kind of plug-in, a key of `FOLDERS`.
        name: name by which users select the plug-in, such as ``sia``.
        config: frozen dataclass of the plug-in's options; its defaults apply to options that are not given.

    Returns:
        the decorator, which returns its argument unchanged.

    Raises:
        PluginError: the kind does not exist, or another plug-in has the name.
    """
    if kind not in FOLDERS:
        raise PluginError(f"no kind of plug-in named {kind!r}: known are {', '.join(FOLDERS)}")

    def add(item: T) -> T:
        # Importing a module a second time, as importlib.reload does, registers the same class again.
        known = _ENTRIES[kind].get(name)
        if known is not None and getattr(known.factory, "__qualname__", "") != getattr(item, "__qualname__", ""):
            raise PluginError(f"{kind} {name!r} is registered already, by {known.factory!r}")
        assert callable(item)
        _ENTRIES[kind][name] = Entry(name, item, config)
        return item

    return add


def names(kind: str) -> tuple[str, ...]:
    """Return the sorted names of all registered plug-ins of a kind."""
    _load_folder(kind)
    return tuple(sorted({*_ENTRIES[kind], *(name for other, name in REGISTERED_ELSEWHERE if other == kind)}))


def resolve(kind: str, name: str) -> Entry:
    """Find a plug-in, and import its module if necessary.

    Args:
        kind: kind of plug-in, a key of `FOLDERS`.
        name: a registered name or ``package.module:Attribute``.

    Returns:
        the entry. For a plug-in that is given by its module, `Entry.config` is the attribute ``config_type`` of the
        class or function, or None.

    Raises:
        UnknownNameError: no such name is registered.
        PluginError: the module cannot be imported or lacks the attribute.
    """
    if ":" in name:
        return _resolve_outside(kind, name)

    _load_folder(kind)
    if (kind, name) in REGISTERED_ELSEWHERE:
        try:
            importlib.import_module(f"{PACKAGE}.{REGISTERED_ELSEWHERE[kind, name]}")
        except ImportError as error:
            raise PluginError(f"{kind} {name!r}: {error}") from error

    if name not in _ENTRIES[kind]:
        raise UnknownNameError(WORDS.get(kind, kind), name, names(kind))
    return _ENTRIES[kind][name]


def _resolve_outside(kind: str, name: str) -> Entry:
    """Import a plug-in that is named as ``module:Attribute``."""
    module_name, _, attribute = name.partition(":")
    word = WORDS.get(kind, kind)
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        raise PluginError(f"{word} {name!r}: cannot import {module_name!r} ({_reason(error)})") from error
    try:
        item = getattr(module, attribute)
    except AttributeError as error:
        raise PluginError(f"{word} {name!r}: module {module_name!r} has no {attribute!r}") from error
    for entry in _ENTRIES[kind].values():
        if entry.factory is item:
            return entry
    if not callable(item):
        raise PluginError(f"{word} {name!r} is not a class or function")
    return Entry(name, item, getattr(item, "config_type", None))


def _reason(error: Exception) -> str:
    """Return the error of a failed import, with the file and line where it was raised."""
    if isinstance(error, SyntaxError):
        return str(error)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "importlib" not in frame.filename]
    where = f" at {frames[-1].filename}, line {frames[-1].lineno}" if frames[1:] else ""
    return f"{type(error).__name__}: {error}{where}"


def _load_folder(kind: str) -> None:
    """Import all modules of a kind's folder, so that they register their plug-ins; later calls have no effect."""
    if kind in _LOADED:
        return
    room = importlib.import_module(f"{PACKAGE}.{FOLDERS[kind]}")
    for module in pkgutil.iter_modules(room.__path__, prefix=f"{room.__name__}."):
        importlib.import_module(module.name)
    _LOADED.add(kind)
