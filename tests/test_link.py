"""Links: delays, loss, order."""

import math

import numpy as np
import pytest

from sjasim.clock import stream
from sjasim.link import Link, LinkQuality


def link(latency_s=0.02, jitter_s=0.005, loss=0.0, ordered=False, seed=0):
    return Link(LinkQuality(latency_s, jitter_s, loss, ordered), stream(seed, "link"))


def through(wire, count=2000, every_s=0.01):
    """(sending time, arrival time) of everything that arrives."""
    for k in range(count):
        wire.send(k * every_s, k)
    return [(message * every_s, t_s) for t_s, message in wire.receive(math.inf)]


def test_delays_are_latency_plus_exponential_jitter():
    delays = np.array([arrival - sent for sent, arrival in through(link())])
    assert delays.min() >= 0.02
    assert delays.mean() == pytest.approx(0.025, rel=0.03)
    assert delays.std() == pytest.approx(0.005, rel=0.1)


def test_messages_come_out_once_when_due_in_order_of_arrival():
    wire = link(jitter_s=0.05)
    for k in range(100):
        wire.send(0.01 * k, k)
    first = wire.next_arrival_s
    assert wire.receive(first - 1e-9) == []
    early, late = wire.receive(0.5), wire.receive(math.inf)
    times = [t_s for t_s, _ in early + late]
    assert times == sorted(times)
    assert early[0][0] == first
    assert sorted(k for _, k in early + late) == list(range(100))
    assert wire.next_arrival_s == math.inf


def test_messages_may_overtake_unless_the_link_is_ordered():
    loose = [sent for sent, _ in through(link(jitter_s=0.05))]
    strict = [sent for sent, _ in through(link(jitter_s=0.05, ordered=True))]
    assert loose != sorted(loose)
    assert strict == sorted(strict)


def test_loss_takes_its_share_and_moves_nothing_else():
    whole, thinned = dict(through(link())), dict(through(link(loss=0.2)))
    assert len(thinned) / len(whole) == pytest.approx(0.8, abs=0.03)
    assert all(whole[sent] == arrival for sent, arrival in thinned.items())


def test_losses_are_counted():
    wire = link(loss=0.5)
    arrived = through(wire, 400)
    assert wire.sent == 400
    assert wire.lost == 400 - len(arrived)
