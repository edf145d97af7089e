#!/usr/bin/env python3
"""Returns of simple policies and of the anticipation methods in sjasim/Dance-v0, as a table with intervals.

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

BEGIN, END = "<!-- returns: written by scripts/environment_returns.py -->\n", "<!-- end of returns -->\n"
"""What the table stands between in the page."""

SIMPLE = {
    "idle": "idle: stands still",
    "random": "random: any action, 30 times a second",
    "random-in-order": "random, `InOrder`: any action, 6 times a second",
}
"""Policies that are no methods -> what they are called in the table."""


@dataclass(frozen=True)
class Options:
    """Returns of policies on unseen groups.

    Attributes:
        groups: how many groups of dancers each policy meets; the same for all.
        first_seed: seed of the first group; later ones count up from it.
        policies: idle, random, random-in-order, or names of anticipation methods.
        policy: npz file of a learned policy, which is then added to the table.
        iterations: of each dance.
        jobs: processes.
        out: JSON file to keep the episodes in.
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


def episode(policy: str, seed: int, iterations: int, file: str) -> dict[str, object]:
    """One dance: its return and its figures."""
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
    observation, _ = env.reset(seed=seed)
    env.action_space.seed(seed)
    total, rows, over = 0.0, [], False
    while not over:
        if policy.startswith("random"):
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


def interval(values: Sequence[float]) -> str:
    """Mean and 95 % bootstrap interval over groups."""
    if not values:
        return "none"
    rng = np.random.default_rng(0)
    means = rng.choice(values, (RESAMPLES, len(values))).mean(axis=1)
    low, high = np.quantile(means, (0.025, 0.975))
    return f"{np.mean(values):.2f} [{low:.2f}, {high:.2f}]"


def table(rows: Sequence[dict[str, object]]) -> str:
    """The episodes as a Markdown table, a line for each policy, in the order in which they come."""
    lines = ["| policy | return | TA [s] | GSI, full edges | steps missed |", "|---|---|---|---|---|"]
    for name in dict.fromkeys(row["policy"] for row in rows):
        own = [row for row in rows if row["policy"] == name]
        cells = [interval([row[key] for row in own if row[key] is not None])
                 for key in ("return", "ta_s", "gsi_full_edges", "missed")]  # fmt: skip
        lines.append(f"| {SIMPLE.get(name, f'`{name}`')} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def on_page(page: str, rows: Sequence[dict[str, object]]) -> str:
    """A page with the table in the place of the one that it holds."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{table(rows)}\n{END}{after}"


def main(options: Options) -> None:
    """Dance, then print the table as Markdown, and keep it where it is wanted."""
    policies = (*options.policies, "learned") if options.policy else options.policies
    seeds = range(options.first_seed, options.first_seed + options.groups)
    work = [delayed(episode)(name, seed, options.iterations, options.policy) for name in policies for seed in seeds]
    found = Parallel(n_jobs=options.jobs, return_as="generator")(work)
    rows = list(track(found, "dancing", total=len(work), console=Console(stderr=True, quiet=not sys.stderr.isatty())))
    sys.stdout.write(table(rows))
    if options.out is not None:
        kept = {"versions": {name: version(name) for name in ("mujoco", "numpy", "gymnasium")}, "episodes": rows}
        options.out.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    if options.page is not None:
        options.page.write_text(on_page(options.page.read_text(encoding="utf-8"), rows), encoding="utf-8")


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
