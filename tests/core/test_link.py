"""Links: delays, loss, order."""

import math

import numpy as np
import pytest

from sjasim.core.clock import stream
from sjasim.core.link import Link, LinkQuality, Mail


def link(latency_s=0.02, jitter_s=0.005, loss=0.0, ordered=False, seed=0):
    """A link and its mail."""
    mail = Mail()
    return Link(LinkQuality(latency_s, jitter_s, loss, ordered), stream(seed, "link"), mail), mail


def through(link_and_mail, count=2000, every_s=0.01):
    """(sending time, arrival time) of everything that arrives."""
    wire, mail = link_and_mail
    for k in range(count):
        wire.send(k * every_s, k)
    return [(message * every_s, t_s) for t_s, message in mail.receive(math.inf)]


def test_delays_are_latency_plus_exponential_jitter():
    delays = np.array([arrival - sent for sent, arrival in through(link())])
    assert delays.min() >= 0.02
    assert delays.mean() == pytest.approx(0.025, rel=0.03)
    assert delays.std() == pytest.approx(0.005, rel=0.1)


def test_messages_come_out_once_when_due_in_order_of_arrival():
    wire, mail = link(jitter_s=0.05)
    for k in range(100):
        wire.send(0.01 * k, k)
    first = mail.next_arrival_s
    assert mail.receive(first - 1e-9) == []
    early, late = mail.receive(0.5), mail.receive(math.inf)
    times = [t_s for t_s, _ in early + late]
    assert times == sorted(times)
    assert early[0][0] == first
    assert sorted(k for _, k in early + late) == list(range(100))
    assert mail.next_arrival_s == math.inf


def test_links_that_share_mail_deliver_in_one_order():
    near, mail = link(latency_s=0.01, jitter_s=0.0)
    far = Link(LinkQuality(0.05, 0.0, 0.0), stream(1, "link"), mail)
    far.send(0.0, "far")
    near.send(0.02, "near")
    assert [message for _, message in mail.receive(1.0)] == ["near", "far"]


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
    wire, mail = link(loss=0.5)
    arrived = through((wire, mail), 400)
    assert wire.sent == 400
    assert wire.lost == 400 - len(arrived)
