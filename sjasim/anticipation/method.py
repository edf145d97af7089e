"""The contract of an anticipation method, and how to write one.

A method decides when the robot performs each of the context's steps. It is told of events as they reach the server,
of the iterations' beginnings and ends, and of timers it asked for, and answers with values:

- `ScheduleCommand`: send the command for a step at a session time; a later one for the same step replaces it, and a
  time that has passed means at once. Once a command is sent its step is over.
- `CancelCommand`: do not send that step's command after all.
- `SetTimer`: call ``on_timer`` at a session time, which must lie in the future.

A method that follows some dancers rather than all of them says whom with `Follower.follows`: the paper's edges of the
group depend on it, and the net latency. Nothing else is needed: no clock, no polling, no knowledge of links or of the
robot's speed. To write a method, put a class with the five methods below in a file of this room, with a frozen
dataclass of its options::

    @register("anticipation", "echo", config=EchoConfig)
    class Echo:
        def __init__(self, config: EchoConfig = EchoConfig()) -> None: ...
        def reset(self, context, rng): ...
        def on_event(self, event): return (ScheduleCommand(event.iteration, 0, event.t_arrival_s, "echo"),)
        def on_iteration_start(self, iteration, t_s): return ()
        def on_iteration_end(self, iteration, t_s): return ()
        def on_timer(self, t_s): return ()

or keep it in a module of your own (``--method my_module:Echo``; options then come from the class attribute
``config_type``, if there is one). ``reset`` must put the method back into the state of a new one. A method never
sees the truth or the dancers' plan: events and the context are all there is.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, runtime_checkable

import numpy as np

from ..config import HUMANS_ONLY
from ..core import Event
from ..core.errors import ConfigError, HookError, PluginError, SjasimError, UnknownNameError
from ..core.method_io import MethodAction, MethodContext
from ..core.registry import resolve


@runtime_checkable
class Method(Protocol):
    """What the session calls; every hook answers at once and may answer nothing."""

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Begin a dance: forget everything, remember the context; ``rng`` is the method's own random stream."""
        ...

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """An event has reached the server, at ``event.t_arrival_s``; in order of arrival, not of ``t_s``."""
        ...

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Beat 0 of an iteration; iteration 0 is the rehearsal, in which the robot does not dance."""
        ...

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """An iteration's window has closed; the next one's first events may come before its beat 0."""
        ...

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """A time asked for with `SetTimer` has come."""
        ...


@runtime_checkable
class Follower(Protocol):
    """What a method may have besides."""

    def follows(self, iteration: int) -> tuple[str, ...] | None:
        """Whom the robot follows in an iteration that begins; empty for nobody, None for everyone."""
        ...


def build_method(name: str, options: Mapping[str, float | int | bool | str] | None = None) -> Method:
    """Make a method from its name and options.

    Args:
        name: a registered name or ``module:Class``.
        options: fields of the method's config; what is missing keeps its default.

    Raises:
        UnknownNameError: nothing is registered under the name.
        ConfigError: an option the method does not have, or a value it does not allow.
        PluginError: the object lacks one of the contract's methods, or something cannot be called as it has to be.
        HookError: the object's own code failed.
    """
    try:
        entry = resolve("anticipation", name)
    except UnknownNameError as error:
        raise UnknownNameError("anticipation", name, (*error.known, HUMANS_ONLY)) from None
    given = dict(options or {})
    if entry.config is None:
        if given:
            raise ConfigError("method_options", given, f"nothing: {name!r} has no options")
        method = _made(name, entry.factory)
    else:
        method = _made(name, entry.factory, _options(name, entry.config, given))
    if not isinstance(method, Method):
        missing = [hook for hook in HOOKS if not callable(getattr(method, hook, None))]
        raise PluginError(f"anticipation {name!r} lacks {', '.join(missing)}")
    for hook, arguments in HOOKS.items():
        _check_call(f"{name}.{hook}", getattr(method, hook), arguments)
    return method


def _options(name: str, config: type, given: Mapping[str, object]) -> object:
    """The method's options, of its own dataclass."""
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
    return _guarded(name, lambda: config(**given))


def _made(name: str, factory: Callable[..., object], *options: object) -> object:
    """A new method."""
    _check_call(name, factory, ("config",) if options else ())
    return _guarded(name, lambda: factory(*options))


def _guarded(name: str, make: Callable[[], object]) -> object:
    """What the user's own code makes, or an error that names it and has the code's own as its cause."""
    try:
        return make()
    except SjasimError:
        raise
    except Exception as error:
        raise HookError(f"{name} cannot be made: {type(error).__name__}: {error}") from error


def _check_call(name: str, function: Callable[..., object], arguments: Sequence[str]) -> None:
    """Refuse what cannot be called with these arguments, in their order."""
    try:
        signature = inspect.signature(function)
    except ValueError:  # some built-in ones do not tell
        return
    try:
        signature.bind(*arguments)
    except TypeError as error:
        raise PluginError(
            f"{name} is called with ({', '.join(arguments)}), but takes {signature}: {error}"
            + ("; options come from the class attribute config_type" if not arguments else "")
        ) from None


HOOKS = {
    "reset": ("context", "rng"),
    "on_event": ("event",),
    "on_iteration_start": ("iteration", "t_s"),
    "on_iteration_end": ("iteration", "t_s"),
    "on_timer": ("t_s",),
}
"""The contract's methods and their arguments."""
