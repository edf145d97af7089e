"""Ten lines from nothing to a learning agent, with any library that takes Gymnasium environments."""

import gymnasium as gym
import numpy as np
from sjasim_envs.wrappers import InOrder, MethodPolicy

env = MethodPolicy(InOrder(gym.make("sjasim:sjasim/Dance-v0", iterations=1, step_hz=6, dance={"rehearsal": False})))
rng, best, weights, high = np.random.default_rng(0), -np.inf, 0.0, env.observation_space.high
for episode in range(12):
    observation, info = env.reset(seed=2)
    trial, total, over = weights + 0.3 * rng.standard_normal((4, len(high))), 0.0, False
    while not over:
        observation, reward, over, truncated, info = env.step(int(np.argmax(trial @ (observation / high))))
        total += reward
    best, weights = (total, trial) if total > best else (best, weights)
    print(f"episode {episode}: return {total:.2f}, best {best:.2f}")
