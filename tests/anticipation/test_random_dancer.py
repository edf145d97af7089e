"""The random dancer: SIA with a leader that is drawn for each iteration."""

from __future__ import annotations

from collections import Counter

import numpy as np

from sjasim.anticipation.method import build_method
from sjasim.anticipation.random_dancer import RandomDancer
from sjasim.config import SessionConfig
from sjasim.session.session import Session


def _followed(seed: int) -> list[str]:
    session = Session(SessionConfig(method="random-dancer", fidelity="timing", sensing="joints", seed=seed))
    session.advance(session.end_s)
    return [item.person for item in session.followed if item.person]


def test_every_dancer_is_followed_about_as_often_as_the_others():
    counts = Counter(name for seed in range(40) for name in _followed(seed))
    assert set(counts) == {"dancer_1", "dancer_2", "dancer_3"}
    # Of 120 draws, each dancer gets 40 with a standard deviation of 5.2.
    assert all(abs(count - 40) < 16 for count in counts.values())


def test_the_draw_depends_on_the_seed_alone():
    assert _followed(3) == _followed(3)
    assert len({tuple(_followed(seed)) for seed in range(12)}) > 6


def test_the_leader_is_drawn_from_the_whole_cast(story):
    method = build_method("random-dancer")
    assert isinstance(method, RandomDancer)
    method.reset(story.context(), np.random.default_rng(1))
    leaders = []
    for iteration in range(4):
        method.on_iteration_end(iteration, story.context().window_end_s[iteration])
        leaders.append(method.follows(iteration + 1))
    assert leaders[0] == ()
    assert all(leader and leader[0] in story.context().cast for leader in leaders[1:])
