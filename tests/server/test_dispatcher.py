"""Commands are sent once, at their time, in the order of the score, are repeated, and lead the robot to its slot."""

import math
from itertools import pairwise

import pytest

from sjasim.core import Move, RobotState
from sjasim.core.method_io import CancelCommand, MethodContext, ScheduleCommand, SetTimer
from sjasim.server import Dispatcher
from sjasim.server.move_planner import MAX_STEER_RAD

BEAT_S = 60 / 118


@pytest.fixture
def dispatcher(world):
    table = world.timetable
    span = range(5)
    context = MethodContext(
        ("dancer_1", "dancer_2", "dancer_3"), table.choreography.steps(), 4, BEAT_S,
        tuple(table.start_s(i) for i in span), tuple(table.close_s(i) for i in span),
    )  # fmt: skip
    return Dispatcher(context, table, world.layout, world.config.robot, 10)


def actions(dispatcher):
    return [decision.action for decision in dispatcher.decisions]


def run(dispatcher, from_s, until_s, step_s=0.001):
    """(session time, command) of everything sent; the dispatcher is asked only when something is due."""
    sent = []
    for k in range(int((until_s - from_s) / step_s) + 1):
        t_s = from_s + k * step_s
        if dispatcher.next_due_s <= t_s:
            sent += [(t_s, command) for command in dispatcher.due_commands(t_s)]
    return sent


def test_a_scheduled_command_is_sent_once_at_its_time_and_then_repeated(dispatcher):
    assert dispatcher.next_due_s == math.inf
    dispatcher.handle(0.0, [ScheduleCommand(1, 0, 5.0, "mean")])
    assert dispatcher.due_commands(4.99) == []
    sent = run(dispatcher, 4.9, 6.0)
    assert sent[0][0] == pytest.approx(5.0, abs=0.002)
    assert {command.number for _, command in sent} == {1}
    gaps = [b - a for (a, _), (b, _) in pairwise(sent)]
    assert max(gaps) <= 0.102
    assert min(gaps) >= 0.099
    assert actions(dispatcher) == ["scheduled", "sent"]


def test_stop_is_repeated_to_a_standing_robot(dispatcher):
    dispatcher.handle(0.0, [ScheduleCommand(1, 0, 1.0, ""), ScheduleCommand(1, 1, 2.0, "")])
    late = [command for t_s, command in run(dispatcher, 0.0, 8.0) if t_s > 2.01]
    assert len(late) > 55
    assert {(command.number, command.move) for command in late} == {(2, Move.STOP)}


def test_a_later_answer_replaces_and_a_sent_step_is_over(dispatcher):
    dispatcher.handle(0.0, [ScheduleCommand(1, 0, 9.0, "fallback")])
    dispatcher.handle(3.0, [ScheduleCommand(1, 0, 3.0, "early", "dancer_2")])
    (command,) = dispatcher.due_commands(3.0)
    assert (command.why, command.t_start_s) == ("early", 3.0)
    dispatcher.handle(3.1, [ScheduleCommand(1, 0, 3.1, "regular", "dancer_2")])
    assert actions(dispatcher) == ["scheduled", "replaced", "sent", "ignored"]
    assert dispatcher.decisions[-1].why == "already sent: regular"
    assert not any(command.number > 1 for _, command in run(dispatcher, 3.2, 10.0))


def test_the_robot_never_goes_back_in_the_score(dispatcher):
    dispatcher.handle(0.0, [ScheduleCommand(1, 2, 4.0, "late"), ScheduleCommand(1, 3, 3.0, "stop")])
    moves = [command.move for _, command in run(dispatcher, 0.0, 5.0)]
    assert set(moves) == {Move.STOP}
    dispatcher.handle(5.0, [ScheduleCommand(1, 0, 6.0, "too late")])
    assert [d.why for d in dispatcher.decisions if d.action == "ignored"] == [
        "a later step has been sent: late",
        "a later step has been sent: too late",
    ]


def test_commands_due_together_go_out_in_the_order_of_the_score(dispatcher):
    dispatcher.handle(7.0, [ScheduleCommand(1, 1, 1.0, ""), ScheduleCommand(1, 0, 2.0, "")])
    assert [(c.number, c.move) for c in dispatcher.due_commands(7.0)] == [(1, Move.FORWARD), (2, Move.STOP)]


def test_a_cancelled_command_is_not_sent(dispatcher):
    dispatcher.handle(0.0, [ScheduleCommand(1, 0, 5.0, "")])
    dispatcher.handle(1.0, [CancelCommand(1, 0, "passed over"), CancelCommand(1, 0, "again")])
    assert run(dispatcher, 0.0, 6.0) == []
    assert actions(dispatcher) == ["scheduled", "withdrawn", "ignored"]


def test_commands_for_steps_that_do_not_exist_are_ignored_and_logged(dispatcher):
    wrong = [ScheduleCommand(0, 0, 1.0, "rehearsal"), ScheduleCommand(1, 99, 1.0, ""), ScheduleCommand(5, 0, 1.0, ""),
             ScheduleCommand(1, 0, math.nan, "")]  # fmt: skip
    dispatcher.handle(0.0, [*wrong, CancelCommand(1, 77, "")])
    assert actions(dispatcher) == ["ignored"] * 5
    assert dispatcher.next_due_s == math.inf


def test_a_methods_mistake_is_reported_once_for_each_reason(dispatcher):
    for _ in range(100):
        dispatcher.handle(2.0, [ScheduleCommand(1, 99, 5.0, "far"), ScheduleCommand(1, 0, math.inf, "never")])
    no_step, no_time = dispatcher.notices
    assert (no_step.t_s, no_step.source) == (2.0, "method")
    assert "iteration 1, ordinal 99 ignored: no such step (iterations 1 to 4, ordinals 0 to 8)" in no_step.what
    assert "command at inf s for iteration 1, ordinal 0 ignored: no finite time" in no_time.what
    assert actions(dispatcher) == ["ignored"] * 200


def test_an_action_for_a_step_that_is_over_is_no_mistake(dispatcher):
    dispatcher.handle(0.0, [ScheduleCommand(1, 1, 0.0, "")])
    dispatcher.due_commands(0.0)
    dispatcher.handle(1.0, [ScheduleCommand(1, 1, 2.0, ""), ScheduleCommand(1, 0, 2.0, ""), CancelCommand(1, 1, "")])
    assert dispatcher.notices == []


def test_timers_come_in_order_and_once(dispatcher):
    dispatcher.handle(1.0, [SetTimer(5.0), SetTimer(3.0), SetTimer(0.5)])
    assert 1.0 < dispatcher.next_due_s < 1.0 + 1e-9  # a timer in the past comes at the next instant
    assert dispatcher.due_timers(3.0) == [math.nextafter(1.0, 2.0), 3.0]
    assert dispatcher.due_timers(3.0) == []
    assert dispatcher.next_due_s == 5.0


@pytest.mark.parametrize(
    ("ordinal", "move"),
    list(enumerate([Move.FORWARD, Move.STOP, Move.BACKWARD, Move.STOP] * 2 + [Move.TURN])),
)
def test_each_step_has_its_move(dispatcher, ordinal, move):
    dispatcher.handle(0.0, [ScheduleCommand(1, ordinal, 0.0, "")])
    (command,) = dispatcher.due_commands(0.0)
    assert command.move is move
    assert (command.speed_m_s > 0) == (move in (Move.FORWARD, Move.BACKWARD))


def test_a_turn_ends_at_the_next_iterations_ideal_heading(dispatcher, world):
    for iteration in range(1, 5):
        dispatcher.update_robot_state(1.0, RobotState(1.0, 0.0, 0.0, 1.3, 0.0, 0.0))  # misaligned: no matter
        dispatcher.handle(1.0, [ScheduleCommand(iteration, 8, 1.0, "")])
        (command,) = dispatcher.due_commands(1.0)
        assert command.heading_rad == pytest.approx(world.timetable.heading_rad(iteration + 1))


def state(world, iteration, ahead_m, step_m=0.0):
    heading = world.timetable.heading_rad(iteration)
    x, y = world.layout.robot
    place = (x + ahead_m * math.cos(heading), y + ahead_m * math.sin(heading))
    return RobotState(0.0, *place, heading, step_m, 0.0)


@pytest.mark.parametrize(
    ("ordinal", "ahead_m", "speed"),
    [
        (0, 0.0, 0.25),
        (0, 0.10, 0.25 - 0.10 / (4 * BEAT_S)),
        (0, -0.10, 0.25 + 0.10 / (4 * BEAT_S)),
        (2, 0.50, 0.50 / (4 * BEAT_S)),
        (2, 0.0, 0.15),  # on the slot already: the slowest
        (2, 2.0, 0.40),  # far ahead: the fastest
    ],
)
def test_speed_brings_the_robot_back_to_its_slot(dispatcher, world, ordinal, ahead_m, speed):
    for iteration in (1, 2, 3):
        dispatcher.update_robot_state(0.0, state(world, iteration, ahead_m))
        dispatcher.handle(0.0, [ScheduleCommand(iteration, ordinal, 0.0, "")])
        (command,) = dispatcher.due_commands(0.0)
        assert command.speed_m_s == pytest.approx(speed)


def beside(world, iteration, left_m):
    """Odometry of a robot that stands to the left of its slot, seen along the iteration's heading."""
    heading = world.timetable.heading_rad(iteration)
    x, y = world.layout.robot
    return RobotState(0.0, x - left_m * math.sin(heading), y + left_m * math.cos(heading), heading, 0.0, 0.0)


@pytest.mark.parametrize("iteration", [1, 2, 3])
@pytest.mark.parametrize("left_m", [0.1, -0.1])
@pytest.mark.parametrize(("ordinal", "move"), [(0, Move.FORWARD), (2, Move.BACKWARD)])
def test_a_move_leads_a_robot_beside_its_lane_back_to_it(dispatcher, world, iteration, left_m, ordinal, move):
    """To the left of its lane the robot must be told to steer right when it moves forward, and left when backward."""
    dispatcher.update_robot_state(0.0, beside(world, iteration, left_m))
    dispatcher.handle(0.0, [ScheduleCommand(iteration, ordinal, 0.0, "")])
    (command,) = dispatcher.due_commands(0.0)
    assert command.move is move

    steer_rad = command.heading_rad - world.timetable.heading_rad(iteration)
    if move is Move.FORWARD:
        assert steer_rad * left_m < 0.0
    else:
        assert steer_rad * left_m > 0.0

    # The direction of travel, against the heading when moving backward, must point towards the lane.
    travel = 1.0 if move is Move.FORWARD else -1.0
    assert travel * math.sin(steer_rad) * left_m < 0.0


def test_a_robot_far_beside_its_lane_steers_by_the_limit_and_on_it_not_at_all(dispatcher, world):
    heading = world.timetable.heading_rad(1)
    found = []
    for number, left_m in enumerate((5.0, 0.0, -5.0)):
        dispatcher.update_robot_state(0.0, beside(world, 1, left_m))
        dispatcher.command_move(float(number), Move.FORWARD)
        found.append(dispatcher.current.heading_rad - heading)
    assert found == pytest.approx([-MAX_STEER_RAD, 0.0, MAX_STEER_RAD])


def test_a_robot_that_still_rolls_is_planned_from_where_it_will_stop(dispatcher, world):
    dispatcher.update_robot_state(0.0, state(world, 1, 0.40, step_m=0.006))  # .3 m/s at 50 Hz: 4.5 cm more
    dispatcher.handle(0.0, [ScheduleCommand(1, 2, 0.0, "")])
    assert dispatcher.due_commands(0.0)[0].speed_m_s == pytest.approx(0.445 / (4 * BEAT_S))


def test_the_expected_duration_is_the_median_of_the_score_and_of_earlier_iterations(dispatcher, world):
    dispatcher.handle(0.0, [ScheduleCommand(1, 2, 10.0, ""), ScheduleCommand(1, 3, 11.5, "")])
    run(dispatcher, 9.9, 11.6)
    dispatcher.update_robot_state(0.0, state(world, 2, 0.45))
    dispatcher.handle(20.0, [ScheduleCommand(2, 2, 20.0, "")])
    assert dispatcher.due_commands(20.0)[0].speed_m_s == pytest.approx(0.45 / ((1.5 + 4 * 60 / 118) / 2), rel=0.01)


@pytest.mark.parametrize(("last_resort", "duration_s"), [(False, 1.3), (True, 4 * BEAT_S)])
def test_a_stop_that_is_scheduled_sets_the_speed_unless_it_is_a_last_resort(dispatcher, world, last_resort, duration_s):
    dispatcher.update_robot_state(0.0, state(world, 1, 0.45))
    dispatcher.handle(0.0, [ScheduleCommand(1, 2, 5.0, ""), ScheduleCommand(1, 3, 6.3, "", last_resort=last_resort)])
    assert dispatcher.due_commands(5.0)[0].speed_m_s == pytest.approx(0.45 / duration_s)


def test_a_move_that_nobody_stops_crawls_beyond_its_end_and_halts(dispatcher, world):
    dispatcher.handle(0.0, [ScheduleCommand(1, 0, 5.0, "")])
    (command,) = dispatcher.due_commands(5.0)
    dispatcher.update_robot_state(0.0, state(world, 1, 0.5))
    (copy,) = dispatcher.due_commands(dispatcher.next_due_s)
    assert (copy.number, copy.speed_m_s) == (command.number, command.speed_m_s)
    dispatcher.update_robot_state(0.0, state(world, 1, 0.6))
    (copy,) = dispatcher.due_commands(dispatcher.next_due_s)
    assert (copy.number, copy.move, copy.speed_m_s) == (command.number, Move.FORWARD, 0.13)
    dispatcher.update_robot_state(0.0, state(world, 1, 0.95))
    assert dispatcher.due_commands(dispatcher.next_due_s)[0].speed_m_s == 0.0


def test_after_an_early_stop_the_robot_drives_slowly_to_where_its_move_should_have_ended(dispatcher, world):
    dispatcher.handle(0.0, [ScheduleCommand(1, 6, 5.0, ""), ScheduleCommand(1, 7, 6.0, "")])
    sent = run(dispatcher, 4.9, 6.05)
    assert (sent[-1][1].move, sent[-1][1].speed_m_s) == (Move.STOP, 0.0)
    speeds = []
    for ahead_m in (0.3, 0.05, -0.3):
        dispatcher.update_robot_state(0.0, state(world, 1, ahead_m))
        speeds.append(dispatcher.due_commands(dispatcher.next_due_s)[0].speed_m_s)
    assert speeds == [-0.08, 0.0, 0.08]
