"""The contract of every registered anticipation method: noisy, silent, shifted and repeated dances."""

import dataclasses
import math

import numpy as np
import pytest

from sjasim.anticipation.method import Method, build_method
from sjasim.choreography.paper import paper
from sjasim.choreography.timetable import Timetable
from sjasim.core import Event, Kind, registry
from sjasim.core.errors import ConfigError, PluginError, UnknownNameError
from sjasim.core.method_io import CancelCommand, MethodContext, ScheduleCommand, SetTimer
from sjasim.core.tempo import TempoMap

STEPS = paper().steps()
TIMETABLE = Timetable(paper(), TempoMap.steady(118), 4.0, 0, 4)
ALL_STEPS = {(iteration, step.ordinal) for iteration in range(1, 5) for step in STEPS}
METHODS = tuple(name for name in registry.names("anticipation") if name != "learned")
"""All but the one that needs a trained policy's file (tests/anticipation/test_learned.py)."""


def context(cast=("dancer_1", "dancer_2", "dancer_3"), shift=0.0):
    starts = tuple(TIMETABLE.start_s(i) + shift for i in range(5))
    return MethodContext(cast, STEPS, 4, 60 / 118, starts, tuple(TIMETABLE.close_s(i) + shift for i in range(5)))


def dance(method, plan, seed=0, missing=0.1, noise_s=0.3):
    """Play a whole dance with noisy times and missing events.

    Args:
        missing: probability that an event is not detected; regular and early events are drawn separately.
        noise_s: standard deviation of every step's time [s].

    Returns:
        (session time, action) in order.
    """
    rng = np.random.default_rng(seed)
    told = []
    for i in range(5):
        told.append((plan.iteration_start_s[i], 0, method.on_iteration_start, (i, plan.iteration_start_s[i])))
        told.append((plan.window_end_s[i], 1, method.on_iteration_end, (i, plan.window_end_s[i])))
        for person in ("dancer_1", "dancer_2", "dancer_3"):
            for step in STEPS:
                t_s = plan.iteration_start_s[i] + step.beat * plan.beat_s + rng.normal(0, noise_s)
                lost, early_lost = rng.random() < missing, rng.random() < missing
                early = (t_s - 0.1, True) if step.kind != Kind.CLAP and not early_lost else None
                for at in filter(None, (early, None if lost else (t_s, False))):
                    arrival = at[0] + 0.02
                    event = Event(person, step.kind, at[0], arrival, at[1], i, "north")
                    told.append((arrival, 2, method.on_event, (event,)))

    out = []
    timers_s = []
    for now, _, hook, arguments in sorted(told, key=lambda item: item[:2]):
        for timer_s in sorted(timer_s for timer_s in timers_s if timer_s <= now):
            timers_s.remove(timer_s)
            out += [(timer_s, answer) for answer in method.on_timer(timer_s)]
        answers = hook(*arguments)
        timers_s += [answer.t_s for answer in answers if isinstance(answer, SetTimer)]
        out += [(now, answer) for answer in answers]
    return out


def scheduled_steps(answers):
    """(iteration, ordinal) of every command that was scheduled."""
    return {(answer.iteration, answer.ordinal) for _, answer in answers if isinstance(answer, ScheduleCommand)}


def start(name, plan, seed=0):
    method = build_method(name)
    method.reset(plan, np.random.default_rng(seed))
    return method


@pytest.mark.parametrize("name", METHODS)
class TestEveryMethod:
    def test_keeps_the_protocol_and_has_documented_frozen_options(self, name):
        entry = registry.resolve("anticipation", name)
        assert isinstance(build_method(name), Method)
        assert entry.factory.__doc__
        if entry.config is not None:
            assert dataclasses.is_dataclass(entry.config)
            assert entry.config.__dataclass_params__.frozen
            assert all(f"{field.name}:" in entry.config.__doc__ for field in dataclasses.fields(entry.config))

    def test_acts_only_on_steps_that_exist(self, name):
        plan = context()
        for now, answer in dance(start(name, plan), plan):
            assert isinstance(answer, ScheduleCommand | CancelCommand | SetTimer)
            if isinstance(answer, ScheduleCommand):
                assert math.isfinite(answer.t_s)
                assert answer.person in ("", *plan.cast)
            if isinstance(answer, SetTimer):
                assert now < answer.t_s < math.inf
            else:
                assert 1 <= answer.iteration <= 4
                assert 0 <= answer.ordinal < len(STEPS)
                assert answer.why
                assert plan.window_end_s[answer.iteration - 1] <= now

    def test_schedules_every_step_of_a_dance_without_missing_events(self, name):
        plan = context()
        answers = dance(start(name, plan), plan, missing=0.0, noise_s=0.02)
        assert scheduled_steps(answers) == ALL_STEPS

    def test_the_same_dance_gives_the_same_actions_and_reset_forgets_everything(self, name):
        plan = context()
        method = start(name, plan)
        first = dance(method, plan)
        method.reset(plan, np.random.default_rng(0))
        assert dance(method, plan) == first
        assert dance(start(name, plan), plan) == first

    def test_a_shifted_clock_shifts_the_actions(self, name):
        plan, later = context(), context(shift=1000.0)
        for (_, a), (_, b) in zip(dance(start(name, plan), plan), dance(start(name, later), later), strict=True):
            assert type(a) is type(b)
            if not isinstance(a, CancelCommand):
                assert b.t_s - a.t_s == pytest.approx(1000.0, abs=1e-6)

    @pytest.mark.parametrize("cast", [("dancer_1",), ("dancer_1", "dancer_2"), tuple(f"dancer_{i}" for i in range(8))])
    def test_dances_with_groups_of_any_size(self, name, cast):
        plan = context(cast)
        assert dance(start(name, plan), plan)

    def test_schedules_every_step_without_any_event(self, name):
        plan = context()
        answers = dance(start(name, plan), plan, missing=1.1)
        assert scheduled_steps(answers) == ALL_STEPS


def test_options_are_checked():
    with pytest.raises(ConfigError, match="lead_s"):
        build_method("eca", {"lead": 0.1})
    with pytest.raises(ConfigError, match="window_s"):
        build_method("sia", {"window_s": -1.0})
    with pytest.raises(ConfigError, match="edges"):
        build_method("sia", {"edges": "some"})
    with pytest.raises(UnknownNameError, match="metronome"):
        build_method("tarantella")


def test_an_object_without_the_hooks_is_refused():
    with pytest.raises(PluginError, match="on_event"):
        build_method("collections:OrderedDict")
