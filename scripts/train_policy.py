#!/usr/bin/env python3
"""Train a policy for sjasim/Dance-v0 with PPO, and save it so that it dances as an anticipation method.

python scripts/train_policy.py --minutes 10 --out runs/policy
python -m sjasim.run --method learned --method-options policy runs/policy/policy.npz
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import gymnasium as gym
import numpy as np
import tyro

try:
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecNormalize
except ImportError as missing:
    sys.exit(f"error: {missing}; training needs the extra 'rl': pip install -e '.[rl]'")


@dataclass(frozen=True)
class Options:
    """Training.

    Attributes:
        minutes: of wall time; a rollout that has begun is finished.
        out: folder of the policy and of its checkpoints.
        envs: environments, each in a process of its own.
        step_hz: decisions per second.
        iterations: of each dance.
        seed: of everything; seeds of groups are drawn from it.
        rollout: steps of each environment between two updates.
        checkpoint: updates between two checkpoints.
        resume: folder to go on from.
    """

    minutes: float = 10.0
    out: Path = Path("runs/policy")
    envs: int = 2
    step_hz: int = 6
    iterations: int = 2
    seed: int = 0
    rollout: int = 1024
    checkpoint: int = 10
    resume: Path | None = None


class Keeper(BaseCallback):
    """Shows progress on stderr, writes checkpoints, and ends the training when its time is over."""

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._options = options
        self._began_s = time.monotonic()
        self._updates = 0

    def _on_step(self) -> bool:
        return time.monotonic() - self._began_s < self._options.minutes * 60.0

    def _on_rollout_end(self) -> None:
        self._updates += 1
        returns = [episode["r"] for episode in self.model.ep_info_buffer]
        mean = f"{np.mean(returns):.2f}" if returns else "-"
        spent = (time.monotonic() - self._began_s) / 60.0
        sys.stderr.write(f"{spent:6.1f} min  {self.num_timesteps:8d} steps  return of the last episodes {mean}\n")
        if self._updates % self._options.checkpoint == 0:
            save(self.model, self._options, f"checkpoint-{self.num_timesteps}")


def save(model: PPO, options: Options, name: str = "policy") -> None:
    """Write the training's state, and the policy as plain arrays."""
    options.out.mkdir(parents=True, exist_ok=True)
    model.save(options.out / f"{name}.zip")
    normal = model.get_vec_normalize_env()
    normal.save(str(options.out / f"{name}-normal.pkl"))
    network = model.policy
    layers = [part for part in network.mlp_extractor.policy_net if isinstance(part, torch.nn.Linear)]
    arrays = {
        "mean": normal.obs_rms.mean,
        "std": np.sqrt(normal.obs_rms.var + normal.epsilon),
        "clip": np.array(normal.clip_obs),
        "step_hz": np.array(options.step_hz),
    }
    for index, layer in enumerate([*layers, network.action_net]):
        arrays[f"w{index}"] = layer.weight.detach().cpu().numpy()
        arrays[f"b{index}"] = layer.bias.detach().cpu().numpy()
    np.savez(options.out / f"{name}.npz", **arrays)


def main(options: Options) -> None:
    """Train until the time is over."""
    torch.set_num_threads(1)

    def make() -> gym.Env:
        env = gym.make(
            "sjasim:sjasim/Dance-v0", iterations=options.iterations, step_hz=options.step_hz, skip_rehearsal=True,
            disable_env_checker=True,
        )  # fmt: skip
        from sjasim_envs.wrappers import Told

        return Monitor(Told(env))

    raw = SubprocVecEnv([make] * options.envs) if options.envs > 1 else DummyVecEnv([make])
    if options.resume is None:
        model = PPO(
            "MlpPolicy", VecNormalize(raw, gamma=0.98), n_steps=options.rollout, batch_size=256, n_epochs=6,
            gamma=0.98, gae_lambda=0.95, ent_coef=0.01, learning_rate=5e-4, seed=options.seed, device="cpu",
            policy_kwargs={"net_arch": [64, 64]},
        )  # fmt: skip
        with torch.no_grad():  # begin by holding still, so that what a move is good for shows
            model.policy.action_net.bias.copy_(torch.tensor([2.0, 0.0, 0.0, 0.0]))
    else:
        normal = VecNormalize.load(str(options.resume / "policy-normal.pkl"), raw)
        model = PPO.load(options.resume / "policy.zip", env=normal, device="cpu")
    try:
        model.learn(10**9, callback=Keeper(options), reset_num_timesteps=options.resume is None)
    except KeyboardInterrupt:
        sys.stderr.write("stopped; keeping what has been learnt\n")
    save(model, options)
    sys.stderr.write(f"kept in {options.out / 'policy.npz'}\n")
    raw.close()


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
