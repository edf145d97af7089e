"""Events in recorded joints: frame rates, missing frames and joints, files, the command."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import sjasim
from sjasim import detect
from sjasim.assets.names import JOINTS
from sjasim.commands.main import main
from sjasim.core import Kind
from sjasim.core.errors import RecordError
from sjasim.sensors.recordings.detect import Detected

from ..scripted import Match, Script, ScriptedView, Walk, match_events

WALKS = [Walk(2.0 + 8.0 * k, 1.6, 0.5) for k in range(6)] + [Walk(5.0 + 8.0 * k, 1.8, -0.5) for k in range(6)]
SCRIPT = Script((0.0, 0.2), walks=WALKS, claps=[8.4 + 8.0 * k for k in range(6)])
END_S = 52.0


def recorded_joints(times: np.ndarray, drift_m: float = 0.0, seed: int = 0) -> np.ndarray:
    """(T, 1, 25, 3) joints of the script as the north sensor sees them, with errors of a correlation time of 3.3 s."""
    view = ScriptedView([SCRIPT])
    rng = np.random.default_rng(seed)
    joints = np.stack([view.sensor_joints(float(t)) for t in times])
    error = drift_m * rng.standard_normal(joints.shape[1:])
    for index in range(len(times)):
        kept = math.exp(-(times[index] - times[index - 1]) / 3.3) if index else 1.0
        error = kept * error + drift_m * math.sqrt(1 - kept**2) * rng.standard_normal(error.shape)
        joints[index] += error
    return joints


def match_script(found: list[Detected]) -> Match:
    """Match detected regular events to those of the script."""
    events = [(event.t_s, event.kind) for event in found if not event.early]
    return match_events(events, SCRIPT.events(), 0.1, 0.5)


@pytest.mark.parametrize("rate_hz", [15.0, 25.0, 30.0, 60.0])
def test_any_frame_rate_gives_every_event_once(rate_hz: float):
    times = np.arange(0.0, END_S, 1.0 / rate_hz)
    found = sjasim.detect_events(times, recorded_joints(times, 0.005))
    match = match_script(found)
    assert (match.missed, match.false) == (0, 0)
    starts = [one.t_s for one in found if one.early and one.kind is Kind.START_FORWARD]
    assert len(starts) >= 5


@pytest.mark.parametrize("drift_m", [0.01, 0.02])
def test_few_events_are_missed_or_false_with_drift_uneven_times_and_a_fifth_of_the_frames_lost(drift_m: float):
    missed = 0
    false = 0
    for seed in range(3):
        rng = np.random.default_rng(100 + seed)
        times = np.arange(0.0, END_S, 1.0 / 30.0)
        times = times[rng.random(len(times)) > 0.2]
        times = times + rng.uniform(-0.008, 0.008, len(times))
        match = match_script(sjasim.detect_events(times, recorded_joints(times, drift_m, seed)))
        missed += match.missed
        false += match.false
    assert missed <= 1
    assert false <= 1


def test_inferred_joints_give_moves_but_no_claps_and_no_early_events():
    times = np.arange(0.0, END_S, 1.0 / 30.0)
    found = sjasim.detect_events(times, recorded_joints(times), np.ones((len(times), 1, 25), dtype=int))
    assert {one.kind for one in found} == set(Kind) - {Kind.CLAP, Kind.TURN}
    assert not [one for one in found if one.early]


def test_a_person_who_disappears_has_no_events_and_does_not_change_those_of_others():
    times = np.arange(0.0, END_S, 1.0 / 30.0)
    two = np.concatenate([recorded_joints(times)] * 2, axis=1)
    two[300:, 1] = np.nan
    found = sjasim.detect_events(times, two, persons=[7, 3])
    match = match_script([one for one in found if one.person == 7])
    assert (match.missed, match.false) == (0, 0)
    assert max(one.t_s for one in found if one.person == 3) < 10.0


@pytest.mark.parametrize(
    ("times", "shape", "words"),
    [([0.0, 0.1], (3, 1, 25, 3), "shape"), ([0.0, 0.0], (2, 1, 25, 3), "rise"), ([0.0, 0.1], (2, 1, 20, 3), "shape")],
)
def test_arrays_that_do_not_fit_together_raise(times, shape, words):
    with pytest.raises(RecordError, match=words):
        sjasim.detect_events(times, np.zeros(shape))


def write(path, until_s=12.0, state="tracked"):
    times = np.arange(0.0, until_s, 1.0 / 30.0)
    joints = recorded_joints(times)[:, 0]
    lines = ["t_s,person,joint,x_m,y_m,z_m,state"]
    for t_s, points in zip(times, joints, strict=True):
        lines += [f"{t_s:.4f},4,{name},{x:.5f},{y:.5f},{z:.5f},{state}"
                  for name, (x, y, z) in zip(JOINTS, points, strict=True)]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_file_gives_the_same_events(tmp_path, capsys):
    file = write(tmp_path / "joints.csv")
    assert main(detect.command, [str(file), "--json"]) == 0
    events = json.loads(capsys.readouterr().out)["events"]
    assert [one["kind"] for one in events if not one["early"]] == [
        "start_forward", "stop_forward", "start_backward", "stop_backward", "clap", "start_forward", "stop_forward",
    ]  # fmt: skip
    assert {(one["session"], one["iteration"], one["agent"]) for one in events} == {("joints", 0, 4)}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [("SpineMid", "Belly", "line 3, joint: 'Belly'"), (",tracked", ",perhaps", "line 2, state: 'perhaps'"),
     ("x_m", "x", "no column x_m"), ("0.0000,4", "soon,4", "line 2, t_s: 'soon'"),
     ("0.0000,4,SpineMid", "0.0000,4,SpineBase", "line 3, joint")],
)  # fmt: skip
def test_an_error_in_a_file_is_one_line_with_its_place(tmp_path, capsys, old, new, words):
    file = write(tmp_path / "joints.csv", 0.2)
    file.write_text(file.read_text().replace(old, new, 1))
    assert main(detect.command, [str(file)]) == 2
    message = capsys.readouterr().err
    assert words in message
    assert message.count("\n") == 1


def test_a_file_without_events_says_so_on_stderr(tmp_path, capsys):
    file = tmp_path / "still.csv"
    file.write_text("t_s,person,joint,x_m,y_m,z_m\n0.0,1,SpineBase,0,0,2\n0.1,1,SpineBase,0,0,2\n")
    assert main(detect.command, [str(file)]) == 0
    output = capsys.readouterr()
    assert output.out == "session,iteration,agent,kind,t_s,early,t_onset_s\n"
    assert output.err.splitlines() == [
        "warning: person 1: no events can be found: none of 2 frames has both hips (HipLeft, HipRight)",
        "warning: person 1: no claps can be found: none of 2 frames has two tracked hands (HandLeft, HandRight)",
        "warning: no events in 2 frames of 1 person",
    ]
