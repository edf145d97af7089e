"""Mistakes in a user's own method are reported by name."""

import math
import sys
import types
from dataclasses import dataclass

import numpy as np
import pytest

from sjasim.anticipation.checked_method import CheckedMethod
from sjasim.anticipation.method import build_method
from sjasim.core.errors import ConfigError, HookError, PluginError
from sjasim.core.method_io import CancelCommand, MethodContext, ScheduleCommand, SetTimer


class Mine:
    """Returns whatever the test sets as its answer."""

    def __init__(self):
        self.answer = ()

    def reset(self, context, rng):
        pass

    def on_event(self, event):
        return self.answer

    def on_iteration_start(self, iteration, t_s):
        return ()

    def on_iteration_end(self, iteration, t_s):
        return ()

    def on_timer(self, t_s):
        return self.answer / 0

    def follows(self, iteration):
        return self.answer


@pytest.fixture
def mine():
    return Mine()


def call_on_event(mine, answer, event_time_s=2.0):
    mine.answer = answer
    return CheckedMethod("my:Mine", mine).call("on_event", event_time_s, (None,))


@pytest.mark.parametrize(
    "answer",
    [
        (),
        [],
        (ScheduleCommand(1, 0, 3.0, "why"),),
        [CancelCommand(1, 0, "why"), SetTimer(2.1)],
        (ScheduleCommand(np.int64(1), 0, np.float32(3.0), "why"),),
        (ScheduleCommand(1, 99, math.nan, "the dispatcher ignores it"),),
    ],
)
def test_answers_pass_unchanged(mine, answer):
    assert call_on_event(mine, answer) == answer


@pytest.mark.parametrize("answer", [None, ScheduleCommand(1, 0, 3.0, "why"), "early", 7, {1: 2}, iter([])])
def test_what_is_no_sequence_of_actions_is_refused(mine, answer):
    with pytest.raises(
        PluginError, match=r"my:Mine.on_event returned .*; a sequence of ScheduleCommand, CancelCommand and SetTimer"
    ):
        call_on_event(mine, answer)


def test_what_is_no_action_in_a_sequence_is_refused(mine):
    with pytest.raises(PluginError, match=r"my:Mine.on_event returned 'early' among its answers"):
        call_on_event(mine, [SetTimer(3.0), "early"])
    with pytest.raises(PluginError, match=r"ScheduleCommand.t_s = None is not allowed: a session time"):
        call_on_event(mine, [ScheduleCommand(1, 0, None, "why")])
    with pytest.raises(PluginError, match=r"CancelCommand.iteration = '1' is not allowed: a whole number"):
        call_on_event(mine, [CancelCommand("1", 0, "why")])


@pytest.mark.parametrize("t_s", [2.0, 1.0, math.nan, math.inf, -math.inf])
def test_a_timer_must_lie_in_the_future(mine, t_s):
    with pytest.raises(PluginError, match=r"SetTimer.t_s = \S+ is not allowed at session time 2 s: .* in the future"):
        call_on_event(mine, [SetTimer(t_s)])


def test_an_exception_of_the_users_code_is_named_and_kept_as_the_cause(mine):
    mine.answer = 1
    with pytest.raises(
        HookError, match=r"my:Mine.on_timer failed at session time 6.520 s: ZeroDivisionError"
    ) as caught:
        CheckedMethod("my:Mine", mine).call("on_timer", 6.52, (6.52,))
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


def test_follows_returns_names_of_the_cast(mine):
    checked = CheckedMethod("my:Mine", mine)
    checked.reset(
        MethodContext(("dancer_1", "dancer_2"), (), 1, 0.5, (0.0, 9.0), (9.0, 18.0)), np.random.default_rng(0)
    )
    for answer, expected in (((), ()), (None, None), (["dancer_1"], ("dancer_1",))):
        mine.answer = answer
        assert checked.follows(1, 2.0) == expected
    mine.answer = "dancer_1"
    with pytest.raises(PluginError, match=r"my:Mine.follows returned 'dancer_1'; a tuple of names"):
        checked.follows(1, 2.0)
    mine.answer = ("dancer_1", "dancer_9")
    with pytest.raises(PluginError, match=r"returned \['dancer_9'\]; names among dancer_1, dancer_2 are wanted"):
        checked.follows(1, 2.0)


@dataclass(frozen=True)
class Options:
    gain: float

    def __post_init__(self):
        if self.gain < 0:
            raise ValueError("too little")


class WithOptions(Mine):
    config_type = Options

    def __init__(self, config):
        self.inverse = 1 / config.gain


class NoDataclass(Mine):
    config_type = dict


class NoConfigType(Mine):
    def __init__(self, gain):
        pass


class WrongSignature(Mine):
    def on_event(self):
        return ()


@pytest.fixture
def module(monkeypatch):
    found = types.ModuleType("my")
    for item in (WithOptions, NoDataclass, NoConfigType, WrongSignature):
        setattr(found, item.__name__, item)
    monkeypatch.setitem(sys.modules, "my", found)


@pytest.mark.parametrize(
    ("name", "options", "error", "says"),
    [
        ("NoConfigType", {}, PluginError, r"my:NoConfigType is called with \(\), but takes \(gain\).*config_type"),
        ("WrongSignature", {}, PluginError, r"my:WrongSignature.on_event is called with \(event\), but takes \(\)"),
        ("NoDataclass", {}, PluginError, "config_type.*is not a dataclass"),
        ("WithOptions", {}, ConfigError, "needs gain"),
        ("WithOptions", {"gain": 0}, HookError, "my:WithOptions cannot be made: ZeroDivisionError"),
        ("WithOptions", {"gain": -1}, HookError, "my:WithOptions cannot be made: ValueError: too little"),
    ],
)
def test_a_method_that_cannot_be_built_or_called_is_named(module, name, options, error, says):
    with pytest.raises(error, match=says):
        build_method(f"my:{name}", options)
    assert build_method("my:WithOptions", {"gain": 2.0}).inverse == 0.5
