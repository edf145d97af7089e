"""A link is reported for what it loses, once."""

import numpy as np
import pytest

from sjasim.server.link_monitor import LinkMonitor


def listen(loss, until_s=60.0, seed=0, alive=lambda t_s: True):
    """Notices about one client's link at 4 exchanges per second."""
    rng = np.random.default_rng(seed)
    exchanges = LinkMonitor("north")
    notices = []
    for k in range(int(4 * until_s)):
        t_s = k / 4
        notices += exchanges.judge(t_s, alive=alive(t_s))
        exchanges.asked(t_s)
        if rng.random() >= (loss(t_s) if callable(loss) else loss):
            exchanges.answered(t_s)
    return notices


@pytest.mark.parametrize("seed", range(5))
def test_twenty_per_cent_each_way_is_reported_once_within_ten_seconds(seed):
    notices = listen(1 - 0.8**2, seed=seed)
    assert [notice.source for notice in notices] == ["north"]
    assert notices[0].t_s < 10.0
    assert notices[0].what.startswith("link loses packets: ")


def test_a_well_link_is_never_reported():
    assert all(listen(1 - 0.999**2, 200.0, seed) == [] for seed in range(20))


def test_a_link_that_was_well_in_between_is_reported_again():
    notices = listen(lambda t_s: 0.5 if t_s < 20 or t_s > 60 else 0.0, 100.0)
    assert len(notices) == 2
    assert notices[1].t_s > 60


def test_the_silence_of_a_dead_client_is_not_its_links():
    assert listen(lambda t_s: float(t_s > 20), 60.0, alive=lambda t_s: t_s < 21) == []
