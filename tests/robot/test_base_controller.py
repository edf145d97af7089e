"""Tests of the base controller on an ideal base, which does what it is commanded."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from sjasim.config import RobotConfig
from sjasim.core import Move, RobotState
from sjasim.core.errors import ConfigError
from sjasim.robot.base_controller import BaseController
from sjasim.robot.diff_drive import body_rates

CONFIG = RobotConfig(command_latency_s=0.1)
DT = 0.02


class Base:
    """An ideal base: in the next interval it moves exactly as commanded, or not at all if ``stuck``."""

    def __init__(self, config: RobotConfig = CONFIG):
        self.controller = BaseController(config)
        self.config = config
        self.k = 0
        self.heading = self.speed = self.yaw_rate = 0.0
        self.stuck = False

    @property
    def t_s(self):
        return self.k * DT

    def run(self, seconds, every=None):
        """Commanded speeds and yaw rates, a pair for each control step; ``every`` is called before each."""
        out = []
        for _ in range(round(seconds / DT)):
            if every is not None:
                every()
            speed, yaw_rate = (0.0, 0.0) if self.stuck else (self.speed, self.yaw_rate)
            self.heading += yaw_rate * DT
            state = RobotState(self.t_s, 0.0, 0.0, self.heading, speed * DT, yaw_rate)
            self.speed, self.yaw_rate = body_rates(self.controller.update(state), self.config)
            self.k += 1
            out.append((self.speed, self.yaw_rate))
        return out


@pytest.fixture
def base():
    return Base()


def test_the_base_stands_until_the_first_command(base):
    assert set(base.run(0.5)) == {(0.0, 0.0)}
    assert not base.controller.timed_out
    assert base.controller.number == 0


def test_a_command_takes_effect_after_its_latency_with_a_ramp(base, order):
    base.controller.receive(0.0, order(1, Move.FORWARD))
    speeds = [speed for speed, _ in base.run(0.5)]
    assert speeds[:5] == [0.0] * 5
    assert speeds[5:9] == pytest.approx([0.02, 0.04, 0.06, 0.08])
    assert speeds[-1] == pytest.approx(0.25)


def test_a_stop_with_a_speed_moves_slower_than_any_move_while_it_is_repeated(base, order):
    stop = order(1, Move.STOP, speed=-0.5)
    base.controller.receive(0.0, stop)
    speeds = [speed for speed, _ in base.run(2.0, every=lambda: base.controller.receive(base.t_s, stop))]
    assert min(speeds) == pytest.approx(-0.09)
    assert base.run(1.0)[-1] == (0.0, 0.0)
    assert base.controller.timed_out


def test_backward_is_negative_and_speed_is_limited(base, order):
    base.controller.receive(0.0, order(1, Move.BACKWARD, speed=7.0))
    base.run(0.5)
    base.controller.receive(0.5, order(1, Move.BACKWARD, speed=7.0))
    assert base.run(0.5)[-1][0] == pytest.approx(-CONFIG.max_speed_m_s)


def test_a_copy_is_executed_once(base, order):
    command = order(1, Move.TURN, heading=0.5)
    base.run(1.5, every=lambda: base.controller.receive(base.t_s, command))
    base.heading = 0.2
    assert set(base.run(0.5, every=lambda: base.controller.receive(base.t_s, command))) == {(0.0, 0.0)}


def test_a_copy_may_slow_down_the_move_under_way(base, order):
    base.controller.receive(0.0, order(1, Move.FORWARD))
    base.run(0.5)
    base.controller.receive(base.t_s, replace(order(1, Move.FORWARD), speed_m_s=0.13))
    assert base.run(0.2)[-1][0] == pytest.approx(0.13)


def test_an_older_number_is_ignored(base, order):
    base.controller.receive(0.0, order(2, Move.FORWARD))
    base.controller.receive(0.01, order(1, Move.BACKWARD))
    assert base.run(0.5)[-1][0] == pytest.approx(0.25)
    base.controller.receive(base.t_s, order(1, Move.STOP))
    base.run(0.2)
    assert base.controller.timed_out
    assert base.controller.number == 2


def test_each_command_has_its_own_latency(base, order):
    base.controller.receive(0.0, order(1, Move.FORWARD))
    base.controller.receive(0.06, order(2, Move.STOP))
    speeds = [speed for speed, _ in base.run(0.3)]
    assert max(speeds) == pytest.approx(0.06)
    assert speeds[-1] == 0.0


def test_without_commands_the_base_stops_and_a_copy_lets_it_continue(base, order):
    base.controller.receive(0.0, order(1, Move.FORWARD))
    speeds = [speed for speed, _ in base.run(1.0)]
    last = max(k for k, speed in enumerate(speeds) if speed == pytest.approx(0.25))
    assert last * DT == pytest.approx(CONFIG.cmd_timeout_s, abs=0.021)
    assert speeds[last + 3] == pytest.approx(0.19)
    assert speeds[-1] == 0.0
    assert base.controller.timed_out
    assert not base.controller.blocked
    base.controller.receive(base.t_s, order(1, Move.FORWARD))
    assert base.run(0.3)[-1][0] == pytest.approx(0.25)
    assert not base.controller.timed_out


def test_a_stop_and_a_finished_turn_never_time_out(base, order):
    base.controller.receive(0.0, order(1, Move.STOP))
    base.run(2.0)
    assert not base.controller.timed_out
    command = order(2, Move.TURN, heading=0.4)
    base.controller.receive(base.t_s, command)
    base.run(1.0, every=lambda: base.controller.receive(base.t_s, command))
    base.run(2.0)
    assert not base.controller.timed_out


@pytest.mark.parametrize("angle", [math.pi / 2, -math.pi / 2, 0.2, math.pi])
def test_a_turn_ends_at_its_heading_without_overshoot(base, order, angle):
    command = order(1, Move.TURN, heading=angle)
    rates = base.run(3.0, every=lambda: base.controller.receive(base.t_s, command))
    assert base.heading == pytest.approx(angle, abs=math.radians(0.3))
    assert min(math.copysign(rate, angle * rate) for _, rate in rates) > -0.05
    assert max(abs(rate) for _, rate in rates) <= CONFIG.turn_rate_rad_s + 1e-9
    steps = [abs(b[1] - a[1]) for a, b in pairwise(rates)]
    assert max(steps) <= CONFIG.yaw_acceleration_rad_s2 * DT + 1e-9
    assert rates[-1] == (0.0, 0.0)


def test_a_straight_move_steers_back_to_its_heading(base, order):
    command = order(1, Move.FORWARD)
    base.run(0.2, every=lambda: base.controller.receive(base.t_s, command))
    base.heading += 0.1
    rates = base.run(2.5, every=lambda: base.controller.receive(base.t_s, command))
    assert max(abs(rate) for _, rate in rates) < 0.4  # never a turn to the detector
    assert base.heading == pytest.approx(0.0, abs=0.01)


def test_a_straight_move_far_from_its_commanded_heading_keeps_the_present_one(base, order):
    base.controller.receive(0.0, order(1, Move.TURN, heading=1.5))
    base.run(0.3)
    base.controller.receive(base.t_s, order(2, Move.FORWARD))
    base.run(0.1)
    begun = base.heading
    command = order(2, Move.FORWARD)
    base.run(2.0, every=lambda: base.controller.receive(base.t_s, command))
    assert abs(base.heading - begun) < 0.3


@pytest.mark.parametrize(("move", "heading"), [(Move.FORWARD, 0.0), (Move.BACKWARD, 0.0), (Move.TURN, 1.5)])
def test_blocked_after_half_a_second_without_motion(base, order, move, heading):
    base.stuck = True
    command = order(1, move, heading=heading)

    def beat():
        base.controller.receive(base.t_s, command)

    base.run(0.5, every=beat)
    assert not base.controller.blocked
    base.run(0.5, every=beat)
    assert base.controller.blocked
    assert not base.controller.timed_out
    base.stuck = False
    base.run(0.1, every=beat)
    assert not base.controller.blocked


def test_a_free_base_is_never_blocked(base, order):
    blocked = []
    for number, move in enumerate((Move.FORWARD, Move.STOP, Move.BACKWARD, Move.STOP, Move.TURN), start=1):
        command = order(number, move, heading=1.5)

        def beat(command=command):
            base.controller.receive(base.t_s, command)
            blocked.append(base.controller.blocked)

        base.run(2.0, every=beat)
    assert len(blocked) == 500
    assert not any(blocked)


def test_a_clap_is_refused(base, order):
    with pytest.raises(ConfigError, match="clap"):
        base.controller.receive(0.0, order(1, Move.CLAP))
