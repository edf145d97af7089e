"""A wrong command line gives one line on stderr, exit code 2, and nothing on disk."""

import os

import pytest

from sjasim import run
from sjasim.commands.main import main

BAD = {
    "unknown method": (["--method", "sai"], "sia"),
    "unknown humans": (["--humans", "tired"], "FILE.toml, replay:FILE, or module:Name"),
    "unknown sensing": (["--sensing", "sonar"], "joints"),
    "unknown dance": (["--dance.name", "tango"], "paper"),
    "negative time": (["--dance.tail-s", "-3"], "dance.tail_s"),
    "sensors out of range": (["--scene.sensor-distance-m", "6"], "scene.sensor_distance_m"),
    "too many people": (["--dancers", "9"], "dancers"),
    "unknown fault target": (["--config", "{here}/fault.toml"], "dancer_9"),
    "unknown fault": (["--config", "{here}/meteor.toml"], "dead_sensor"),
    "unreadable configuration": (["--config", "{here}/absent.toml"], "absent.toml"),
    "broken configuration": (["--config", "{here}/broken.toml"], "broken.toml"),
    "a file for a folder": (["--out", "{here}/broken.toml"], "is a file"),
    "a folder that is not empty": (["--out", "{here}"], "not empty"),
    "slots of no layout": (["--scene.slots-m", "0", "1", "1", "0", "0", "0", "1", "1"], "only with layout custom"),
    "a video of another type": (["--video", "{here}/dance.avi"], "ends in .mp4"),
    "a video without a type": (["--video", "{here}/dance"], "ends in .mp4"),
    "no such option": (["--speed", "3"], "--speed"),
}


@pytest.fixture
def here(tmp_path):
    (tmp_path / "broken.toml").write_text("method = ", encoding="utf-8")
    fault = '[[faults]]\nkind = "{}"\ntarget = "{}"\n'
    (tmp_path / "fault.toml").write_text(fault.format("dancer_stops", "dancer_9"), encoding="utf-8")
    (tmp_path / "meteor.toml").write_text(fault.format("meteor", "north"), encoding="utf-8")
    return tmp_path


def refused(arguments, capfd):
    """The one line with which a command line is refused."""
    assert main(run.command, arguments) == 2
    heard = capfd.readouterr()
    assert heard.out == ""
    (line,) = heard.err.splitlines()
    assert line.startswith("error: ")
    return line


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gives_one_clear_line_and_exit_code_2(case, here, capfd):
    arguments, says = BAD[case]
    before = sorted(here.iterdir())
    given = [word.format(here=here) for word in arguments]
    if "--out" not in given:
        given += ["--out", str(here / "session")]
    assert says in refused(given, capfd)
    assert sorted(here.iterdir()) == before


def test_an_unwritable_folder_is_found_before_the_dance(tmp_path, capfd):
    if os.geteuid() == 0:
        assert "/proc/session" in refused(["--out", "/proc/session"], capfd)
        return
    tmp_path.chmod(0o500)
    try:
        assert "session" in refused(["--out", str(tmp_path / "session")], capfd)
    finally:
        tmp_path.chmod(0o700)
    assert list(tmp_path.iterdir()) == []


def test_an_error_in_a_users_own_hook_keeps_its_traceback(tmp_path, monkeypatch, capfd):
    hooks = "".join(f"    def {name}(self, *given): return ()\n" for name in ("reset", "on_event", "on_timer"))
    hooks += (
        "    def on_iteration_start(self, iteration, t_s): return 1 / 0\n    def on_iteration_end(self, *given): pass\n"
    )
    (tmp_path / "of_mine.py").write_text(f"class Broken:\n{hooks}")
    monkeypatch.syspath_prepend(tmp_path)
    assert main(run.command, ["--method", "of_mine:Broken", "--sensing", "joints", "--iterations", "1"]) == 2
    lines = [line for line in capfd.readouterr().err.splitlines() if line]
    # The session has begun, so functions may have been compiled before.
    first, *rest = [line for line in lines if not line.startswith("compiling")]
    assert first.startswith(
        "error: of_mine:Broken.on_iteration_start failed at session time 4.000 s: ZeroDivisionError"
    )
    assert rest[0].startswith("Traceback")
    assert any("of_mine.py" in line for line in rest)
    assert rest[-1].startswith("ZeroDivisionError")
