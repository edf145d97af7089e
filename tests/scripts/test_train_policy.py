"""Training leaves a policy that numpy alone can read, and that dances."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from sjasim.anticipation.learned import Network
from sjasim.anticipation.method import build

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
def test_a_short_training_leaves_a_policy_and_what_it_takes_to_go_on(tmp_path, capsys):
    pytest.importorskip("stable_baselines3", reason="the extra rl is not installed")
    import torch

    spec = importlib.util.spec_from_file_location("train_policy", ROOT / "scripts" / "train_policy.py")
    script = sys.modules["train_policy"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    options = {"minutes": 0.05, "envs": 1, "iterations": 1, "rollout": 32, "checkpoint": 1}
    script.main(script.Options(out=tmp_path / "one", **options))
    script.main(script.Options(out=tmp_path / "two", resume=tmp_path / "one", **options))
    assert "steps  return of the last episodes" in capsys.readouterr().err
    assert list((tmp_path / "two").glob("checkpoint-*.npz"))
    network = Network.read(tmp_path / "two" / "policy.npz")
    model = script.PPO.load(tmp_path / "two" / "policy.zip", device="cpu")
    env = script.make(script.Options())
    row, _ = env.reset(seed=0)
    told = row * env.std + env.mean
    with torch.no_grad():
        logits = model.policy.get_distribution(torch.as_tensor(row[None])).distribution.logits[0].numpy()
    scores = network.scores(told.astype(float))
    assert scores - scores.mean() == pytest.approx(logits - logits.mean(), abs=1e-4)
    assert np.argmax(scores) == np.argmax(row[script.MOVE_IN_FORCE.start :][:4])
    build("learned", {"policy": str(tmp_path / "two" / "policy.npz")})
