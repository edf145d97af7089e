"""Who was not seen is named when the window has closed."""

import math

from sjasim.server.roll_call import WAIT_S, RollCall
from sjasim.types import Event, Kind


def event(person, iteration, early=False):
    return Event(person, Kind.CLAP, 0.0, 0.0, early, iteration, "north")


def test_the_missing_are_named_window_by_window(world):
    table = world.timetable
    roll_call = RollCall(("dancer_1", "dancer_2"), table)
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
