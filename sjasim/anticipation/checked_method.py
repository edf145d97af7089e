"""Every question that the session puts to a method, and what its answers must be: wrong ones are named at once."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral, Real
from reprlib import repr as shortened

import numpy as np

from ..core.errors import HookError, PluginError, SjasimError
from ..core.method_io import CancelCommand, MethodAction, MethodContext, ScheduleCommand, SetTimer
from .method import Follower, Method

WANTED = "a sequence of ScheduleCommand, CancelCommand and SetTimer is wanted"
FIELDS: dict[str, tuple[type, str]] = {
    "iteration": (Integral, "a whole number"),
    "ordinal": (Integral, "a whole number"),
    "t_s": (Real, "a session time in seconds"),
    "why": (str, "a string"),
    "person": (str, "a string"),
}
"""Field of an answer -> its type, and that in words."""


class CheckedMethod:
    """Calls a method's hooks, and refuses answers that nobody could act upon.

    Args:
        name: what the user calls the method.
        method: whose hooks.
    """

    def __init__(self, name: str, method: Method) -> None:
        self._name = name
        self._method = method
        self._cast: tuple[str, ...] = ()

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Begin a dance.

        Raises:
            HookError: the method's own code failed.
        """
        self._cast = context.cast
        self._call("reset", 0.0, (context, rng))

    def call(self, hook: str, told_s: float, given: tuple[object, ...]) -> Sequence[MethodAction]:
        """A hook's answers.

        Args:
            hook: such as ``on_event``.
            told_s: session time of what the method is told.
            given: the hook's arguments.

        Raises:
            PluginError: the answer is none, or a `SetTimer` does not lie in the future.
            HookError: the method's own code failed.
        """
        answers = self._call(hook, told_s, given)
        if type(answers) is tuple and not answers:
            return ()
        if isinstance(answers, str | bytes) or not isinstance(answers, Sequence):
            raise PluginError(f"{self._name}.{hook} returned {shortened(answers)}; {WANTED}")
        for item in answers:
            self._check(hook, told_s, item)
        return answers

    def follows(self, iteration: int, told_s: float) -> tuple[str, ...] | None:
        """Whom the robot follows: nobody if empty; None for everyone, or for a method that does not say.

        Raises:
            PluginError: the answer is neither None nor a sequence of names of the cast.
            HookError: the method's own code failed.
        """
        if not isinstance(self._method, Follower):
            return None
        persons = self._call("follows", told_s, (iteration,))
        if persons is None:
            return None
        if not isinstance(persons, tuple | list) or not all(isinstance(person, str) for person in persons):
            raise PluginError(f"{self._name}.follows returned {shortened(persons)}; a tuple of names or None is wanted")
        if strangers := [person for person in persons if person not in self._cast]:
            raise PluginError(
                f"{self._name}.follows returned {strangers}; names among {', '.join(self._cast)} are wanted"
            )
        return tuple(persons)

    def _call(self, hook: str, told_s: float, given: tuple[object, ...]) -> object:
        try:
            return getattr(self._method, hook)(*given)
        except SjasimError:
            raise
        except Exception as error:
            what = f"{type(error).__name__}: {error}"
            raise HookError(f"{self._name}.{hook} failed at session time {told_s:.3f} s: {what}") from error

    def _check(self, hook: str, told_s: float, item: object) -> None:
        """Refuse an answer of another type, with a field of another type, or a time to wake at that has passed."""
        if not isinstance(item, ScheduleCommand | CancelCommand | SetTimer):
            raise PluginError(f"{self._name}.{hook} returned {shortened(item)} among its answers; {WANTED}")
        for field, (kind, words) in FIELDS.items():
            if hasattr(item, field) and not isinstance(value := getattr(item, field), kind):
                answer = f"{type(item).__name__}.{field} = {value!r}"
                raise PluginError(f"{self._name}.{hook}: {answer} is not allowed: {words}")
        if isinstance(item, SetTimer) and not told_s < item.t_s < np.inf:
            raise PluginError(
                f"{self._name}.{hook}: SetTimer.t_s = {item.t_s:g} is not allowed at session time {told_s:g} s: "
                "a SetTimer must lie in the future"
            )
