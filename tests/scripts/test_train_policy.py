"""Training of a policy: the file can be read with numpy alone, and the method ``learned`` accepts it."""

import importlib.util
import sys
import types
from pathlib import Path

import numpy as np
import pytest

from sjasim.anticipation.method import build_method
from sjasim.anticipation.policy_network import PolicyNetwork

ROOT = Path(__file__).resolve().parents[2]


def script(monkeypatch):
    """The script as a module."""
    spec = importlib.util.spec_from_file_location("train_policy", ROOT / "scripts" / "train_policy.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "train_policy", module)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["policy.npz", "checkpoint-512.zip"])
def test_an_earlier_policy_is_replaced_only_on_request(tmp_path, monkeypatch, capsys, name):
    names = ("PPO", "BaseCallback", "Monitor", "DummyVecEnv", "SubprocVecEnv", "VecEnv", "VecNormalize")
    common = [f"stable_baselines3.common{part}" for part in ("", ".callbacks", ".monitor", ".vec_env")]
    for library in ("torch", "stable_baselines3", *common):
        fake = types.ModuleType(library)
        fake.__dict__.update({name: type(name, (), {}) for name in names})
        monkeypatch.setitem(sys.modules, library, fake)
    training = script(monkeypatch)
    training.check_output_folder(training.Options(out=tmp_path / "new"))
    (tmp_path / name).write_bytes(b"mine")
    with pytest.raises(SystemExit) as end:
        training.main(training.Options(out=tmp_path))
    assert end.value.code == 2
    assert (
        capsys.readouterr().err
        == f"error: {tmp_path / name} exists: name another folder, or allow it with --overwrite\n"
    )
    training.check_output_folder(training.Options(out=tmp_path, overwrite=True))


@pytest.mark.slow
def test_a_short_training_writes_a_policy_and_can_be_continued(tmp_path, monkeypatch, capsys):
    pytest.importorskip("stable_baselines3", reason="the extra rl is not installed")
    import torch

    training = script(monkeypatch)
    options = {"minutes": 0.05, "envs": 1, "iterations": 1, "rollout": 32, "checkpoint": 1}
    training.main(training.Options(out=tmp_path / "one", **options))
    training.main(training.Options(out=tmp_path / "two", resume=tmp_path / "one", **options))
    assert "steps  return of the last episodes" in capsys.readouterr().err
    assert list((tmp_path / "two").glob("checkpoint-*.npz"))
    network = PolicyNetwork.read(tmp_path / "two" / "policy.npz")
    model = training.PPO.load(tmp_path / "two" / "policy.zip", device="cpu")
    env = training.make_environment(training.Options())
    row, _ = env.reset(seed=0)
    features = row * env.std + env.mean
    with torch.no_grad():
        logits = model.policy.get_distribution(torch.as_tensor(row[None])).distribution.logits[0].numpy()
    scores = network.scores(features.astype(float))
    assert scores - scores.mean() == pytest.approx(logits - logits.mean(), abs=1e-4)
    assert np.argmax(scores) == np.argmax(row[training.CURRENT_MOVE_FEATURES.start :][:4])
    build_method("learned", {"policy": str(tmp_path / "two" / "policy.npz")})
