"""Statistics of the event-level world: the shipped file, files of users, and what is wrong with them."""

from __future__ import annotations

import tomllib
from importlib import resources

import numpy as np
import pytest

from sjasim.core import Kind
from sjasim.core.errors import ConfigError
from sjasim.session.timing_statistics import (
    DETECTED_KINDS,
    MEASURED,
    QUANTILES,
    ROBOT_KINDS,
    DelayStatistics,
    timing_statistics,
)


def shipped() -> str:
    return resources.files("sjasim.assets").joinpath("timing_statistics.toml").read_text("utf-8")


@pytest.mark.parametrize("layout", ["square", "rows", "custom"])
@pytest.mark.parametrize("sensing", ["joints", "depth"])
def test_the_shipped_statistics_are_plausible(sensing, layout):
    found = timing_statistics(MEASURED, sensing, layout)
    assert tuple(found.regular) == DETECTED_KINDS
    assert tuple(found.robot) == ROBOT_KINDS
    for kind, early in found.early.items():
        assert np.median(early.delay_s) < np.median(found.regular[kind].delay_s)
    assert all(0.05 < np.median(item.delay_s) < 0.4 for item in (*found.regular.values(), *found.robot.values()))
    assert all(item.missed < 0.4 for item in (*found.regular.values(), *found.early.values()))


def test_the_file_says_how_it_was_made():
    head = [line for line in shipped().splitlines() if line.startswith("#")]
    assert any("sjasim.characterise" in line for line in head)
    assert any("write_timing_statistics" in line for line in head)


@pytest.mark.parametrize("share", [0.0, 0.03, 0.5, 0.777, 1.0])
def test_delays_are_interpolated_between_quantiles(share):
    delay_s = np.sort(np.random.default_rng(0).normal(size=len(QUANTILES)))
    assert DelayStatistics(0.0, delay_s).delay_at(share) == pytest.approx(np.interp(share, QUANTILES, delay_s))


def test_a_file_of_ones_own_is_read_anew(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(shipped())
    before = timing_statistics(str(path), "joints", "square").regular[Kind.CLAP].missed
    path.write_text(shipped().replace("[joints.square.regular.clap]", "[joints.square.regular.other]") + CLAP)
    assert timing_statistics(str(path), "joints", "square").regular[Kind.CLAP].missed == 0.5 != before


CLAP = f"""
[joints.square.regular.clap]
missed = 0.5
delay_s = {[0.1] * len(QUANTILES)}
"""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "sensing"),
        ("[joints", "TOML"),
        (shipped().replace("[robot.turn]", "[robot.spin]"), "robot.turn"),
        (shipped().replace("[joints.square.early.stop_forward]", "[joints.square.early.stop]"), "early.stop_forward"),
        (shipped() + "[joints.square.extra]\n", ""),
    ],
)
def test_a_wrong_file_is_refused_with_the_field(tmp_path, text, message):
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    if not message:
        assert timing_statistics(str(path), "joints", "square")
        return
    with pytest.raises(ConfigError, match=message):
        timing_statistics(str(path), "joints", "square")


@pytest.mark.parametrize(
    ("value", "message"),
    [("missed = 1.5", "missed"), ("missed = 0.0\ndelay_s = [1.0]", "delay_s"), ("missed = true", "missed")],
)
def test_a_wrong_value_is_refused_with_its_name(tmp_path, value, message):
    data = tomllib.loads(shipped())
    assert "clap" in data["joints"]["square"]["regular"]
    path = tmp_path / "wrong.toml"
    removed = shipped().split("[joints.square.regular.clap]")
    rest = removed[1].split("\n\n", 1)[1]
    path.write_text(f"{removed[0]}[joints.square.regular.clap]\n{value}\n\n{rest}")
    with pytest.raises(ConfigError, match=rf"regular.clap.{message}"):
        timing_statistics(str(path), "joints", "square")


def test_a_missing_file_is_named():
    with pytest.raises(ConfigError, match=r"nowhere\.toml"):
        timing_statistics("nowhere.toml", "joints", "square")
