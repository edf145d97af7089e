"""Network links: delays, losses and order of messages."""

import math

import numpy as np
import pytest

from sjasim.core.clock import stream
from sjasim.core.link import Link, LinkQuality, MessageQueue


def link(latency_s=0.02, jitter_s=0.005, loss=0.0, ordered=False, seed=0):
    """A link and its queue."""
    queue = MessageQueue()
    return Link(LinkQuality(latency_s, jitter_s, loss, ordered), stream(seed, "link"), queue), queue


def transmit(link_and_queue, count=2000, every_s=0.01):
    """(sending time, arrival time) of every message that arrives."""
    line, queue = link_and_queue
    for k in range(count):
        line.send(k * every_s, k)
    return [(message * every_s, t_s) for t_s, message in queue.receive(math.inf)]


def test_delays_are_latency_plus_exponential_jitter():
    delays = np.array([arrival - sent for sent, arrival in transmit(link())])
    assert delays.min() >= 0.02
    assert delays.mean() == pytest.approx(0.025, rel=0.03)
    assert delays.std() == pytest.approx(0.005, rel=0.1)


def test_messages_come_out_once_when_due_in_order_of_arrival():
    line, queue = link(jitter_s=0.05)
    for k in range(100):
        line.send(0.01 * k, k)
    first = queue.next_arrival_s
    assert queue.receive(first - 1e-9) == []
    early, late = queue.receive(0.5), queue.receive(math.inf)
    times = [t_s for t_s, _ in early + late]
    assert times == sorted(times)
    assert early[0][0] == first
    assert sorted(k for _, k in early + late) == list(range(100))
    assert queue.next_arrival_s == math.inf


def test_links_that_share_queue_deliver_in_one_order():
    near, queue = link(latency_s=0.01, jitter_s=0.0)
    far = Link(LinkQuality(0.05, 0.0, 0.0), stream(1, "link"), queue)
    far.send(0.0, "far")
    near.send(0.02, "near")
    assert [message for _, message in queue.receive(1.0)] == ["near", "far"]


def test_messages_may_overtake_unless_the_link_is_ordered():
    loose = [sent for sent, _ in transmit(link(jitter_s=0.05))]
    strict = [sent for sent, _ in transmit(link(jitter_s=0.05, ordered=True))]
    assert loose != sorted(loose)
    assert strict == sorted(strict)


def test_loss_takes_its_share_and_moves_nothing_else():
    whole, thinned = dict(transmit(link())), dict(transmit(link(loss=0.2)))
    assert len(thinned) / len(whole) == pytest.approx(0.8, abs=0.03)
    assert all(whole[sent] == arrival for sent, arrival in thinned.items())


def test_losses_are_counted():
    line, queue = link(loss=0.5)
    arrived = transmit((line, queue), 400)
    assert line.sent == 400
    assert line.lost == 400 - len(arrived)
