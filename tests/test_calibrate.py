"""From event tables to a preset that dances, by the command and in Python."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import sjasim
from sjasim import calibrate
from sjasim.analysis.calibration.event_table_fit import as_toml
from sjasim.choreography.timetable import timetable
from sjasim.commands.main import main
from sjasim.config import SessionConfig
from sjasim.core.errors import ConfigError, PluginError, RecordError
from sjasim.humans.timing.parameters import read_parameters
from sjasim.session.dancers import make_human_timing

CONFIG = SessionConfig(humans="musicians", method="none")


@pytest.fixture
def table(tmp_path):
    """Eight sessions of musicians, as a laboratory would keep them."""
    lines = ["session,iteration,agent,kind,t_s"]
    dance = timetable(CONFIG)
    for session in range(8):
        model = make_human_timing(SessionConfig(humans="musicians", method="none", seed=670_000 + session), dance)
        for iteration in range(5):
            model.begin(iteration, None, np.zeros(3))
            for own in model.decide(-math.inf, ()):
                rows = [(cue.dancer, kind, t_s) for cue in own for kind, t_s in cue.events()]
                lines += [f"group {session},{iteration},{who},{kind},{t_s:.4f}" for who, kind, t_s in rows]
    path = tmp_path / "events.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_fit_is_kept_as_a_preset_that_dances(table, tmp_path, capsys):
    out = tmp_path / "ours.toml"
    assert main(calibrate.command, [str(table), "--out", str(out)]) == 0
    said = capsys.readouterr()
    assert "timekeeper_s" in said.out
    assert "coupling" in said.out
    parameters = read_parameters(out)
    assert parameters.timekeeper_s == pytest.approx(0.025, rel=0.2)
    assert "sessions: 8" in parameters.about
    model = make_human_timing(SessionConfig(humans=str(out)), timetable(CONFIG))
    model.begin(0, None, np.zeros(3))
    assert sum(len(own) for own in model.decide(0.0, ())) >= 12
    assert main(calibrate.command, [str(table), "--out", str(out)]) == 2
    assert "overwrite" in capsys.readouterr().err


def test_the_fit_as_json_and_in_python_are_one(table, capsys):
    assert main(calibrate.command, [str(table), "--json", "--time", "free"]) == 0
    told = json.loads(capsys.readouterr().out)
    fit = sjasim.fit_timing(table, time="free")
    assert told["schema"] == 2
    assert told["events"] == fit.events
    assert told["estimates"]["coupling"]["value"] == pytest.approx(fit.estimates["coupling"].value)


def test_one_performance_has_a_lateness_without_an_interval(tmp_path, capsys):
    rng = np.random.default_rng(5)
    rows = [(0.6 * k + 0.02 * rng.normal(), who) for k in range(40) for who in "ab"]
    lines = [f"s,1,{who},clap,{t_s:.4f}" for t_s, who in sorted(rows)]
    path = tmp_path / "taps.csv"
    path.write_text("\n".join(["session,iteration,agent,kind,t_s", *lines]) + "\n")
    assert main(calibrate.command, [str(path), "--time", "free", "--json"]) == 0
    estimates = json.loads(capsys.readouterr().out)["estimates"]
    assert estimates["late_s[1]"]["low"] is None
    assert 0.0 < estimates["timekeeper_s"]["high"] < 0.05


def test_a_fit_that_cannot_be_danced_is_shown_with_its_doubts_and_not_kept(tmp_path, capsys):
    rng, dance = np.random.default_rng(5), timetable(CONFIG)
    lines = ["session,iteration,agent,kind,t_s"]
    for iteration in range(4):
        late_s, rows = np.zeros(2), []
        for step in dance.choreography.steps():
            late_s = late_s + 0.3 * (late_s - late_s[::-1]) + 0.01 * rng.standard_normal(2)  # they drive each other off
            time_s = dance.time_s(iteration, step.beat)
            rows += [(time_s + late, who, step.kind) for late, who in zip(late_s, "ab", strict=True)]
        lines += [f"s,{iteration},{who},{kind},{t_s:.4f}" for t_s, who, kind in sorted(rows)]
    wild = tmp_path / "wild.csv"
    wild.write_text("\n".join(lines) + "\n")
    assert main(calibrate.command, [str(wild), "--coupling", "matrix"]) == 0
    said = capsys.readouterr()
    assert "coupling[1][2]" in said.out
    assert "warning: one session is too little" in said.err
    assert "warning: the fit makes no group that can dance" in said.err
    assert main(calibrate.command, [str(wild), "--coupling", "matrix", "--out", str(tmp_path / "w.toml")]) == 2
    said = capsys.readouterr()
    assert "coupling[1][2]" in said.out
    assert said.err.splitlines()[-1].startswith("error: the fit makes no group that can dance")
    assert not (tmp_path / "w.toml").exists()


def test_names_with_quotes_make_a_file_too(table, tmp_path):
    named = tmp_path / "named.csv"
    named.write_text(table.read_text().replace("dancer_1", '"Ana ""the beat"""'))
    out = tmp_path / "named.toml"
    out.write_text(as_toml(sjasim.fit_timing(named, time="free")))
    assert 'Ana "the beat"' in read_parameters(out).about


def test_bad_input_is_one_line(table, tmp_path, capsys):
    text = table.read_text().splitlines()
    text[3] = text[3].rpartition(",")[0] + ",soon"
    (tmp_path / "wrong.csv").write_text("\n".join(text))
    for arguments, says in (
        ([str(tmp_path / "wrong.csv")], "wrong.csv, line 4, column 't_s'"),
        ([], "paths"),
        ([str(table), "--coupling", "some"], "coupling"),
        ([str(table), "--dance.bpm", "60"], "dance.bpm"),
    ):
        assert main(calibrate.command, arguments) == 2
        said = capsys.readouterr().err
        assert says in said
        assert said.count("\n") == 1


def test_people_of_a_table_dance_again(table, tmp_path):
    dance = timetable(CONFIG)
    model = make_human_timing(SessionConfig(humans=f"replay:{table}#group 3"), dance)
    model.begin(2, None, np.zeros(3))
    drawn = model.decide(0.0, ())
    wanted = [line for line in table.read_text().splitlines() if line.startswith("group 3,2,dancer_2,")]
    events = [(kind, t_s) for cue in drawn[1] for kind, t_s in cue.events()]
    assert [f"{kind},{t_s:.4f}" for kind, t_s in events] == [line.split(",", 3)[3] for line in wanted]
    with pytest.raises(ConfigError, match=r"one session of the table: replay:.*#group 0"):
        make_human_timing(SessionConfig(humans=f"replay:{table}"), dance)
    with pytest.raises(RecordError, match="does not exist"):
        make_human_timing(SessionConfig(humans="replay:nothing.csv"), dance)


def test_an_own_model_needs_the_three_methods():
    with pytest.raises(PluginError, match="lacks begin, decide or next_due_s"):
        make_human_timing(SessionConfig(humans="tests.test_calibrate:nobody"), timetable(CONFIG))


def nobody(*_):
    return object()
