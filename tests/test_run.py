"""The command line: one table or one JSON, one clear line for bad input, and the exit codes."""

import contextlib
import json
import sys
import types

import pytest

from sjasim import benchmark, run
from sjasim.commands.main import main
from sjasim.config import SessionConfig
from sjasim.config.toml_file import from_plain, to_toml

from .anticipation.policies import write


@pytest.fixture
def danced(monkeypatch, make_session_log):
    """Sessions made by formula stand in for danced ones; the configurations that were asked for."""
    asked = []

    def run_session(config, progress=None, prepare=None):
        asked.append(config)
        progress(0.5)
        robot = config.method != "none"
        return make_session_log(config.method, config.seed, config.iterations, robot=robot, joints=False)

    fake = types.ModuleType("sjasim.session.session")
    fake.run_session = run_session
    monkeypatch.setitem(sys.modules, "sjasim.session.session", fake)
    profiling = types.ModuleType("sjasim.simulation.profiling")
    figures = {"sim_s": 90.0, "cpu_s": 4.5, "raw_cpu_s": 3.0, "room_cpu_s": {"planning": 0.09}}
    profiling.profile = lambda config: figures
    profiling.profile_depth = lambda config: {"depth_sim_s": 30.0, "depth_cpu_s": 6.0}
    monkeypatch.setitem(sys.modules, "sjasim.simulation.profiling", profiling)
    environments = types.ModuleType("sjasim_envs.profiling")
    environments.profile_env = lambda: {"env_steps": 900, "env_cpu_s": 1.5, "env_raw_cpu_s": 1.2}
    environments.profile_workers = lambda: {"async_steps_per_s": (500.0, 900.0)}
    monkeypatch.setitem(sys.modules, "sjasim_envs.profiling", environments)
    return asked


def call(*arguments):
    return main(run.command, arguments)


def test_a_table_by_default(danced, capsys):
    assert call("--method", "eca", "--iterations", "2") == 0
    out = capsys.readouterr().out
    assert "GSI" in out
    assert "[s]" in out  # the unit of TA
    assert "detectors:" in out
    assert "at 3.0 s: west: no message for 2.0 s" in out
    assert danced == [SessionConfig(method="eca", iterations=2)]


def test_a_trained_policy_is_named_by_its_file(danced, capsys, tmp_path):
    file = write(tmp_path / "policy.npz")
    assert call("--method", "learned", "--policy", file) == 0
    assert danced[0].method_options == {"policy": file}
    assert call("--method", "eca", "--policy", file) == 2
    assert "only with --method learned" in capsys.readouterr().err
    assert call("--method", "learned", "--policy", str(tmp_path / "none.npz")) == 2
    assert call("--method", "learned") == 2
    assert len(danced) == 1


def test_humans_only_shows_no_robot(danced, capsys):
    assert call("--method", "none", "--iterations", "1") == 0
    assert "robot:" not in capsys.readouterr().out


@pytest.mark.skipif(sys.platform.startswith("win"), reason="there SIGTERM ends a process whatever it does")
def test_a_request_to_end_removes_what_is_half_written(danced, monkeypatch, tmp_path):
    import os
    import signal

    def asked_to_end(config, progress=None, prepare=None):
        os.kill(os.getpid(), signal.SIGTERM)
        signal.pause()

    draft = tmp_path / "draft"

    def command(arguments):
        with contextlib.ExitStack() as closing:
            draft.write_text("")
            closing.callback(draft.unlink)
            run.command(arguments)

    monkeypatch.setattr(sys.modules["sjasim.session.session"], "run_session", asked_to_end)
    with pytest.raises(SystemExit) as end:
        main(command, [])
    assert end.value.code == 143
    assert list(tmp_path.iterdir()) == []
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


def test_json_is_all_there_is_and_equals_the_folder(danced, capsys, tmp_path):
    assert call("--json", "--iterations", "1", "--out", str(tmp_path / "one")) == 0
    out = capsys.readouterr().out
    assert json.loads(out)["schema"] == 2
    assert (tmp_path / "one" / "session.json").read_text() == out
    assert (tmp_path / "one" / "session.rrd").exists()


def test_flags_override_the_file(danced, tmp_path, capsys):
    path = tmp_path / "session.toml"
    base = from_plain(
        {"method": "eca", "seed": 5, "iterations": 1, "faults": [{"kind": "dead_sensor", "target": "west"}]}
    )
    path.write_text(to_toml(base))
    assert call("--config", str(path), "--seed", "6", "--robot.cruise-m-s", "0.3") == 0
    assert danced[0].seed == 6
    assert danced[0].robot.cruise_m_s == 0.3
    assert danced[0].faults == base.faults
    assert call(f"--config={path}") == 0
    assert danced[1] == base


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--method", "sai"], "sia"),
        (["--method", "no_such_module:Class"], "no_such_module"),
        (["--iterations", "-4"], "iterations"),
        (
            ["--iterations", "many"],
            "error: --iterations must be a whole number, not 'many' (see",
        ),
        (["--iterations", "1.5"], "error: --iterations must be a whole number, not '1.5' (see"),
        (["--robot.cruise-m-s", "fast"], "error: --robot.cruise-m-s must be a number, not 'fast' (see"),
        (["--seed"], "error: --seed needs a value (see"),
        (["--method", "siaa"], "sia, none, or module:Name"),
        (["--dance.lead-in-s", "-1"], "dance.lead_in_s"),
        (["--bogus", "1"], "--bogus"),
        (["--methode", "sia"], "error: unknown options: --methode, sia; perhaps you meant --method (see"),
        (["--config", "/no/such.toml"], "/no/such.toml"),
        (["--out", "/proc/nowhere/x"], "/proc/nowhere/x"),
        (["--method-options.wndow-s", "1"], "perhaps you meant --method-options.window-s"),
        (["--fidelity", "exact"], "physics"),
    ],
)
def test_bad_input_gives_one_line_and_2(danced, capsys, arguments, says):
    assert call(*arguments) == 2
    heard = capsys.readouterr()
    assert heard.out == ""
    assert heard.err.startswith("error: ")
    assert heard.err.count("\n") == 1
    assert says in heard.err
    assert danced == []


def test_help_exits_with_0(danced, capsys):
    with pytest.raises(SystemExit) as end:
        call("--help")
    assert end.value.code == 0
    assert "--robot.cruise-m-s" in capsys.readouterr().out


def test_ctrl_c_gives_130_and_leaves_nothing(danced, monkeypatch, tmp_path, capsys):
    def interrupted(config, progress=None, prepare=None):
        raise KeyboardInterrupt

    monkeypatch.setattr(sys.modules["sjasim.session.session"], "run_session", interrupted)
    assert call("--out", str(tmp_path / "one")) == 130
    assert list(tmp_path.iterdir()) == []


def test_the_benchmark_names_every_figure(danced, capsys, monkeypatch):
    monkeypatch.setattr(benchmark.figures, "import_time_s", lambda: 0.1)
    timing = {"timing_sessions": 50.0, "timing_cpu_s": 0.25}
    monkeypatch.setattr(benchmark.figures, "profile_timing", lambda config: timing)
    assert main(benchmark.command, ["--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert set(report["figures"]) == set(benchmark.figures.UNITS)
    assert report["figures"]["session_cost_ratio_joints"] == 1.5
    assert report["figures"]["raw_physics_sim_s_per_cpu_s"] == 30.0
    assert report["figures"]["planning_cpu_s"] == pytest.approx(0.001)
    assert report["figures"]["env_steps_per_s"] == pytest.approx(600.0)
    assert report["figures"]["env_ratio_to_raw"] == pytest.approx(0.8)
    assert report["figures"]["async2_speedup"] == pytest.approx(1.8)
    assert report["figures"]["session_sim_s_per_cpu_s_depth"] == pytest.approx(5.0)
    assert report["figures"]["timing_session_cpu_s"] == pytest.approx(0.005)
    assert report["figures"]["depth_frame_cpu_s"] is None
    assert report["room_ms_per_frame"]["planning"] == pytest.approx(0.09 / 90 / 30 * 1000)
    assert {"machine", "versions", "command"} <= set(report)
    assert main(benchmark.command, []) == 0
