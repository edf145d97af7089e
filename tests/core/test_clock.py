"""Ticks, tasks, device clocks and random streams."""

import subprocess
import sys

import numpy as np
import pytest

from sjasim.core.clock import DeviceClock, Task, Ticks, stream
from sjasim.core.errors import ConfigError


def test_time_is_tick_over_rate_and_never_accumulates():
    assert Ticks(240).time_s(240 * 3600) == 3600.0


@pytest.mark.parametrize("rate", [240, 1000, 333])
def test_at_or_after_inverts_time_s(rate):
    ticks = Ticks(rate)
    assert [ticks.at_or_after(ticks.time_s(k)) for k in range(2000)] == list(range(2000))
    assert ticks.at_or_after(0.5 / rate) == 1


def test_the_first_tick_is_never_before_the_time():
    ticks = Ticks(240)
    for k in range(2000):
        at = ticks.time_s(k)
        assert ticks.first_s(at) == at
        assert ticks.first_s(float(np.nextafter(at, 1e3))) == ticks.time_s(k + 1)


@pytest.mark.parametrize("hz", [1, 7, 30, 50, 240])
def test_a_task_runs_at_the_first_tick_that_is_not_before_its_time(hz):
    task = Task(Ticks(240), hz)
    for count in range(500):
        assert task.due == int(np.ceil(count * 240 / hz - 1e-9))
        task.advance()


def test_fifty_hertz_on_240_has_intervals_of_four_and_five_ticks():
    fired = [Ticks(240).firing(k, 50) for k in range(50)]
    assert set(np.diff(fired)) == {4, 5}


def test_a_task_faster_than_the_physics_is_refused():
    with pytest.raises(ConfigError):
        Task(Ticks(240), 241)


def test_a_device_clock_has_offset_drift_and_a_jump():
    clock = DeviceClock(0.5, 1e-3, 10.0, -2.0)
    assert clock.reading(0.0) == 0.5
    assert clock.reading(9.0) == pytest.approx(9.509)
    assert clock.reading(10.0) == pytest.approx(8.51)
    assert DeviceClock().reading(3.0) == 3.0


def test_streams_depend_on_seed_and_name_only():
    first = stream(1, "humans", "person", 0).random(3)
    stream(1, "a new sensor").random(100)
    assert np.array_equal(stream(1, "humans", "person", 0).random(3), first)
    assert not np.array_equal(stream(2, "humans", "person", 0).random(3), first)
    assert not np.array_equal(stream(1, "humans", "person", 1).random(3), first)


def test_streams_are_the_same_in_another_process():
    code = "from sjasim.core.clock import stream; print(repr(stream(7, 'link', 'north').random()))"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert float(other.stdout) == stream(7, "link", "north").random()
