"""The commands of "Your own data" that fit and replay a group really do so."""

import importlib
import json
import math

import numpy as np

from sjasim.choreography.timetable import timetable
from sjasim.commands.main import main
from sjasim.config import SessionConfig
from sjasim.config.toml_file import to_plain
from sjasim.record.parquet import write_rows
from sjasim.session.dancers import make_human_timing

from .pages import commands

PAGE = "docs/own-data.md"


def rehearsal_cues(config):
    people = make_human_timing(config, timetable(config))
    people.begin(0, None, np.zeros(config.dancers))
    return [cue for own in people.decide(0.0, ()) for cue in own]


def test_a_group_is_fitted_and_its_file_and_folder_can_be_danced(tmp_path, monkeypatch, capsys):
    config = SessionConfig(humans="musicians", iterations=4)
    model = make_human_timing(config, timetable(config))
    cues = []
    for iteration in range(5):
        model.begin(iteration, None, np.zeros(3))
        cues += [cue for own in model.decide(0.0, ()) for cue in own]
    folder = tmp_path / "runs" / "sia"
    folder.mkdir(parents=True)
    write_rows(folder / "cues.parquet", "cues", cues, {})
    (folder / "session.json").write_text(json.dumps({"schema": 1, "versions": {}, "config": to_plain(config)}))
    monkeypatch.chdir(tmp_path)

    lines = [(name, arguments) for _, name, arguments in commands(PAGE) if name in ("calibrate", "run")]
    assert [name for name, _ in lines] == ["calibrate", "run", "run", "calibrate"]
    (_, fit), (_, fitted), (_, replayed), _ = lines
    ended = main(importlib.import_module("sjasim.calibrate").command, fit)
    assert ended == 0, capsys.readouterr().err

    for arguments in (fitted, replayed):
        humans = arguments[arguments.index("--humans") + 1]
        danced = rehearsal_cues(SessionConfig(humans=humans, iterations=4))
        assert len(danced) == 18
    assert all(math.isclose(one.t_s, other.t_s) for one, other in zip(danced, cues, strict=False))
