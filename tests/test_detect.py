"""The command `detect` on a laboratory's files: warnings, refused units, and a table that `calibrate` reads."""

from __future__ import annotations

import csv
import io
import json
import re

import numpy as np
import pytest

from sjasim import calibrate, detect
from sjasim.assets.names import JOINT_INDEX, JOINTS
from sjasim.commands.main import main
from sjasim.sensors.recordings.detect import recording
from sjasim.sensors.recordings.validation import quality_warnings

from .sensors.recordings.scripted_recordings import Defects, record

STILL = Defects(bias_m=0.0, drift_m=0.0, white_m=0.001, away_s=(0.0, 0.0))


def write(path, times, joints):
    """A table of what is known, persons from 1 on, times to a tenth of a millisecond."""
    lines = ["t_s,person,joint,x_m,y_m,z_m"]
    for t_s, frame in zip(times, joints, strict=True):
        for person, points in enumerate(frame, start=1):
            lines += [f"{t_s:.4f},{person},{name},{x:.4f},{y:.4f},{z:.4f}"
                      for name, (x, y, z) in zip(JOINTS, points, strict=True) if np.isfinite(x)]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def run(capsys, *arguments: str):
    code = main(detect.command, arguments)
    said = capsys.readouterr()
    return code, said.out, said.err


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return write(tmp_path_factory.mktemp("lab") / "trio.csv", *record(STILL, 0))


def test_the_table_is_one_that_calibrate_takes(file, tmp_path, capsys):
    code, out, err = run(capsys, file)
    assert (code, err) == (0, "")
    rows = list(csv.DictReader(io.StringIO(out)))
    assert {(row["session"], row["iteration"]) for row in rows} == {("trio", "0")}
    assert all(len(row["t_s"].partition(".")[2]) <= 6 for row in rows)
    assert all((row["t_onset_s"] == "") == (row["early"] == "True") for row in rows)
    table = tmp_path / "events.csv"
    table.write_text(out)
    assert main(calibrate.command, [str(table), "--time", "free", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["agents"] == ["1", "2"]


def test_iterations_start_when_they_are_said_to(file, capsys):
    _, out, err = run(capsys, file, "--session", "group 3", "--iteration-starts-s", "9.5", "25.5", "--json")
    rows = json.loads(out)["events"]
    assert {row["session"] for row in rows} == {"group 3"}
    assert all(row["iteration"] == int(row["t_s"] >= 25.5) and row["t_s"] >= 9.5 for row in rows)
    assert "events before the first iteration starts" in err
    code, _, err = run(capsys, file, "--iteration-starts-s", "5", "5")
    assert (code, err.count("\n")) == (2, 1)
    assert "times that rise" in err


@pytest.mark.parametrize(
    ("metres", "seconds", "words"),
    [
        (1000.0, 1.0, "bodies are 1,5[0-9][0-9] m large, wanted 0.05 to 3 m: joints in metres"),
        (0.01, 1.0, "bodies are 0.01[0-9]* m large"),
        (1.0, 1000.0, "frames are 33.[0-9] s apart, wanted 0.001 to 1 s: times in seconds,"),
        (1.0, 1e-3, "frames are 3.3[0-9]*e-05 s apart"),
    ],
)
def test_other_units_are_refused_in_a_line(tmp_path, capsys, metres, seconds, words):
    times, joints = record(STILL, 0, until_s=3.0)
    path = tmp_path / "joints.csv"
    lines = ["t_s,person,joint,x_m,y_m,z_m"]
    for t_s, frame in zip(times * seconds, joints * metres, strict=True):
        lines += [f"{t_s:.9f},1,{k},{x:.6f},{y:.6f},{z:.6f}" for k, (x, y, z) in enumerate(frame[0])]
    path.write_text("\n".join(lines) + "\n")
    code, out, err = run(capsys, str(path))
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert re.search(words, err)


def doubted(change, defects: Defects = STILL) -> list[str]:
    times, joints = record(defects, 0, until_s=12.0)
    change(joints)
    return [line for line in quality_warnings(recording(times, joints)) if line.startswith("person 1")]


def test_what_hides_events_is_said_of_whom():
    def half_the_hands(joints):
        joints[::2, 1, JOINT_INDEX["HandLeft"]] = 0.0  # some trackers write the sensor's own place

    def no_hip(joints):
        joints[:, 1, JOINT_INDEX["HipRight"]] = np.nan

    def gone(joints):
        joints[:, 1] = np.nan

    assert doubted(lambda joints: None) == []
    assert doubted(half_the_hands)[0].startswith("person 1: 50.0% of")
    assert doubted(half_the_hands)[0].endswith(
        "lack two tracked hands (HandLeft, HandRight): claps in them may be missed"
    )
    assert doubted(no_hip)[0].startswith("person 1: no events can be found: none of")
    assert doubted(gone) == ["person 1 is in no frame"]
    assert "SpineBase has a speed noise of 0.1" in doubted(lambda joints: None, Defects(white_m=0.01))[0]


@pytest.mark.parametrize(
    ("signs", "words"),
    [((1, -1, 1), "y must point up"), ((1, 1, -1), "z must point away"), ((-1, 1, 1), "x must point to its left")],
)
def test_axes_that_are_not_the_kinects_are_noticed(signs, words):
    def turned(joints):
        joints *= np.array(signs)

    assert words in doubted(turned)[0]
