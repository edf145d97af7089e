"""Flags of dataclasses: their order, their help, and the values that come back."""

from __future__ import annotations

import dataclasses
import re
import sys
import types
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import pytest

from sjasim.commands.flags import INLINE, Metavar, attribute_texts
from sjasim.commands.options import UsageError, parse
from sjasim.commands.session_options import parse_session, value_of
from sjasim.config import SessionConfig
from sjasim.core.errors import ConfigError


@dataclass(frozen=True)
class Motor:
    """A motor.

    Attributes:
        speed_m_s: how fast it
            goes, in ``m/s``.
        gear: which gear.
    """

    speed_m_s: float = 0.25
    gear: int = 1


@dataclass(frozen=True)
class Options:
    """Options.

    Attributes:
        motor: the motor.
        common: what has no prefix.
        out: where to write.
        mode: which way.
        names: of whom.
        extra: without a flag.
    """

    motor: Motor = field(default_factory=Motor)
    common: Annotated[Motor, INLINE] = field(default_factory=Motor)
    out: Annotated[Path | None, Metavar("DIR")] = None
    mode: Literal["fast", "slow"] = "fast"
    names: tuple[str, ...] = ()
    extra: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class SessionOptions:
    """Options with a session's configuration.

    Attributes:
        session: the configuration.
        config: a file.
    """

    session: Annotated[SessionConfig, INLINE]
    config: Path | None = None


@dataclass(frozen=True)
class OwnConfig:
    """Options of a plug-in.

    Attributes:
        gain: how strongly it reacts.
        label: what it is called.
        limit: largest value, if any.
    """

    gain: float = 1.5
    label: str = "own"
    limit: float | None = None
    table: Mapping[str, int] = field(default_factory=dict)


class Own:
    """A plug-in."""

    config_type = OwnConfig


@pytest.fixture
def own_method(monkeypatch):
    """Name of a plug-in that stands in a module of its user's."""
    module = types.ModuleType("somebody_elses")
    module.Own = Own
    monkeypatch.setitem(sys.modules, "somebody_elses", module)
    return "somebody_elses:Own"


def session(*arguments):
    """The configuration that a command line describes."""
    return parse_session(SessionOptions, arguments, "prog", "About.").session


def help_of(capsys, call):
    """What ``--help`` prints."""
    with pytest.raises(SystemExit) as end:
        call()
    assert end.value.code == 0
    return capsys.readouterr().out


def test_values_come_back_as_the_dataclass():
    assert parse(Options, [], None, "prog", "About.") == Options()
    arguments = ["--motor.gear", "3", "--speed-m-s", "0.5", "--out", "here", "--mode", "slow", "--names", "a", "b"]
    found = parse(Options, arguments, None, "prog", "About.")
    assert found == Options(Motor(gear=3), Motor(0.5), Path("here"), "slow", ("a", "b"))


def test_defaults_may_be_an_instance():
    default = Options(Motor(gear=5), extra={"a": 1.0})
    assert parse(Options, ["--gear", "2"], default, "prog", "About.") == dataclasses.replace(
        default, common=Motor(gear=2)
    )


def test_texts_of_a_docstring_become_one_line_without_backticks():
    assert attribute_texts(Motor) == {"speed_m_s": "how fast it goes, in m/s.", "gear": "which gear."}


def test_the_help_names_units_metavars_and_defaults(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    about = "A long description of what the command does that needs more than one line of a terminal, which is why."
    text = help_of(capsys, lambda: parse(Options, ["--help"], None, "prog", about))
    assert "--motor.speed-m-s FLOAT" in text
    assert "(default: 0.25)" in text
    assert "--out DIR" in text
    assert "None" not in text
    assert "extra" not in text
    assert max(map(len, text.splitlines())) <= 80


def test_the_main_options_come_first(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    first = ("method", "humans", "config")
    text = help_of(capsys, lambda: parse_session(SessionOptions, ["--help"], "prog", "About.", first))
    lines = [line.lstrip("│ ") for line in text.splitlines()]  # without the frame, if there is one
    flags = [line.split()[0] for line in lines if re.match(r"--\w", line)]
    assert flags[:4] == ["--method", "--humans", "--config", "--seed"]
    assert " method options " in text
    assert text.index(" method options ") < text.index(" scene options ")


@pytest.mark.parametrize("method", ["sia", "eca"])
def test_the_options_of_a_method_are_flags(method, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = help_of(capsys, lambda: session("--method", method, "--help"))
    assert "--method-options.epsilon-s FLOAT" in text
    assert ("--method-options.window-s FLOAT" in text) == (method == "sia")
    assert session("--method", method, "--method-options.epsilon-s", "1.2").method_options == {"epsilon_s": 1.2}
    assert session("--method", method).method_options == {}


def test_the_options_of_a_plug_in_are_flags(own_method, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = help_of(capsys, lambda: session("--method", own_method, "--help"))
    assert "how strongly it reacts. (default: 1.5)" in text
    assert "method-options.table" not in text
    given = ("--method-options.gain", "2", "--method-options.limit", "0.5")
    assert session("--method", own_method, *given).method_options == {"gain": 2.0, "limit": 0.5}


def test_options_of_a_file_stay_and_flags_override_them(own_method, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(f'method = "{own_method}"\nmethod_options = {{gain = 1.5, label = "x"}}\n', encoding="utf-8")
    assert session("--config", str(path)).method_options == {"gain": 1.5, "label": "x"}
    changed = session("--config", str(path), "--method-options.label", "y")
    assert changed.method_options == {"gain": 1.5, "label": "y"}
    path.write_text(f'method = "{own_method}"\nmethod_options = {{gain = "much"}}\n', encoding="utf-8")
    with pytest.raises(ConfigError, match=r"method_options\.gain = 'much' is not allowed: a number"):
        session("--config", str(path))


def test_a_session_without_a_robot_has_no_options_of_a_method():
    assert session("--method", "none").method == "none"
    with pytest.raises(UsageError, match=r"--method-options\.window-s"):
        session("--method", "none", "--method-options.window-s", "1")


def test_the_last_value_of_a_flag_counts():
    assert value_of("method", ["--method", "eca", "--method=sia", "--seed", "3"]) == "sia"
    assert value_of("method", ["--seed", "3", "--method"]) is None
