#!/usr/bin/env python3
"""Train a policy with PPO on the physics; the file it leaves dances as the method ``learned``.

python scripts/train_policy.py --minutes 10 --out runs/policy
python -m sjasim.run --method learned --policy runs/policy/policy.npz

The agent is told what an anticipation method is told, and each of its moves means the score's step nearest to it
(`sjasim_envs.wrappers.MethodPolicy`, `InOrder`), so that it dances afterwards as it was trained. It begins with a network that
mostly holds the move in force: an agent that sends every step as soon as it may would never find out what waiting is
good for.
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

MOVE_IN_FORCE = range(9, 13)
"""Where the features tell it, one of four."""


@dataclass(frozen=True)
class Options:
    """Training.

    Attributes:
        minutes: of wall time; a rollout that has begun is finished.
        out: folder of the policy and of its checkpoints.
        envs: environments, each in a process of its own.
        step_hz: decisions per second.
        iterations: of each dance; without a rehearsal, in which there is nothing to learn.
        seed: of everything; seeds of groups are drawn from it.
        rollout: steps of each environment between two updates.
        learning_rate: at the beginning; it falls to nothing with the time that is left.
        hold: how much more than others the network wants the move in force before it has learnt anything.
        checkpoint: updates between two checkpoints.
        resume: folder to go on from.
        overwrite: replace an earlier policy and its checkpoints in the folder.
    """

    minutes: float = 10.0
    out: Path = Path("runs/policy")
    envs: int = 2
    step_hz: int = 6
    iterations: int = 4
    seed: int = 0
    rollout: int = 512
    learning_rate: float = 1e-3
    hold: float = 2.0
    checkpoint: int = 10
    resume: Path | None = None
    overwrite: bool = False

    def __post_init__(self) -> None:
        for name in ("minutes", "envs", "iterations", "step_hz", "rollout", "learning_rate", "checkpoint"):
            if not getattr(self, name) > 0:
                sys.stderr.write(f"error: {name} = {getattr(self, name)} is not allowed: a number above 0\n")
                raise SystemExit(2)


class Keeper(BaseCallback):
    """Shows progress on stderr, writes checkpoints, lowers the learning rate, and ends when the time is over."""

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._options = options
        self._began_s = time.monotonic()
        self._updates = 0

    @property
    def spent(self) -> float:
        """Share of the time that has passed, at most 1."""
        return min((time.monotonic() - self._began_s) / (60.0 * self._options.minutes), 1.0)

    def _on_step(self) -> bool:
        return self.spent < 1.0

    def _on_rollout_end(self) -> None:
        self._updates += 1
        self.model.lr_schedule = lambda _: self._options.learning_rate * max(1.0 - self.spent, 0.02)
        returns = [episode["r"] for episode in list(self.model.ep_info_buffer)[-20:]]
        mean = f"{np.mean(returns):.2f}" if returns else "-"
        minutes = self.spent * self._options.minutes
        sys.stderr.write(f"{minutes:6.1f} min  {self.num_timesteps:8d} steps  return of the last episodes {mean}\n")
        if self._updates % self._options.checkpoint == 0:
            save(self.model, self._options, f"checkpoint-{self.num_timesteps}")


class Scaled(gym.ObservationWrapper):
    """Features whose bounds are -2 and 2; the policy's file tells how.

    Args:
        env: an environment wrapped in `MethodPolicy`.
    """

    def __init__(self, env: gym.Env) -> None:
        super().__init__(env)
        low, high = env.observation_space.low, env.observation_space.high
        self.mean, self.std = (low + high) / 2, (high - low) / 4
        self.observation_space = gym.spaces.Box(-2.0, 2.0, low.shape, np.float32)

    def observation(self, observation: np.ndarray) -> np.ndarray:
        """The same, scaled."""
        return ((observation - self.mean) / self.std).astype(np.float32)


def make(options: Options) -> Scaled:
    """An environment as the method ``learned`` will meet it."""
    env = gym.make(
        "sjasim:sjasim/Dance-v0", iterations=options.iterations, step_hz=options.step_hz, dance={"rehearsal": False},
        disable_env_checker=True,
    )  # fmt: skip
    from sjasim_envs.wrappers import InOrder, MethodPolicy

    return Scaled(MethodPolicy(InOrder(env)))


def layers(model: PPO) -> list[torch.nn.Linear]:
    """The policy's layers, first to last."""
    network = model.policy
    return [
        *(part for part in network.mlp_extractor.policy_net if isinstance(part, torch.nn.Linear)),
        network.action_net,
    ]


def begin_by_holding(model: PPO, hold: float) -> None:
    """Let four units of every layer hand the move in force on to its own score."""
    first, *between, last = layers(model)
    with torch.no_grad():
        for layer, sources in ((first, MOVE_IN_FORCE), *((layer, range(4)) for layer in between)):
            layer.weight[:4], layer.bias[:4] = 0.0, 0.0
            for unit, source in enumerate(sources):
                layer.weight[unit, source] = 1.0
        last.weight[:, :4] = hold * torch.eye(4)


def save(model: PPO, options: Options, name: str = "policy") -> None:
    """Write the training's state, and the policy as plain arrays."""
    options.out.mkdir(parents=True, exist_ok=True)
    model.save(options.out / f"{name}.zip")
    model.get_vec_normalize_env().save(str(options.out / f"{name}-normal.pkl"))
    scaled = make(options)
    arrays = {"mean": scaled.mean, "std": scaled.std, "clip": np.array(2.0), "step_hz": np.array(options.step_hz)}
    for index, layer in enumerate(layers(model)):
        arrays[f"w{index}"] = layer.weight.detach().cpu().numpy()
        arrays[f"b{index}"] = layer.bias.detach().cpu().numpy()
    np.savez(options.out / f"{name}.npz", **arrays)


def check_out(options: Options) -> None:
    """Leave with 2 if an earlier policy would be replaced unasked."""
    held = sorted([*options.out.glob("policy*"), *options.out.glob("checkpoint-*")])
    if held and not options.overwrite:
        sys.stderr.write(f"error: {held[0]} exists: name another folder, or allow it with --overwrite\n")
        raise SystemExit(2)


def main(options: Options) -> None:
    """Train until the time is over."""
    check_out(options)
    torch.set_num_threads(1)
    makers = [lambda: Monitor(make(options))] * options.envs
    raw = SubprocVecEnv(makers) if options.envs > 1 else DummyVecEnv(makers)
    if options.resume is None:
        model = PPO(
            "MlpPolicy", VecNormalize(raw, norm_obs=False, gamma=0.97), n_steps=options.rollout, batch_size=128,
            n_epochs=10, gamma=0.97, gae_lambda=0.95, ent_coef=0.005, learning_rate=options.learning_rate,
            seed=options.seed, device="cpu", policy_kwargs={"net_arch": [64, 64]},
        )  # fmt: skip
        begin_by_holding(model, options.hold)
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
