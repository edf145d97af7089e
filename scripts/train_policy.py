#!/usr/bin/env python3
"""Train a policy with PPO on the physics; the method ``learned`` uses the resulting file.

python scripts/train_policy.py --minutes 10 --out runs/policy
python -m sjasim.run --method learned --policy runs/policy/policy.npz

The agent observes what an anticipation method observes, and each of its moves stands for the nearest step of the score
(wrappers `MethodPolicy` and `InOrder` of `sjasim_envs.wrappers`), so that the trained policy works as a method. The
initial network mostly keeps the current move. A network that sends each step as soon as possible would never learn what
waiting is good for.
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
    from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecEnv, VecNormalize
except ImportError as missing:
    sys.exit(f"error: {missing}; training needs the extra 'rl': pip install -e '.[rl]'")

CURRENT_MOVE_FEATURES = range(9, 13)
"""Features that encode the current move, one of four."""

SCALED_LIMIT = 2.0
"""Bound of the scaled features."""

MIN_RATE_SHARE = 0.02
"""Smallest learning rate over the initial one."""

REPORTED_EPISODES = 20
"""Number of last episodes whose mean return is printed."""

DISCOUNT = 0.97
"""Discount factor of future rewards, per decision."""


@dataclass(frozen=True)
class Options:
    """Options of the training.

    Attributes:
        minutes: wall time of the training; a rollout that has started is completed.
        out: folder of the policy and its checkpoints.
        envs: number of environments, each in a process of its own.
        step_hz: decisions per second.
        iterations: number of iterations of each dance; there is no rehearsal, in which nothing can be learned.
        seed: seed of everything random, including the seeds of the groups.
        rollout: number of steps of each environment between two updates.
        learning_rate: initial learning rate; it falls linearly with the remaining time.
        hold: initial preference of the network for the current move.
        checkpoint: number of updates between two checkpoints.
        resume: folder of an earlier training to continue.
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


class TrainingCallback(BaseCallback):
    """Prints progress to stderr, writes checkpoints, lowers the learning rate, and ends the training in time.

    Args:
        options: options of the training.
    """

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._options = options
        self._started_s = time.monotonic()
        self._updates = 0

    @property
    def elapsed_share(self) -> float:
        """Share of the time that has passed, at most 1."""
        return min((time.monotonic() - self._started_s) / (60.0 * self._options.minutes), 1.0)

    def _on_step(self) -> bool:
        return self.elapsed_share < 1.0

    def _on_rollout_end(self) -> None:
        self._updates += 1
        remaining = max(1.0 - self.elapsed_share, MIN_RATE_SHARE)
        self.model.lr_schedule = lambda _: self._options.learning_rate * remaining
        self._print_progress()
        if self._updates % self._options.checkpoint == 0:
            save_policy(self.model, self._options, f"checkpoint-{self.num_timesteps}")

    def _print_progress(self) -> None:
        returns = [episode["r"] for episode in list(self.model.ep_info_buffer)[-REPORTED_EPISODES:]]
        mean = f"{np.mean(returns):.2f}" if returns else "-"
        minutes = self.elapsed_share * self._options.minutes
        sys.stderr.write(f"{minutes:6.1f} min  {self.num_timesteps:8d} steps  return of the last episodes {mean}\n")


class ScaleFeatures(gym.ObservationWrapper):
    """Scales features to -2 to 2 by their bounds; the policy's file contains the scale.

    Args:
        env: an environment with the wrapper `MethodPolicy`.

    Attributes:
        mean: middle of each feature's bounds.
        std: a quarter of the distance between them.
    """

    def __init__(self, env: gym.Env) -> None:
        super().__init__(env)
        low = env.observation_space.low
        high = env.observation_space.high
        self.mean = (low + high) / 2
        self.std = (high - low) / 4
        self.observation_space = gym.spaces.Box(-SCALED_LIMIT, SCALED_LIMIT, low.shape, np.float32)

    def observation(self, observation: np.ndarray) -> np.ndarray:
        """Return scaled features."""
        return ((observation - self.mean) / self.std).astype(np.float32)


def make_environment(options: Options) -> ScaleFeatures:
    """Return an environment with the observations that the method ``learned`` will have."""
    env = gym.make(
        "sjasim:sjasim/Dance-v0", iterations=options.iterations, step_hz=options.step_hz, dance={"rehearsal": False},
        disable_env_checker=True,
    )  # fmt: skip
    from sjasim_envs.wrappers import InOrder, MethodPolicy

    return ScaleFeatures(MethodPolicy(InOrder(env)))


def policy_layers(model: PPO) -> list[torch.nn.Linear]:
    """Return the linear layers of the policy from first to last."""
    network = model.policy
    return [
        *(part for part in network.mlp_extractor.policy_net if isinstance(part, torch.nn.Linear)),
        network.action_net,
    ]


def prefer_current_move(model: PPO, preference: float) -> None:
    """Set four units of each layer so that they pass the current move on to its own score."""
    first, *between, last = policy_layers(model)
    with torch.no_grad():
        for layer, sources in ((first, CURRENT_MOVE_FEATURES), *((layer, range(4)) for layer in between)):
            layer.weight[:4] = 0.0
            layer.bias[:4] = 0.0
            for unit, source in enumerate(sources):
                layer.weight[unit, source] = 1.0
        last.weight[:, :4] = preference * torch.eye(4)


def save_policy(model: PPO, options: Options, name: str = "policy") -> None:
    """Write the state of the training, and the policy as plain arrays that need no torch."""
    options.out.mkdir(parents=True, exist_ok=True)
    model.save(options.out / f"{name}.zip")
    model.get_vec_normalize_env().save(str(options.out / f"{name}-normal.pkl"))

    scaled = make_environment(options)
    arrays = {
        "mean": scaled.mean,
        "std": scaled.std,
        "clip": np.array(SCALED_LIMIT),
        "step_hz": np.array(options.step_hz),
    }
    for index, layer in enumerate(policy_layers(model)):
        arrays[f"w{index}"] = layer.weight.detach().cpu().numpy()
        arrays[f"b{index}"] = layer.bias.detach().cpu().numpy()
    np.savez(options.out / f"{name}.npz", **arrays)


def check_output_folder(options: Options) -> None:
    """Exit with 2 if the folder holds an earlier policy that may not be replaced."""
    existing = sorted([*options.out.glob("policy*"), *options.out.glob("checkpoint-*")])
    if existing and not options.overwrite:
        sys.stderr.write(f"error: {existing[0]} exists: name another folder, or allow it with --overwrite\n")
        raise SystemExit(2)


def make_model(options: Options, environments: VecEnv) -> PPO:
    """Return a new model, or that of an earlier training."""
    if options.resume is not None:
        normalized = VecNormalize.load(str(options.resume / "policy-normal.pkl"), environments)
        return PPO.load(options.resume / "policy.zip", env=normalized, device="cpu")

    model = PPO(
        "MlpPolicy", VecNormalize(environments, norm_obs=False, gamma=DISCOUNT), n_steps=options.rollout,
        batch_size=128, n_epochs=10, gamma=DISCOUNT, gae_lambda=0.95, ent_coef=0.005,
        learning_rate=options.learning_rate, seed=options.seed, device="cpu", policy_kwargs={"net_arch": [64, 64]},
    )  # fmt: skip
    prefer_current_move(model, options.hold)
    return model


def main(options: Options) -> None:
    """Train until the time is over, and write the policy."""
    check_output_folder(options)

    # Environments have processes of their own; threads of torch would only compete with them.
    torch.set_num_threads(1)
    makers = [lambda: Monitor(make_environment(options))] * options.envs
    environments = SubprocVecEnv(makers) if options.envs > 1 else DummyVecEnv(makers)
    model = make_model(options, environments)
    try:
        # The callback ends the training; the number of steps is out of reach.
        model.learn(10**9, callback=TrainingCallback(options), reset_num_timesteps=options.resume is None)
    except KeyboardInterrupt:
        sys.stderr.write("stopped; the policy as it is now is kept\n")
    save_policy(model, options)
    sys.stderr.write(f"kept in {options.out / 'policy.npz'}\n")
    environments.close()


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
