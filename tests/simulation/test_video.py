"""Captions of a video: recent events and commands, in order of time."""

from __future__ import annotations

from types import SimpleNamespace

from sjasim.core import ROBOT, Event, Kind, Move
from sjasim.core.session_log import AgentEvent
from sjasim.simulation.video import CAPTION_S, MAX_CAPTIONS, ROBOT_COLOUR, TEXT_COLOUR, captions


def event(kind: Kind, t_arrival_s: float, *, early: bool = False) -> Event:
    return Event("dancer_2", kind, t_arrival_s - 0.1, t_arrival_s, early, 1, "north")


def session(events=(), commands=(), robot_events=()):
    return SimpleNamespace(events=events, commands=commands, world=SimpleNamespace(robot_events=robot_events))


def test_recent_events_commands_and_robot_events_are_shown_in_order_of_time():
    made = session(
        events=[event(Kind.CLAP, 9.5), event(Kind.START_FORWARD, 9.0, early=True)],
        commands=[SimpleNamespace(t_start_s=9.8, move=Move.TURN, why="everybody claps")],
        robot_events=[AgentEvent(1, ROBOT, Kind.TURN, 9.2)],
    )
    lines = captions(made, 10.0)
    assert [text for text, _ in lines] == [
        "  9.20  robot turns",
        "  9.50  dancer_2 claps",
        "  9.80  command turn: everybody claps",
    ]
    assert lines[0][1] == ROBOT_COLOUR
    assert lines[2][1] == TEXT_COLOUR


def test_old_events_disappear_and_only_the_last_ones_are_shown():
    times_s = [10.0 + 0.1 * k for k in range(9)]
    made = session(events=[event(Kind.CLAP, t_s) for t_s in times_s])
    lines = captions(made, times_s[-1])
    assert [float(text.split()[0]) for text, _ in lines] == [round(t_s, 2) for t_s in times_s[-MAX_CAPTIONS:]]
    assert captions(made, times_s[-1] + CAPTION_S + 0.01) == []
