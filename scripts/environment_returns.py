#!/usr/bin/env python3
"""Measure the returns of simple policies and of the anticipation methods in sjasim/Dance-v0.

The result is a Markdown table with confidence intervals.

python scripts/environment_returns.py --groups 20 --out docs/environment_returns.json --page docs/environment.md
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import gymnasium as gym
import numpy as np
import tyro
from joblib import Parallel, delayed
from rich.console import Console
from rich.progress import track

RESAMPLES = 10_000
"""Number of bootstrap samples of an interval."""

BEGIN = "<!-- returns: written by scripts/environment_returns.py -->\n"
"""Line of a page before the table."""

END = "<!-- end of returns -->\n"
"""Line of a page after the table."""

SIMPLE = {
    "idle": "idle: stands still",
    "random": "random: any action, 30 times a second",
    "random-in-order": "random, `InOrder`: any action, 6 times a second",
}
"""Policies that are no anticipation methods, with their names in the table."""


@dataclass(frozen=True)
class Options:
    """Returns of policies with groups of dancers that no training used.

    Attributes:
        groups: number of groups of dancers; all policies dance with the same groups.
        first_seed: seed of the first group; the following groups have the following seeds.
        policies: ``idle``, ``random``, ``random-in-order``, or names of anticipation methods.
        policy: npz file of a trained policy, which is added to the table.
        iterations: number of iterations of each dance.
        jobs: number of processes.
        out: JSON file for the episodes.
        page: Markdown page whose table is replaced.
    """

    groups: int = 20
    first_seed: int = 1_000_000
    policies: tuple[str, ...] = ("idle", "random", "random-in-order", "metronome", "eca", "sia")
    policy: str = ""
    iterations: int = 4
    jobs: int = 2
    out: Path | None = None
    page: Path | None = None


def make_environment(policy: str, iterations: int, file: str) -> gym.Env:
    """Return the environment for a policy; the robot of a method is commanded by the method itself."""
    options: dict[str, object] = {} if policy in SIMPLE else {"method": policy}
    if policy == "learned":
        options["method_options"] = {"policy": file}
    if policy == "random-in-order":
        options["step_hz"] = 6
    env = gym.make(
        "sjasim:sjasim/Dance-v0", iterations=iterations, performance="one", disable_env_checker=True, **options
    )
    if policy == "random-in-order":
        from sjasim_envs.wrappers import InOrder

        env = InOrder(env)
    return env


def choose_action(policy: str, env: gym.Env, observation: dict[str, np.ndarray]) -> int:
    """Return the action of a simple policy, or the command of the method."""
    if policy.startswith("random"):
        return env.action_space.sample()
    if policy == "idle":
        return 0
    return int(observation["command"][:4].argmax())


def episode(policy: str, seed: int, iterations: int, file: str) -> dict[str, object]:
    """Run one dance and return its figures.

    Args:
        policy: name of the policy.
        seed: seed of the group.
        iterations: number of iterations.
        file: npz file of a trained policy, for ``learned``.
    """
    env = make_environment(policy, iterations, file)
    observation, _ = env.reset(seed=seed)
    env.action_space.seed(seed)

    total = 0.0
    iteration_infos = []
    terminated = False
    while not terminated:
        observation, reward, terminated, _, info = env.step(choose_action(policy, env, observation))
        total += reward
        # The figures of an iteration come with its last step.
        if "gsi" in info:
            iteration_infos.append(info)

    errors_s = np.abs([info["event_errors_s"] for info in iteration_infos])
    missed = sum(info["robot_missed"] for info in iteration_infos)
    return {
        "policy": policy,
        "seed": seed,
        "return": total,
        "gsi_full_edges": float(np.mean([info["gsi_full_edges"] for info in iteration_infos])),
        "ta_s": float(np.nanmean(errors_s)) if np.isfinite(errors_s).any() else None,
        "missed": missed / (len(iteration_infos) * errors_s.shape[1]),
    }


def interval(values: Sequence[float]) -> str:
    """Return the mean and its 95 % bootstrap interval over groups, as text."""
    if not values:
        return "none"
    rng = np.random.default_rng(0)
    means = rng.choice(values, (RESAMPLES, len(values))).mean(axis=1)
    low, high = np.quantile(means, (0.025, 0.975))
    return f"{np.mean(values):.2f} [{low:.2f}, {high:.2f}]"


def table(rows: Sequence[dict[str, object]]) -> str:
    """Return the episodes as a Markdown table with one line per policy, in the order of the episodes."""
    lines = ["| policy | return | TA [s] | GSI, full edges | steps missed |", "|---|---|---|---|---|"]
    for name in dict.fromkeys(row["policy"] for row in rows):
        own = [row for row in rows if row["policy"] == name]
        cells = [
            interval([row[key] for row in own if row[key] is not None])
            for key in ("return", "ta_s", "gsi_full_edges", "missed")
        ]
        lines.append(f"| {SIMPLE.get(name, f'`{name}`')} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def on_page(page: str, rows: Sequence[dict[str, object]]) -> str:
    """Return a page with its table replaced."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{table(rows)}\n{END}{after}"


def main(options: Options) -> None:
    """Run all episodes, print the table, and write the files that are asked for."""
    policies = (*options.policies, "learned") if options.policy else options.policies
    seeds = range(options.first_seed, options.first_seed + options.groups)
    work = [delayed(episode)(name, seed, options.iterations, options.policy) for name in policies for seed in seeds]

    # The generator yields episodes as they end, which the progress display needs.
    episodes = Parallel(n_jobs=options.jobs, return_as="generator")(work)
    console = Console(stderr=True, quiet=not sys.stderr.isatty())
    rows = list(track(episodes, "dancing", total=len(work), console=console))

    sys.stdout.write(table(rows))
    if options.out is not None:
        kept = {"versions": {name: version(name) for name in ("mujoco", "numpy", "gymnasium")}, "episodes": rows}
        options.out.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    if options.page is not None:
        options.page.write_text(on_page(options.page.read_text(encoding="utf-8"), rows), encoding="utf-8")


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
