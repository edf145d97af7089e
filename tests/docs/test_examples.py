"""The README's example is a method: it keeps the contract and commands every step that its dancer dances."""

import dataclasses
import importlib
import importlib.util
import json
import math
import re
import sys
import tomllib
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from sjasim_envs import ENVIRONMENTS
from sjasim_envs.dance import OPTIONS
from sjasim_envs.reward import RewardConfig
from sjasim_envs.wrappers import MethodPolicy

from sjasim.anticipation import method
from sjasim.choreography.timetable import timetable
from sjasim.commands.main import main
from sjasim.config import FAULTS, SessionConfig
from sjasim.config.toml_file import from_plain, to_plain
from sjasim.core.errors import SjasimError
from sjasim.core.method_io import MethodContext, ScheduleCommand
from sjasim.record.parquet import write_rows
from sjasim.simulation.cast import make_human_timing

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def context_and_log(make_session_log):
    log = make_session_log(iterations=2, joints=False)
    table = timetable(from_plain(log.config))
    numbers = range(3)
    context = MethodContext(
        cast=("dancer_1", "dancer_2", "dancer_3"),
        steps=table.choreography.steps(),
        iterations=2,
        beat_s=60 / 118,
        iteration_start_s=tuple(table.start_s(number) for number in numbers),
        window_end_s=tuple(table.close_s(number) for number in numbers),
    )
    return context, log


@pytest.mark.parametrize("dancer", ["dancer_1", "dancer_3"])
def test_the_example_commands_every_step_once_seen(context_and_log, monkeypatch, dancer):
    context, log = context_and_log
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "examples"))
    plugin = method.build_method("follow_first:FollowFirst", {"dancer": dancer})
    plugin.reset(context, np.random.default_rng(0))
    answers = [answer for event in sorted(log.events, key=lambda e: e.t_arrival_s) for answer in plugin.on_event(event)]
    assert all(isinstance(answer, ScheduleCommand) and answer.person == dancer for answer in answers)
    assert [(answer.iteration, answer.ordinal) for answer in answers] == [(i, k) for i in (1, 2) for k in range(9)]
    assert list(plugin.on_iteration_start(1, 0.0)) == list(plugin.on_iteration_end(1, 0.0)) == []
    assert list(plugin.on_timer(0.0)) == []


def test_the_readme_names_files_and_figures_that_exist():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for path in re.findall(r"\]\(([\w./-]+)\)", text):
        assert (ROOT / path).exists() or path == "docs/overview.png", path
    for block in re.findall(r"```json\n(.*?)```", text, re.S):
        json.loads(block)


def test_the_readmes_settings_and_dance_are_understood():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (settings,) = re.findall(r"```toml\n(.*?)```", text, re.S)
    assert [fault.kind for fault in from_plain(tomllib.loads(settings)).faults] == ["clock_jump", "dancer_late"]
    assert all(f"`{kind}`" in text or f'"{kind}"' in text for kind in FAULTS)
    (code,) = [block for block in re.findall(r"```python\n(.*?)```", text, re.S) if "Choreography" in block]
    exec(code, found := {})
    assert [step.kind.value for step in found["there_and_back"]().steps()][-2:] == ["stop_backward", "clap"]


def test_the_page_of_the_environments_names_what_they_have():
    page = (ROOT / "docs" / "environment.md").read_text(encoding="utf-8")
    env = gym.make("sjasim:sjasim/Dance-v0", disable_env_checker=True)
    dancers, steps = env.unwrapped.config.dancers, env.observation_space["last_iteration"].shape[1]
    for name, space in env.observation_space.items():
        shape = str(space.shape).replace(str((dancers, steps)), "(D, K)").replace(f"({dancers}, ", "(D, ")
        assert f"| `{name}` | {shape} |" in page, name
    for field in dataclasses.fields(RewardConfig):
        assert f"`{field.name}` {field.default:g}" in page, field.name
    assert all(f"`{name}`" in page for name in (*ENVIRONMENTS, *OPTIONS))
    assert f"{MethodPolicy(env).observation_space.shape[0]} numbers" in page
    assert page.count("<!-- ") == 2


def test_the_table_of_returns_is_that_of_the_episodes():
    """Both or neither; and who is nearer to the dancers has the higher return."""
    path = ROOT / "docs" / "environment_returns.json"
    script = load(ROOT / "scripts" / "environment_returns.py")
    page = (ROOT / "docs" / "environment.md").read_text(encoding="utf-8")
    assert path.exists() == (script.BEGIN + script.END not in page)
    if not path.exists():
        return
    rows = json.loads(path.read_text(encoding="utf-8"))["episodes"]
    assert script.on_page(page, rows) == page
    episodes = {name: [row for row in rows if row["policy"] == name] for name in script.Options.policies}
    means = {name: np.mean([row["return"] for row in own]) for name, own in episodes.items()}
    ta_s = {name: np.mean([row["ta_s"] for row in episodes[name] if row["ta_s"]]) for name in ("random", "eca", "sia")}
    assert min(len(own) for own in episodes.values()) >= 20
    assert sorted(ta_s, key=ta_s.get) == sorted(ta_s, key=lambda name: -means[name])
    assert min(means["sia"], means["eca"]) > means["idle"]
    learned = [row["return"] for row in rows if row["policy"] == "learned"]
    assert not learned or np.mean(learned) > max(means["random"], means["random-in-order"])


def load(path):
    """A script as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = sys.modules[path.stem] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def returns(capsys, code):
    """Best returns so far that the training example prints."""
    exec(compile(code, "train.py", "exec"), {})
    return [float(line.rpartition(" ")[2]) for line in capsys.readouterr().out.splitlines()]


@pytest.fixture
def training():
    return (ROOT / "docs" / "examples" / "train.py").read_text(encoding="utf-8")


def test_the_training_example_has_ten_lines_and_runs(training, capsys):
    imports, lines = training.partition('"""\n\n')[2].split("\n\n")
    assert len(lines.splitlines()) == 10
    assert f"```python\n{imports}\n\n{lines}```" in (ROOT / "docs" / "environment.md").read_text(encoding="utf-8")
    short = training.replace('"rehearsal": False', '"rehearsal": False, "bpm": 200.0')
    assert len(returns(capsys, short.replace("range(12)", "range(1)"))) == 1


@pytest.mark.slow
def test_the_training_example_learns(training, capsys):
    best = returns(capsys, training)
    assert best[0] < -3.0
    assert best[-1] > 0.0


def test_the_readmes_participants_are_fitted_and_dance(tmp_path, monkeypatch, capsys):
    """Every command of "Your own participants", beside a session's folder; of `run` all but the dancing."""
    config = SessionConfig(humans="musicians", iterations=4)
    table = timetable(config)
    model, cues = make_human_timing(config, table), []
    for iteration in range(5):
        model.begin(iteration, None, np.zeros(3))
        cues += [cue for own in model.decide(0.0, ()) for cue in own]
    folder = tmp_path / "runs" / "sia"
    folder.mkdir(parents=True)
    write_rows(folder / "cues.parquet", "cues", cues, {})
    (folder / "session.json").write_text(json.dumps({"schema": 1, "versions": {}, "config": to_plain(config)}))
    monkeypatch.chdir(tmp_path)
    danced = []

    def run_session(config, *observers):
        model = make_human_timing(config, timetable(config))
        model.begin(0, None, np.zeros(config.dancers))
        danced.append([cue for own in model.decide(0.0, ()) for cue in own])
        raise SjasimError("enough")

    monkeypatch.setattr("sjasim.session.session.run_session", run_session)
    text = (ROOT / "README.md").read_text(encoding="utf-8").partition("## Your own participants")[2]
    commands = re.findall(r"^python3 scripts/launch.py (\w+) ([^#\n]*)", text.partition("\n## ")[0], re.M)
    commands = [(name, arguments) for name, arguments in commands if name in ("calibrate", "run")]
    assert [name for name, _ in commands] == ["calibrate", "run", "run"]
    for name, arguments in commands:
        ended = main(importlib.import_module(f"sjasim.{name}").command, arguments.split())
        said = capsys.readouterr().err
        assert (ended, "enough" in said) == ((2, True) if name == "run" else (0, False)), said
    assert [len(cues) for cues in danced] == [18, 18]
    assert all(math.isclose(one.t_s, other.t_s) for one, other in zip(danced[1], cues, strict=False))
