"""Dancers who are missing from an iteration are reported when its window has closed."""

import math

from sjasim.core import Event, Kind
from sjasim.server.attendance import ARRIVAL_MARGIN_S, AttendanceMonitor


def clap(person, iteration, early=False, t_s=1e3):
    return Event(person, Kind.CLAP, t_s, t_s, early, iteration, "north")


def test_dancers_without_events_are_reported_iteration_by_iteration(world):
    table = world.timetable
    attendance = AttendanceMonitor(("dancer_1", "dancer_2"), table)
    assert attendance.next_due_s == table.close_s(0) + ARRIVAL_MARGIN_S

    attendance.add(clap("dancer_1", 0))
    attendance.add(clap("dancer_2", 0))
    attendance.add(clap("dancer_1", 1))
    attendance.add(clap("dancer_2", 1, early=True))

    assert attendance.check(table.close_s(0) + ARRIVAL_MARGIN_S) == []
    (notice,) = attendance.check(table.close_s(1) + 1.0)
    assert (notice.source, notice.what) == ("dancer_2", "no event seen in iteration 1")
    # Both dancers are missing from the three iterations that are left.
    assert len(attendance.check(table.end_s())) == 6
    assert attendance.next_due_s == math.inf


def test_a_dancer_who_stops_within_an_iteration_is_reported(world):
    table = world.timetable
    attendance = AttendanceMonitor(("dancer_1", "dancer_2", "dancer_3"), table)
    due_s = [table.time_s(0, step.beat) for step in table.choreography.steps()]

    for t_s in due_s:
        attendance.add(clap("dancer_1", 0, t_s=t_s + 0.3))
    for t_s in due_s[:4]:
        attendance.add(clap("dancer_2", 0, t_s=t_s))
    # The last stop and the clap may be occluded: two missing steps are not reported.
    for t_s in due_s[:7]:
        attendance.add(clap("dancer_3", 0, t_s=t_s))

    (notice,) = attendance.check(table.close_s(0) + ARRIVAL_MARGIN_S)
    assert (notice.source, notice.what) == ("dancer_2", "no event seen in iteration 0 after 4 of 9")
