"""Who was not seen is named when the window has closed."""

import math

from sjasim.core import Event, Kind
from sjasim.server.attendance import WAIT_S, AttendanceMonitor


def event(person, iteration, early=False, t_s=1e3):
    return Event(person, Kind.CLAP, t_s, t_s, early, iteration, "north")


def test_the_missing_are_named_window_by_window(world):
    table = world.timetable
    roll_call = AttendanceMonitor(("dancer_1", "dancer_2"), table)
    assert roll_call.next_due_s == table.close_s(0) + WAIT_S
    roll_call.saw(event("dancer_1", 0))
    roll_call.saw(event("dancer_2", 0))
    roll_call.saw(event("dancer_1", 1))
    roll_call.saw(event("dancer_2", 1, early=True))
    assert roll_call.judge(table.close_s(0) + WAIT_S) == []
    (notice,) = roll_call.judge(table.close_s(1) + 1.0)
    assert (notice.source, notice.what) == ("dancer_2", "no event seen in iteration 1")
    assert len(roll_call.judge(table.end_s())) == 6
    assert roll_call.next_due_s == math.inf


def test_who_stops_within_a_window_is_named(world):
    table = world.timetable
    roll_call = AttendanceMonitor(("dancer_1", "dancer_2", "dancer_3"), table)
    due = [table.time_s(0, step.beat) for step in table.choreography.steps()]
    for t_s in due:
        roll_call.saw(event("dancer_1", 0, t_s=t_s + 0.3))
    for t_s in due[:4]:
        roll_call.saw(event("dancer_2", 0, t_s=t_s))
    for t_s in due[:7]:  # the last stop and the clap may be hidden
        roll_call.saw(event("dancer_3", 0, t_s=t_s))
    (notice,) = roll_call.judge(table.close_s(0) + WAIT_S)
    assert (notice.source, notice.what) == ("dancer_2", "no event seen in iteration 0 after 4 of 9")
