"""A method and the dispatcher together, on scripted events: the commands of a whole dance."""

import numpy as np
import pytest

from sjasim.anticipation.method import build_method
from sjasim.choreography.layout import layout
from sjasim.choreography.paper import paper
from sjasim.choreography.timetable import Timetable
from sjasim.config import SessionConfig
from sjasim.core import Event, Kind, Move
from sjasim.core.method_io import MethodContext
from sjasim.core.tempo import TempoMap
from sjasim.server import Dispatcher

CONFIG = SessionConfig()
TIMETABLE = Timetable(paper(), TempoMap.steady(118), 4.0, 0, 4)
STEPS = TIMETABLE.choreography.steps()
BEAT_S = 60 / 118
CAST = ("dancer_1", "dancer_2", "dancer_3")
CONTEXT = MethodContext(CAST, STEPS, 4, BEAT_S, tuple(TIMETABLE.start_s(i) for i in range(5)),
              tuple(TIMETABLE.close_s(i) for i in range(5)))  # fmt: skip
LEAD_S = 0.1


def performance(seed, lost=0.05, common_s=0.4, own_s=0.1):
    """True times (iteration, dancer, step) of a group that shifts together, and the events told of them."""
    rng = np.random.default_rng(seed)
    nominal = np.array([step.beat * BEAT_S for step in STEPS])
    shift = np.clip(rng.normal(0, common_s, (5, 1, 1)), -0.8, 0.8)
    times = nominal + shift + np.clip(rng.normal(0, own_s, (5, 3, 9)), -0.25, 0.25)
    events = []
    for i, d, k in np.ndindex(times.shape):
        t_s = TIMETABLE.start_s(i) + times[i, d, k]
        if rng.random() >= lost:
            events.append(Event(CAST[d], STEPS[k].kind, t_s, t_s + 0.02, False, i, "north"))
        if STEPS[k].kind != Kind.CLAP and rng.random() >= lost:
            events.append(Event(CAST[d], STEPS[k].kind, t_s - LEAD_S, t_s - LEAD_S + 0.02, True, i, "north"))
    return times, events


def run_method(name, events):
    """Run a method with the dispatcher; returns the dispatcher and every command in the order of sending."""
    method = build_method(name)
    method.reset(CONTEXT, np.random.default_rng(0))
    dispatcher = Dispatcher(CONTEXT, TIMETABLE, layout(CONFIG), CONFIG.robot, 10)
    agenda = [(event.t_arrival_s, method.on_event, (event,)) for event in events]
    for i in range(5):
        agenda.append((TIMETABLE.start_s(i), method.on_iteration_start, (i, TIMETABLE.start_s(i))))
        agenda.append((TIMETABLE.close_s(i), method.on_iteration_end, (i, TIMETABLE.close_s(i))))
    commands = []
    for t_s, hook, arguments in [*sorted(agenda, key=lambda item: item[0]), (TIMETABLE.end_s(), lambda: (), ())]:
        while dispatcher.next_due_s <= t_s:
            now = dispatcher.next_due_s
            commands += dispatcher.due_commands(now)
            for timer_s in dispatcher.due_timers(now):
                dispatcher.handle(timer_s, method.on_timer(timer_s))
        dispatcher.handle(t_s, hook(*arguments))
        commands += dispatcher.due_commands(t_s)
    return dispatcher, list({command.number: command for command in commands}.values())


@pytest.mark.parametrize("name", ["sia", "eca", "metronome"])
def test_a_dance_without_missing_events_is_commanded_completely_and_in_order(name):
    _, events = performance(0, lost=0.0)
    _, commands = run_method(name, events)
    assert [(c.iteration, c.ordinal) for c in commands] == [(i, k) for i in range(1, 5) for k in range(9)]
    assert [c.number for c in commands] == list(range(1, 37))
    cycle = [Move.FORWARD, Move.STOP, Move.BACKWARD, Move.STOP] * 2 + [Move.TURN]
    assert [c.move for c in commands] == cycle * 4


def test_sia_follows_a_group_that_shifts_together_and_eca_lags_one_iteration_behind():
    late = {"sia": [], "eca": []}
    for seed in range(6):
        times, events = performance(seed)
        for name, found in late.items():
            _, commands = run_method(name, events)
            found += [
                abs(c.t_start_s - TIMETABLE.start_s(c.iteration) - times[c.iteration, :, c.ordinal].mean())
                for c in commands
                if c.iteration > 1
            ]
    assert np.median(late["sia"]) < 0.15
    assert np.median(late["sia"]) < 0.5 * np.median(late["eca"])


def test_missing_events_cost_sia_single_steps_and_never_an_iteration():
    fallbacks = skipped = steps = 0
    for seed in range(10):
        dispatcher, commands = run_method("sia", performance(seed)[1])
        steps += 27
        assert all(sum(c.iteration == i for c in commands) >= 7 for i in range(1, 5))
        sent = [d for d in dispatcher.decisions if d.action == "sent" and d.iteration > 1]
        fallbacks += sum(d.why.startswith("fallback") for d in sent)
        skipped += sum(d.action == "withdrawn" for d in dispatcher.decisions)
    assert (fallbacks + skipped) / steps < 0.03
