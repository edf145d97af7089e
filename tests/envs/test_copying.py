"""Copied and pickled environments: equal to the original, and independent of it."""

from __future__ import annotations

import copy
import pickle

import cloudpickle
import gymnasium as gym
import numpy as np
import pytest
from sjasim_envs.wrappers import InOrder

SHORT = {"iterations": 1, "step_hz": 5, "dance": {"rehearsal": False}}
COPIES = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "cloudpickle": lambda env: pickle.loads(cloudpickle.dumps(env)),
}
FORWARD, STOP = 1, 0


def make(name: str = "sjasim:sjasim/Dance-v0", **options) -> gym.Env:
    return gym.make(name, **SHORT, **options)


def play(env: gym.Env, actions) -> list[tuple[dict, float]]:
    """Observation and reward of every step."""
    return [env.step(action)[:2] for action in actions]


def same(first, second) -> bool:
    """Whether two runs observed and earned the same."""
    assert len(first) == len(second) > 0
    return all(
        reward == other_reward and all(np.array_equal(seen[key], other[key], equal_nan=True) for key in seen)
        for (seen, reward), (other, other_reward) in zip(first, second, strict=True)
    )


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
def test_a_copy_made_before_reset_observes_like_a_new_environment(copied):
    original, twin = make(), copied(make())
    original.reset(seed=3)
    twin.reset(seed=3)
    actions = [FORWARD] * 25
    danced = play(original, actions)
    assert same(danced, play(twin, actions))
    assert danced[-1][0]["robot"][0] > 0.1  # the robot moved, and the observation shows it


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
def test_a_copy_made_in_mid_dance_goes_on_like_the_original_and_does_not_touch_it(copied):
    alone, original = make(), make()
    before, after = [FORWARD] * 12, [STOP, FORWARD, 2, STOP] * 4
    alone.reset(seed=3)
    original.reset(seed=3)
    play(alone, before)
    play(original, before)

    twin = copied(original)
    play(twin, [2] * 10)  # what the twin does must not reach the original
    assert same(play(original, after), play(alone, after))

    again = copied(original)
    assert same(play(again, after), play(original, after))


def test_a_copied_environment_draws_the_same_next_episodes():
    original = make()
    original.reset(seed=5)
    twin = copy.deepcopy(original)
    assert original.reset()[1]["seed"] == twin.reset()[1]["seed"]


def test_the_actions_of_the_continuous_environment_are_repeated_exactly():
    env = make("sjasim:sjasim/DanceContinuous-v0")
    env.reset(seed=2)
    rng = np.random.default_rng(0)
    action = np.zeros(2, np.float32)
    for _ in range(10):
        action[:] = rng.uniform(-0.3, 0.3, 2)  # one array that is overwritten, as agents do
        env.step(action)
    twin = copy.deepcopy(env)
    actions = [np.array([0.2, 0.0], np.float32)] * 8
    assert same(play(env, actions), play(twin, actions))


def test_wrappers_are_copied_with_their_environment():
    env = InOrder(make())
    env.reset(seed=1)
    play(env, [FORWARD] * 8)
    twin = copy.deepcopy(env)
    assert same(play(env, [FORWARD] * 8), play(twin, [FORWARD] * 8))


def test_a_closed_environment_stays_closed_when_it_is_copied():
    env = make()
    env.reset(seed=1)
    env.close()
    with pytest.raises(gym.error.ClosedEnvironmentError):
        copy.deepcopy(env.unwrapped).reset()
