#!/usr/bin/env python3
"""Returns of simple policies and of the anticipation methods in sjasim/Dance-v0, as a table with intervals.

python scripts/environment_returns.py --groups 20
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import gymnasium as gym
import numpy as np
import tyro
from joblib import Parallel, delayed
from rich.progress import track

RESAMPLES = 10_000


@dataclass(frozen=True)
class Options:
    """Returns of policies on unseen groups.

    Attributes:
        groups: how many groups of dancers each policy meets; the same for all.
        first_seed: seed of the first group; later ones count up from it.
        policies: idle, random, or names of anticipation methods.
        policy: npz file of a learned policy, which is then added to the table.
        iterations: of each dance.
        jobs: processes.
        out: JSON file to keep the episodes in.
    """

    groups: int = 20
    first_seed: int = 1_000_000
    policies: tuple[str, ...] = ("idle", "random", "metronome", "eca", "sia")
    policy: str = ""
    iterations: int = 4
    jobs: int = 2
    out: Path | None = None


def episode(policy: str, seed: int, iterations: int, file: str) -> dict[str, object]:
    """One dance: its return and its figures."""
    options = {} if policy in ("idle", "random") else {"method": policy}
    if policy == "learned":
        options["method_options"] = {"policy": file}
    env = gym.make(
        "sjasim:sjasim/Dance-v0", iterations=iterations, performance="one", disable_env_checker=True, **options
    )
    observation, _ = env.reset(seed=seed)
    env.action_space.seed(seed)
    total, rows, over = 0.0, [], False
    while not over:
        if policy == "random":
            action = env.action_space.sample()
        else:
            action = 0 if policy == "idle" else int(observation["command"][:4].argmax())
        observation, reward, over, _, info = env.step(action)
        total += reward
        if "gsi" in info:
            rows.append(info)
    errors = np.abs([row["event_errors_s"] for row in rows])
    return {
        "policy": policy,
        "seed": seed,
        "return": total,
        "gsi_full_edges": float(np.mean([row["gsi_full_edges"] for row in rows])),
        "ta_s": float(np.nanmean(errors)) if np.isfinite(errors).any() else None,
        "missed": sum(row["robot_missed"] for row in rows) / (len(rows) * errors.shape[1]),
    }


def interval(values: list[float]) -> str:
    """Mean and 95 % bootstrap interval over groups."""
    if not values:
        return "-"
    rng = np.random.default_rng(0)
    means = rng.choice(values, (RESAMPLES, len(values))).mean(axis=1)
    low, high = np.quantile(means, (0.025, 0.975))
    return f"{np.mean(values):.2f} [{low:.2f}, {high:.2f}]"


def main(options: Options) -> None:
    """Dance, then print the table as Markdown."""
    policies = (*options.policies, "learned") if options.policy else options.policies
    seeds = range(options.first_seed, options.first_seed + options.groups)
    work = [delayed(episode)(name, seed, options.iterations, options.policy) for name in policies for seed in seeds]
    found = Parallel(n_jobs=options.jobs, return_as="generator")(work)
    rows = list(track(found, "dancing", total=len(work), console=None if sys.stderr.isatty() else _quiet()))
    if options.out is not None:
        options.out.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    sys.stdout.write("| policy | return | TA [s] | GSI, full edges | steps missed |\n|---|---|---|---|---|\n")
    for name in policies:
        own = [row for row in rows if row["policy"] == name]
        cells = [interval([row[key] for row in own if row[key] is not None])
                 for key in ("return", "ta_s", "gsi_full_edges", "missed")]  # fmt: skip
        sys.stdout.write(f"| {name} | {' | '.join(cells)} |\n")


def _quiet() -> object:
    from rich.console import Console

    return Console(stderr=True, quiet=True)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
