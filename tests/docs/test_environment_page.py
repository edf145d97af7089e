"""The page of the environments names what they have; its table of returns and its training example are real."""

import dataclasses
import importlib.util
import json
import sys

import gymnasium as gym
import numpy as np
import pytest
from sjasim_envs import ENVIRONMENTS
from sjasim_envs.dance import OPTIONS
from sjasim_envs.reward import RewardConfig
from sjasim_envs.wrappers import MethodPolicy

from .pages import EXAMPLES, ROOT, text_of

PAGE = "docs/environment.md"


def test_the_page_names_what_the_environments_have():
    page = text_of(PAGE)
    env = gym.make("sjasim:sjasim/Dance-v0", disable_env_checker=True)
    dancers = env.unwrapped.config.dancers
    steps = env.observation_space["last_iteration"].shape[1]
    for name, space in env.observation_space.items():
        shape = str(space.shape).replace(str((dancers, steps)), "(D, K)").replace(f"({dancers}, ", "(D, ")
        assert f"| `{name}` | {shape} |" in page, name
    for field in dataclasses.fields(RewardConfig):
        assert f"`{field.name}` {field.default:g}" in page, field.name
    assert all(f"`{name}`" in page for name in (*ENVIRONMENTS, *OPTIONS))
    assert f"{MethodPolicy(env).observation_space.shape[0]} numbers" in page


def test_the_table_of_returns_is_that_of_the_episodes():
    """Policies that are nearer to the dancers have the higher returns."""
    script = _script("environment_returns")
    page = text_of(PAGE)
    rows = json.loads((ROOT / "docs" / "environment_returns.json").read_text(encoding="utf-8"))["episodes"]
    assert script.on_page(page, rows) == page

    episodes = {name: [row for row in rows if row["policy"] == name] for name in script.Options.policies}
    means = {name: np.mean([row["return"] for row in own]) for name, own in episodes.items()}
    ta_s = {name: np.mean([row["ta_s"] for row in episodes[name] if row["ta_s"]]) for name in ("random", "eca", "sia")}
    assert min(len(own) for own in episodes.values()) >= 20
    assert sorted(ta_s, key=ta_s.get) == sorted(ta_s, key=lambda name: -means[name])
    assert min(means["sia"], means["eca"]) > means["idle"]
    learned = [row["return"] for row in rows if row["policy"] == "learned"]
    assert np.mean(learned) > max(means["random"], means["random-in-order"])


@pytest.fixture
def training():
    return (EXAMPLES / "train.py").read_text(encoding="utf-8")


def test_the_training_example_has_ten_lines_and_is_that_of_the_page(training):
    imports, lines = training.partition('"""\n\n')[2].split("\n\n")
    assert len(lines.splitlines()) == 10
    assert f"```python\n{imports}\n\n{lines}```" in text_of(PAGE)


@pytest.mark.slow
def test_the_training_example_learns(training, capsys):
    exec(compile(training, "train.py", "exec"), {})
    best = [float(line.rpartition(" ")[2]) for line in capsys.readouterr().out.splitlines()]
    assert best[0] < -3.0
    assert best[-1] > 0.0


def _script(name):
    """A script of the folder scripts/ as a module."""
    path = ROOT / "scripts" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = sys.modules[path.stem] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
