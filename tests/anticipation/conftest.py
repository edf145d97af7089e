"""Scripted dances for the tests of methods: the context of a dance, and events at given offsets from the music."""

from types import SimpleNamespace

import numpy as np
import pytest

from sjasim.anticipation.method import build_method
from sjasim.choreography.paper import paper
from sjasim.choreography.timetable import Timetable
from sjasim.core import Event, Kind
from sjasim.core.method_io import MethodContext, ScheduleCommand, SetTimer
from sjasim.core.tempo import TempoMap

CAST = ("dancer_1", "dancer_2", "dancer_3")
TIMETABLE = Timetable(paper(), TempoMap.steady(118), 4.0, 0, 4)
BEAT_S = 60 / 118
STEPS = paper().steps()
NOMINAL = np.array([step.beat * BEAT_S for step in STEPS])
DELAY_S = 0.02


def context(cast=CAST, tau_s=0.25):
    span = range(5)
    return MethodContext(
        cast,
        STEPS,
        4,
        BEAT_S,
        tuple(TIMETABLE.start_s(i) for i in span),
        tuple(TIMETABLE.close_s(i) for i in span),
        tau_s=tau_s,
    )


def start_s(iteration):
    return TIMETABLE.start_s(iteration)


def event(person, iteration, kind, after_s, early=False):
    t_s = start_s(iteration) + after_s
    return Event(person, Kind(kind), t_s, t_s + DELAY_S, early, iteration, "north")


def dance(iteration, offsets, skip=()):
    """Regular events of one iteration: each dancer at the nominal time plus their offset (seconds or an array)."""
    events = [
        event(person, iteration, step.kind, NOMINAL[step.ordinal] + np.broadcast_to(offset, len(STEPS))[step.ordinal])
        for person, offset in offsets.items()
        for step in STEPS
        if (person, step.ordinal) not in skip
    ]
    return sorted(events, key=lambda item: item.t_arrival_s)


class Story:
    """Calls the hooks of a method and keeps its latest command for every step, as the dispatcher does.

    Attributes:
        plan: (iteration, ordinal) -> the scheduled command.
        answers: every command and cancellation so far.
        timers_s: session times of the timers that are set [s].
    """

    def __init__(self, name, cast=CAST, tau_s=0.25, **options):
        self.method = build_method(name, options)
        self.method.reset(context(cast, tau_s), np.random.default_rng(0))
        self.plan = {}
        self.answers = []
        self.timers_s = []

    def record(self, answers):
        """Record the actions of a hook; returns them without timers."""
        self.timers_s += [answer.t_s for answer in answers if isinstance(answer, SetTimer)]
        kept = [answer for answer in answers if not isinstance(answer, SetTimer)]
        for answer in kept:
            self.answers.append(answer)
            key = (answer.iteration, answer.ordinal)
            if isinstance(answer, ScheduleCommand):
                self.plan[key] = answer
            else:
                self.plan.pop(key)
        return kept

    def wait(self, until_s):
        """Call the timers up to a session time; returns their actions."""
        due = sorted(t_s for t_s in self.timers_s if t_s <= until_s)
        self.timers_s = [t_s for t_s in self.timers_s if t_s > until_s]
        return [answer for t_s in due for answer in self.record(self.method.on_timer(t_s))]

    def begin(self, iteration):
        """Begin an iteration."""
        return self.record(self.method.on_iteration_start(iteration, start_s(iteration)))

    def end(self, iteration):
        """End the window of an iteration."""
        return self.record(self.method.on_iteration_end(iteration, TIMETABLE.close_s(iteration)))

    def tell(self, item):
        """Pass an event to the method; returns its actions."""
        return self.record(self.method.on_event(item))

    def play(self, iteration, offsets, skip=()):
        """Play a whole iteration, see `dance`."""
        self.begin(iteration)
        for item in dance(iteration, offsets, skip):
            self.tell(item)
        self.end(iteration)
        return self

    def after(self, iteration):
        """Sending times of the scheduled commands after beat 0, in the order of the steps [s]."""
        return np.array([self.plan[iteration, step.ordinal].t_s - start_s(iteration) for step in STEPS])


@pytest.fixture
def story():
    """`Story`, and the events, context and times of its dance."""
    return SimpleNamespace(Story=Story, event=event, dance=dance, start_s=start_s, context=context,
                           nominal=NOMINAL, delay_s=DELAY_S, timetable=TIMETABLE)  # fmt: skip
