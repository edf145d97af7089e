"""The clock estimate over jittery, lossy, asymmetric links, and across a jump."""

import math

import numpy as np
import pytest

from sjasim.core import SyncReply
from sjasim.core.clock import DeviceClock
from sjasim.server.clock_sync import ClockSync


def exchanges(seed, clock, sync, *, extra_s=0.0, until_s=60.0, loss=0.05, jitter_s=0.005):
    """Clock exchanges at 4 Hz; yields the session time after each, and the jump that it reported."""
    rng = np.random.default_rng(seed)
    for k in range(int(until_s * 4)):
        t_s = k * 0.25
        up, back = (0.015 + rng.exponential(jitter_s) for _ in range(2))
        lost = rng.random() < loss
        if not lost:
            reading = clock.reading(t_s + up)
            arrival = t_s + up + back + extra_s
            yield arrival, sync.add(SyncReply("north", t_s, reading, reading), arrival)


def errors(seed, *, extra_s=0.0, until_s=60.0, from_s=4.0):
    rng = np.random.default_rng([seed, 1])
    clock = DeviceClock(rng.uniform(-0.5, 0.5), rng.uniform(-50e-6, 50e-6))
    sync = ClockSync()
    return [
        sync.session_time(clock.reading(t_s + ahead)) - (t_s + ahead)
        for t_s, _ in exchanges(seed, clock, sync, extra_s=extra_s, until_s=until_s)
        if t_s > from_s
        for ahead in (0.05, 0.2)
    ]


def test_error_stays_within_two_milliseconds():
    found = np.abs(np.concatenate([errors(seed) for seed in range(30)]))
    assert np.percentile(found, 95) <= 0.002
    first = np.abs(np.concatenate([errors(seed, until_s=10.0) for seed in range(30)]))
    assert np.percentile(first, 95) <= 0.002


def test_an_asymmetric_link_biases_by_half_the_asymmetry():
    found = np.concatenate([errors(seed, extra_s=0.03) for seed in range(15)])
    assert found.mean() == pytest.approx(0.015, abs=0.001)


def test_drift_is_found():
    clock, sync = DeviceClock(0.2, 50e-6), ClockSync()
    for _ in exchanges(3, clock, sync):
        pass
    assert sync.drift == pytest.approx(50e-6, abs=25e-6)


@pytest.mark.parametrize("jump_s", [3.0, 0.2, -0.06, 0.03, -40.0])
def test_a_jump_is_reported_once_and_locked_on(jump_s):
    clock, sync = DeviceClock(-0.3, 30e-6, 30.0, jump_s), ClockSync()
    seen = [(t_s, jump) for t_s, jump in exchanges(1, clock, sync) if jump]
    assert len(seen) == 1
    t_s, jump = seen[0]
    assert 30.0 <= t_s < 31.5
    assert jump == pytest.approx(jump_s, abs=0.02)
    assert sync.session_time(clock.reading(60.0)) == pytest.approx(60.0, abs=0.003)


def test_a_drift_is_not_made_up_of_a_few_exchanges():
    clock, sync = DeviceClock(0.2, 0.0), ClockSync()
    found = [sync.drift for _ in exchanges(7, clock, sync, until_s=12.0)]
    assert np.abs(found).max() < 2e-4


@pytest.mark.parametrize("jitter_s", [0.0, 0.02, 0.05])
def test_a_slow_link_does_not_make_clocks_jump(jitter_s):
    for seed in range(20):
        clock, sync = DeviceClock(0.1, 50e-6), ClockSync()
        assert not any(jump for _, jump in exchanges(seed, clock, sync, jitter_s=jitter_s))


def test_a_clock_has_settled_after_some_exchanges_and_begins_anew_after_a_jump():
    clock, sync = DeviceClock(0.1, 50e-6, 30.0, 1.0), ClockSync()
    story = [(t_s, sync.settled) for t_s, _ in exchanges(2, clock, sync, loss=0.0)]
    assert not any(settled for t_s, settled in story if t_s < 5.7 or 30.3 < t_s < 35.7)
    assert all(settled for t_s, settled in story if 6.3 < t_s < 29.9 or t_s > 37.0)


def test_jitter_and_a_long_silence_are_no_jump():
    clock = DeviceClock(0.1, 50e-6)
    sync = ClockSync()
    assert not any(jump for _, jump in exchanges(5, clock, sync, loss=0.3))
    reading = clock.reading(600.015)
    assert sync.add(SyncReply("north", 600.0, reading, reading), 600.03) == 0.0


def test_before_the_first_exchange_nothing_is_known():
    sync = ClockSync()
    assert not sync.locked
    assert math.isinf(sync.round_trip_s)
    assert sync.session_time(12.5) == 12.5


def test_a_perfect_link_locks_on_the_first_exchange():
    sync = ClockSync()
    assert sync.add(SyncReply("north", 1.0, 4.0, 4.0), 1.0) == 0.0
    assert sync.session_time(5.0) == pytest.approx(2.0)


def test_an_impossible_exchange_is_ignored():
    sync = ClockSync()
    assert sync.add(SyncReply("north", 1.0, 4.0, 9.0), 1.03) == 0.0
    assert not sync.locked
