"""Where votes agree, and when they are too few to be believed."""

from __future__ import annotations

import numpy as np

from sjasim.assets.names import JOINT_INDEX, JOINTS
from sjasim.sensors.skeleton.joint_voting import MAX_VOTES, MIN_VOTES, SURE, WEIGHT, _find_modes

HAND, HIP = JOINT_INDEX["HandLeft"], JOINT_INDEX["HipLeft"]
THERE, ELSEWHERE = np.array([0.3, 1.2, 2.5]), np.array([0.2, 0.9, 2.8])


def agreed(
    joint: int, near: int, elsewhere: int, weight: float = 1.0, prior: np.ndarray = THERE
) -> tuple[np.ndarray, float, float]:  # fmt: skip
    """Place, support and number of votes of a joint with so many votes at its prediction and elsewhere."""
    cast, many = np.zeros((len(JOINTS), MAX_VOTES, 5), np.float32), np.zeros(len(JOINTS), np.int64)
    first, before = np.zeros((len(JOINTS), 4)), np.full((1, len(JOINTS), 3), np.nan)
    before[0, joint] = prior
    places = [THERE] * near + [ELSEWHERE] * elsewhere
    for n, place in enumerate(places):
        heavy = 1.0 if n < near else weight
        cast[joint, n, :3], cast[joint, n, WEIGHT], cast[joint, n, SURE] = place, heavy, heavy
        first[joint] += [*(heavy * place), heavy]
    many[joint] = len(places)
    joints, support, agree = np.empty((1, len(JOINTS), 3)), np.zeros((1, len(JOINTS))), np.zeros((1, len(JOINTS)))
    _find_modes(cast, many, first, np.ones((1, 6), np.float32), before, joints, support, agree)
    return joints[0, joint], float(support[0, joint]), float(agree[0, joint])


def test_votes_that_agree_make_a_joint():
    place, support, agree = agreed(HAND, 9, 0)
    assert np.abs(place - THERE).max() < 0.001
    assert support > 8.0
    assert agree == 9


def test_one_heavy_stray_vote_does_not_draw_a_hand_away():
    place, _, agree = agreed(HAND, 2, 1, weight=50.0)
    assert np.abs(place - THERE).max() < 0.02
    assert agree == 2


def test_a_hand_goes_where_much_more_speaks_for_it():
    place, _, agree = agreed(HAND, MIN_VOTES, 40)
    assert np.abs(place - ELSEWHERE).max() < 0.02
    assert agree == 40


def test_a_hand_that_nothing_was_known_of_is_where_votes_are():
    place, _, _ = agreed(HAND, 0, 5, prior=np.full(3, np.nan))
    assert np.abs(place - ELSEWHERE).max() < 0.001
