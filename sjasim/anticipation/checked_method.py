"""Validation of the actions that a method returns, so that an error in a user's method is reported with its name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from numbers import Integral, Real
from reprlib import repr as short_repr

import numpy as np

from ..core.errors import HookError, PluginError, SjasimError
from ..core.method_io import CancelCommand, MethodAction, MethodContext, ScheduleCommand, SetTimer
from .method import Follower, Method

_EXPECTED = "a sequence of ScheduleCommand, CancelCommand and SetTimer is wanted"

_FIELD_TYPES: dict[str, tuple[type, str]] = {
    "iteration": (Integral, "a whole number"),
    "ordinal": (Integral, "a whole number"),
    "t_s": (Real, "a session time in seconds"),
    "why": (str, "a string"),
    "person": (str, "a string"),
}
"""Field of an action -> its type, and that type in words."""

_ACTION_FIELDS: dict[type, dict[str, tuple[type, str]]] = {
    action: {field.name: _FIELD_TYPES[field.name] for field in fields(action) if field.name in _FIELD_TYPES}
    for action in (ScheduleCommand, CancelCommand, SetTimer)
}
"""Type of an action -> its fields that are checked, with their types."""


class CheckedMethod:
    """Calls the hooks of a method and checks what they return.

    Args:
        name: name by which the user selected the method, for error messages.
        method: the method.
    """

    def __init__(self, name: str, method: Method) -> None:
        self._name = name
        self._method = method
        self._cast: tuple[str, ...] = ()

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Reset the method for a dance.

        Raises:
            HookError: the method's own code failed.
        """
        self._cast = context.cast
        self._call_hook("reset", 0.0, (context, rng))

    def call(self, hook: str, event_time_s: float, arguments: tuple[object, ...]) -> Sequence[MethodAction]:
        """Call a hook and return its actions.

        Args:
            hook: name of the hook, such as ``on_event``.
            event_time_s: session time of the event, boundary or timer for which the hook is called [s]; a timer that
                the hook sets must lie after it.
            arguments: the hook's arguments.

        Raises:
            PluginError: the hook did not return a sequence of actions, a field of an action has a wrong type, or a
                timer does not lie in the future.
            HookError: the method's own code failed.
        """
        actions = self._call_hook(hook, event_time_s, arguments)
        # Most calls return an empty tuple.
        if type(actions) is tuple and not actions:
            return ()

        if isinstance(actions, str | bytes) or not isinstance(actions, Sequence):
            raise PluginError(f"{self._name}.{hook} returned {short_repr(actions)}; {_EXPECTED}")
        for action in actions:
            self._check_action(hook, event_time_s, action)
        return actions

    def follows(self, iteration: int, event_time_s: float) -> tuple[str, ...] | None:
        """Whom the robot follows in an iteration: names of dancers, () for nobody, None for everyone.

        None as well for a method that does not say whom it follows.

        Raises:
            PluginError: the answer is neither None nor a sequence of names of the cast.
            HookError: the method's own code failed.
        """
        if not isinstance(self._method, Follower):
            return None
        persons = self._call_hook("follows", event_time_s, (iteration,))
        if persons is None:
            return None

        if not isinstance(persons, tuple | list) or not all(isinstance(person, str) for person in persons):
            raise PluginError(
                f"{self._name}.follows returned {short_repr(persons)}; a tuple of names or None is wanted"
            )
        unknown = [person for person in persons if person not in self._cast]
        if unknown:
            raise PluginError(
                f"{self._name}.follows returned {unknown}; names among {', '.join(self._cast)} are wanted"
            )
        return tuple(persons)

    def _call_hook(self, hook: str, event_time_s: float, arguments: tuple[object, ...]) -> object:
        """Result of a hook; exceptions of the method's own code become a `HookError` that names the hook."""
        try:
            return getattr(self._method, hook)(*arguments)
        except SjasimError:
            raise
        except Exception as error:
            what = f"{type(error).__name__}: {error}"
            raise HookError(f"{self._name}.{hook} failed at session time {event_time_s:.3f} s: {what}") from error

    def _check_action(self, hook: str, event_time_s: float, action: object) -> None:
        """Raise a `PluginError` for what is no action, for a field of a wrong type, and for a timer in the past."""
        if type(action) not in _ACTION_FIELDS:
            raise PluginError(f"{self._name}.{hook} returned {short_repr(action)} among its answers; {_EXPECTED}")

        for field, (kind, words) in _ACTION_FIELDS[type(action)].items():
            if not isinstance(value := getattr(action, field), kind):
                answer = f"{type(action).__name__}.{field} = {value!r}"
                raise PluginError(f"{self._name}.{hook}: {answer} is not allowed: {words}")

        if isinstance(action, SetTimer) and not event_time_s < action.t_s < np.inf:
            answer = f"SetTimer.t_s = {action.t_s:g} is not allowed at session time {event_time_s:g} s"
            raise PluginError(f"{self._name}.{hook}: {answer}: a SetTimer must lie in the future")
