"""The protocol of an anticipation method, how to write one, and how one is built from its name and options.

A method decides when the robot performs each step of the dance. The session calls its hooks: when an event reaches
the server, when an iteration begins or ends, and when a timer is due that the method has set. A hook returns actions:

- `ScheduleCommand`: send the command for a step at a session time. A later action for the same step replaces it, and
  a time that has passed means at once. Once a command has been sent, its step is over.
- `CancelCommand`: do not send the scheduled command of a step.
- `SetTimer`: call ``on_timer`` at a session time in the future.

A method that follows some of the dancers says whom with `Follower.follows`; the group's graph and the net latency are
computed from it. A method needs no clock, no polling, and no knowledge of links or of the robot's speed. To write one,
put a class with the five methods of `Method` in a file of this folder, with a frozen dataclass of its options::

    @register("anticipation", "echo", config=EchoConfig)
    class Echo:
        def __init__(self, config: EchoConfig = EchoConfig()) -> None: ...
        def reset(self, context, rng): ...
        def on_event(self, event): return (ScheduleCommand(event.iteration, 0, event.t_arrival_s, "echo"),)
        def on_iteration_start(self, iteration, t_s): return ()
        def on_iteration_end(self, iteration, t_s): return ()
        def on_timer(self, t_s): return ()

or keep it in a module of your own and name it ``--method my_module:Echo``; the class attribute ``config_type`` then
names the dataclass of its options, if it has any. ``docs/examples/follow_first.py`` is a complete one. ``reset`` must
restore the state of a new object. A method never sees ground truth or the dancers' plan, only events and its context.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, runtime_checkable
from weakref import WeakSet

import numpy as np

from ..config import HUMANS_ONLY
from ..core import Event
from ..core.errors import ConfigError, HookError, PluginError, SjasimError, UnknownNameError
from ..core.method_io import MethodAction, MethodContext
from ..core.registry import resolve

HOOKS = {
    "reset": ("context", "rng"),
    "on_event": ("event",),
    "on_iteration_start": ("iteration", "t_s"),
    "on_iteration_end": ("iteration", "t_s"),
    "on_timer": ("t_s",),
}
"""Methods that every anticipation method has, and their arguments."""


_CHECKED_CLASSES: WeakSet[type] = WeakSet()
"""Classes of methods whose hooks accept their arguments."""


@runtime_checkable
class Method(Protocol):
    """An anticipation method; every hook returns its actions at once, or an empty sequence."""

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Prepare for a dance: forget the last one.

        Args:
            context: cast, steps and times of the dance.
            rng: the method's own random stream.
        """
        ...

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """An event has reached the server, at ``event.t_arrival_s``.

        Events come in order of arrival, which is not always the order of their times ``t_s``.
        """
        ...

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Beat 0 of an iteration; iteration 0 is the rehearsal, in which the robot does not dance."""
        ...

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """The end of an iteration's window; the first events of the next one may come before its beat 0."""
        ...

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """A time that the method has set with `SetTimer` has come."""
        ...


@runtime_checkable
class Follower(Protocol):
    """Optional part of an anticipation method: one that follows some of the dancers says whom."""

    def follows(self, iteration: int) -> tuple[str, ...] | None:
        """Whom the robot follows in an iteration that begins: names of dancers, () for nobody, None for everyone."""
        ...


def build_method(name: str, options: Mapping[str, float | int | bool | str] | None = None) -> Method:
    """Build a method from its name and options.

    Args:
        name: a registered name or ``module:Class``.
        options: fields of the method's options; those left out keep their defaults.

    Raises:
        UnknownNameError: nothing is registered under the name.
        ConfigError: the method has no such option, or does not allow the value.
        PluginError: the object lacks one of the hooks, or a hook does not accept its arguments.
        HookError: the method's own code failed.
    """
    try:
        entry = resolve("anticipation", name)
    except UnknownNameError as error:
        raise UnknownNameError("method", name, (*error.known, HUMANS_ONLY)) from None

    given = dict(options or {})
    if entry.config is None:
        if given:
            raise ConfigError("method_options", given, f"nothing: {name!r} has no options")
        method = _instantiate(name, entry.factory)
    else:
        method = _instantiate(name, entry.factory, _build_options(name, entry.config, given))

    if not isinstance(method, Method):
        missing = [hook for hook in HOOKS if not callable(getattr(method, hook, None))]
        raise PluginError(f"anticipation {name!r} lacks {', '.join(missing)}")
    # Once for each class is enough, and inspecting signatures takes as long as many events.
    if type(method) not in _CHECKED_CLASSES:
        for hook, arguments in HOOKS.items():
            _check_signature(f"{name}.{hook}", getattr(method, hook), arguments)
        _CHECKED_CLASSES.add(type(method))
    return method


def _build_options(name: str, config: type, given: Mapping[str, object]) -> object:
    """An instance of the method's options dataclass."""
    if not dataclasses.is_dataclass(config):
        raise PluginError(f"anticipation {name!r}: its config_type, {config!r}, is not a dataclass")

    fields = {field.name: field for field in dataclasses.fields(config)}
    unknown = [key for key in given if key not in fields]
    if unknown:
        raise ConfigError("method_options", unknown, f"options of {name!r}: {', '.join(fields)}")
    missing = [
        key
        for key, field in fields.items()
        if key not in given and field.default is field.default_factory is dataclasses.MISSING
    ]
    if missing:
        raise ConfigError("method_options", dict(given), f"{name!r} needs {', '.join(missing)}")

    return _call_plugin(name, lambda: config(**given))


def _instantiate(name: str, factory: Callable[..., object], *options: object) -> object:
    """A new object of the method's class."""
    _check_signature(name, factory, ("config",) if options else ())
    return _call_plugin(name, lambda: factory(*options))


def _call_plugin(name: str, call: Callable[[], object]) -> object:
    """Result of a call into the user's own code; its exceptions become a `HookError` that names the method."""
    try:
        return call()
    except SjasimError:
        raise
    except Exception as error:
        raise HookError(f"{name} cannot be made: {type(error).__name__}: {error}") from error


def _check_signature(name: str, function: Callable[..., object], arguments: Sequence[str]) -> None:
    """Raise a `PluginError` if a function cannot be called with these positional arguments."""
    try:
        signature = inspect.signature(function)
    except ValueError:  # some built-in functions have no signature
        return
    try:
        signature.bind(*arguments)
    except TypeError as error:
        hint = "" if arguments else "; options come from the class attribute config_type"
        raise PluginError(
            f"{name} is called with ({', '.join(arguments)}), but takes {signature}: {error}{hint}"
        ) from None
