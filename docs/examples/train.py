"""Ten lines from nothing to a learning agent, with any library that takes Gymnasium environments."""

import gymnasium as gym
import numpy as np

env = gym.make("sjasim:sjasim/DanceFlat-v0", iterations=1, step_hz=10, dance={"rehearsal": False})
rng, best, weights = np.random.default_rng(0), -np.inf, np.zeros((4, env.observation_space.shape[0]))
for episode in range(3):
    observation, info = env.reset(seed=episode)
    trial, total, over = weights + 0.1 * rng.standard_normal(weights.shape), 0.0, False
    while not over:
        observation, reward, over, truncated, info = env.step(int(np.argmax(trial @ observation)))
        total += reward
    best, weights = (total, trial) if total > best else (best, weights)
    print(f"episode {episode}: return {total:.2f}, best {best:.2f}")
