"""A policy file as a method gives the same dance as in the environment that it is trained in."""

import gymnasium as gym
import numpy as np
import pytest
from sjasim_envs.wrappers import InOrder, MethodPolicy

import sjasim
from sjasim.anticipation.policy_network import PolicyNetwork

from ..anticipation.policies import write


@pytest.mark.slow
def test_a_policy_dances_a_whole_session_as_it_does_in_the_environment(tmp_path):
    file = write(tmp_path / "policy.npz")
    options = {"seed": 6001, "sensing": "joints", "iterations": 4, "performance": "one"}
    log = sjasim.run_session(sjasim.SessionConfig(method="learned", method_options={"policy": file}, **options))
    figures = sjasim.measures(log)
    assert [row.robot_missed for row in figures.iterations] == [0, 0, 0, 0]
    assert figures.ta_mean_s < 1.0
    assert all("the policy wants" in decision.why for decision in log.decisions if decision.ordinal >= 0)

    env = InOrder(gym.make("sjasim/Dance-v0", step_hz=10, disable_env_checker=True, **options))
    told, network, over = MethodPolicy(env), PolicyNetwork.read(file), False
    observation, _ = told.reset()
    while not over:
        observation, _, over, _, _ = told.step(int(np.argmax(network.scores(observation.astype(float)))))
    own = env.unwrapped.session.world.robot_events
    assert [event.kind for event in own] == [event.kind for event in log.robot_events]
    assert [event.t_s for event in own] == pytest.approx([event.t_s for event in log.robot_events], abs=0.25)
