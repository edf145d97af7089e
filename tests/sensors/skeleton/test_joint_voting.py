"""Mean shift over votes: where they agree, and when they are too few to be believed."""

from __future__ import annotations

import numpy as np

from sjasim.assets.names import JOINT_INDEX, JOINTS
from sjasim.sensors.skeleton.joint_voting import MAX_VOTES, MIN_VOTES, SURE, VOTE_COLUMNS, WEIGHT, _find_modes

HAND = JOINT_INDEX["HandLeft"]
PREDICTED = np.array([0.3, 1.2, 2.5])
ELSEWHERE = np.array([0.2, 0.9, 2.8])


def mode(
    near: int, elsewhere: int, weight: float = 1.0, prior: np.ndarray = PREDICTED
) -> tuple[np.ndarray, float, float]:  # fmt: skip
    """Return position, support and number of agreeing votes of a hand.

    Args:
        near: number of votes for `PREDICTED`, of weight 1.
        elsewhere: number of votes for `ELSEWHERE`.
        weight: of each of these.
        prior: predicted position [m].
    """
    votes = np.zeros((len(JOINTS), MAX_VOTES, VOTE_COLUMNS), np.float32)
    vote_count = np.zeros(len(JOINTS), np.int64)
    start = np.zeros((len(JOINTS), 4))
    before = np.full((1, len(JOINTS), 3), np.nan)
    before[0, HAND] = prior

    positions = [PREDICTED] * near + [ELSEWHERE] * elsewhere
    for n, position in enumerate(positions):
        vote_weight = 1.0 if n < near else weight
        votes[HAND, n, :3] = position
        votes[HAND, n, WEIGHT] = vote_weight
        votes[HAND, n, SURE] = vote_weight
        start[HAND] += [*(vote_weight * position), vote_weight]
    vote_count[HAND] = len(positions)

    joints = np.empty((1, len(JOINTS), 3))
    support = np.zeros((1, len(JOINTS)))
    agree = np.zeros((1, len(JOINTS)))
    _find_modes(votes, vote_count, start, np.ones((1, 6), np.float32), before, joints, support, agree)
    return joints[0, HAND], float(support[0, HAND]), float(agree[0, HAND])


def test_votes_that_agree_make_a_joint():
    position, support, agree = mode(near=9, elsewhere=0)
    assert np.abs(position - PREDICTED).max() < 0.001
    assert support > 8.0
    assert agree == 9


def test_one_heavy_stray_vote_does_not_move_a_hand():
    position, _, agree = mode(near=2, elsewhere=1, weight=50.0)
    assert np.abs(position - PREDICTED).max() < 0.02
    assert agree == 2


def test_a_hand_moves_to_a_place_with_much_more_weight():
    position, _, agree = mode(near=MIN_VOTES, elsewhere=40)
    assert np.abs(position - ELSEWHERE).max() < 0.02
    assert agree == 40


def test_a_hand_without_a_prediction_is_where_the_votes_are():
    position, _, _ = mode(near=0, elsewhere=5, prior=np.full(3, np.nan))
    assert np.abs(position - ELSEWHERE).max() < 0.001


def test_a_joint_without_votes_stays_at_its_prediction_without_support():
    position, support, agree = mode(near=0, elsewhere=0)
    assert (position == PREDICTED).all()
    assert support == agree == 0.0
