"""A link is reported once for the packets that it loses."""

import numpy as np
import pytest

from sjasim.server.link_monitor import LinkMonitor


def monitor_link(loss, until_s=60.0, seed=0, alive=lambda t_s: True):
    """Notices about one client's link at 4 clock requests per second.

    Args:
        loss: probability that a request or its reply is lost; a number, or a function of session time.
    """
    rng = np.random.default_rng(seed)
    link = LinkMonitor("north")
    notices = []
    for k in range(int(4 * until_s)):
        t_s = k / 4
        notices += link.check_loss(t_s, alive=alive(t_s))
        link.request_sent(t_s)
        if rng.random() >= (loss(t_s) if callable(loss) else loss):
            link.reply_received(t_s)
    return notices


@pytest.mark.parametrize("seed", range(5))
def test_twenty_per_cent_each_way_is_reported_once_within_ten_seconds(seed):
    notices = monitor_link(1 - 0.8**2, seed=seed)
    assert [notice.source for notice in notices] == ["north"]
    assert notices[0].t_s < 10.0
    assert notices[0].what.startswith("link loses packets: ")


def test_a_good_link_is_never_reported():
    assert [monitor_link(1 - 0.999**2, 200.0, seed) for seed in range(20)] == [[]] * 20


def test_a_link_that_has_recovered_is_reported_again():
    notices = monitor_link(lambda t_s: 0.5 if t_s < 20 or t_s > 60 else 0.0, 100.0)
    assert len(notices) == 2
    assert notices[1].t_s > 60


def test_a_dead_client_is_no_lossy_link():
    assert monitor_link(lambda t_s: float(t_s > 20), 60.0, alive=lambda t_s: t_s < 21) == []
