"""Parameters of the human timing model: checks, presets, files of own presets."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ...core import Array
from ...core.errors import ConfigError, UnknownNameError

REFERENCE_GROUP_SIZE = 3
"""The size of group for which a single coupling is meant; others correct as much in all (assumed)."""


@dataclass(frozen=True, slots=True)
class TimingParameters:
    """Parameters of the human timing model. Lists are of the first, second, ... dancer; who is not named is neutral.

    Attributes:
        timekeeper_s: standard deviation of each event's own timekeeper noise.
        motor_s: standard deviation of the noise that is not carried on.
        common_s: standard deviation of the group's common shift.
        common_correlation: correlation of that shift from event to event.
        coupling: share of its lead over each other dancer that a dancer gives up per event. One number is for a group
            of three; larger and smaller groups then correct as much in all. Or a row per dancer, a column per dancer
            it corrects towards; the diagonal says nothing. Differences must not grow by it.
        correction: factor of each dancer's own corrections towards the others; 0 leads without looking.
        robot_coupling: share of its lead over the robot that a dancer gives up per move, of all or of each dancer.
        music_coupling: share of its lead over the music that a dancer gives up per event.
        anticipation: how much of a change of tempo is foreseen: 1 all of it, 0 expects the tempo of the last interval.
        group_spread: log standard deviation of a group's noise scale.
        dancer_spread: the same from dancer to dancer.
        iteration_spread: the same from iteration to iteration.
        scale: factor of each dancer's own noise.
        entrainment: exponent of the robot's last timing error in the dancers' own noise.
        lapse: probability that a dancer leaves out a phrase (forward and backward) or a clap.
        late_s: constant lateness of each dancer.
        drift: by how much each dancer's own tempo is slow; .01 falls 10 ms behind per second unless corrected.
        about: where the values come from.
    """

    timekeeper_s: float = 0.0
    motor_s: float = 0.0
    common_s: float = 0.0
    common_correlation: float = 0.0
    coupling: float | tuple[tuple[float, ...], ...] = 0.0
    correction: tuple[float, ...] = ()
    robot_coupling: float | tuple[float, ...] = 0.0
    music_coupling: float = 0.0
    anticipation: float = 1.0
    group_spread: float = 0.0
    dancer_spread: float = 0.0
    iteration_spread: float = 0.0
    scale: tuple[float, ...] = ()
    entrainment: float = 0.0
    lapse: float = 0.0
    late_s: tuple[float, ...] = ()
    drift: tuple[float, ...] = ()
    about: str = ""

    def __post_init__(self) -> None:
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            for item in value if isinstance(value, tuple) else (value,):
                _within(name, item, low, high)
        if not isinstance(self.coupling, tuple):
            _within("coupling", self.coupling, 0.0, 0.6)
        elif any(not isinstance(row, tuple) or len(row) != len(self.coupling) for row in self.coupling):
            raise ConfigError("humans.coupling", self.coupling, "a number, or as many rows as columns")
        else:
            for gain in (gain for row in self.coupling for gain in row):
                _within("coupling", gain, -1.0, 1.0)
            self.transition(len(self.coupling))

    def each(self, name: str, dancers: int, neutral: float) -> Array:
        """(D,) values of a per-dancer field; one number counts for all."""
        value = getattr(self, name)
        if not isinstance(value, tuple):
            return np.full(dancers, float(value))
        out = np.full(dancers, neutral)
        given = value[:dancers]
        out[: len(given)] = given
        return out

    def coupling_gains(self, dancers: int) -> Array:
        """(D, D) share of its lead over each other dancer that each dancer gives up per event; diagonal 0.

        Raises:
            ConfigError: a coupling matrix is for another number of dancers.
        """
        if isinstance(self.coupling, tuple):
            if len(self.coupling) != dancers:
                allowed = f"{dancers} rows of {dancers} for a group of {dancers}, or a single number"
                raise ConfigError("humans.coupling", self.coupling, allowed)
            matrix = np.array(self.coupling, dtype=np.float64)
        else:
            matrix = np.full((dancers, dancers), self.coupling * REFERENCE_GROUP_SIZE / dancers)
        np.fill_diagonal(matrix, 0.0)
        return np.asarray(self.each("correction", dancers, 1.0)[:, None] * matrix)

    def transition(self, dancers: int) -> Array:
        """(D, D) own deviations of one event from those of the event before, the robot left out.

        Raises:
            ConfigError: the matrix has another size, or differences would grow from event to event.
        """
        gains = self.coupling_gains(dancers)
        matrix = np.eye(dancers) + gains - np.diag(gains.sum(axis=1) + self.music_coupling)
        for name, pull in (("coupling", np.zeros(dancers)), ("robot_coupling", self._pulls(dancers))):
            growth = float(np.abs(np.linalg.eigvals(matrix - np.diag(pull))).max())
            if growth > 1.0 + 1e-9:
                allowed = f"gains under which differences die out (largest eigenvalue at most 1, not {growth:.2f})"
                raise ConfigError(f"humans.{name}", getattr(self, name), allowed)
        return np.asarray(matrix)

    def _pulls(self, dancers: int) -> Array:
        return self.each("robot_coupling", dancers, 0.0)


_RANGES: Mapping[str, tuple[float, float]] = {
    **dict.fromkeys(("timekeeper_s", "motor_s", "common_s"), (0.0, 5.0)),
    **dict.fromkeys(("group_spread", "dancer_spread", "iteration_spread", "entrainment"), (0.0, 5.0)),
    **dict.fromkeys(("correction", "robot_coupling", "music_coupling", "anticipation", "lapse"), (0.0, 1.0)),
    "common_correlation": (0.0, 0.999),
    "scale": (0.0, 10.0),
    "late_s": (-5.0, 5.0),
    "drift": (-0.2, 0.2),
}
"""Field -> least and largest value."""


def _within(name: str, value: object, low: float, high: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ConfigError(f"humans.{name}", value, f"a number from {low:g} to {high:g}")


def preset_names() -> tuple[str, ...]:
    """Names of the presets that ship with sjasim."""
    return tuple(_presets())


def preset(name: str) -> TimingParameters:
    """Parameters of a preset.

    Raises:
        UnknownNameError: there is no such preset.
    """
    table = _presets()
    if name not in table:
        raise UnknownNameError("humans preset", name, (*table, "FILE.toml", "replay:FILE"))
    return _parameters(table[name], f"humans.{name}")


def read_parameters(path: Path) -> TimingParameters:
    """Parameters from a TOML file of `TimingParameters`' fields, as `python -m sjasim.calibrate` writes it.

    Raises:
        ConfigError: the file cannot be read, is not TOML, or holds a wrong field.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError("humans", str(path), f"a readable TOML file ({error.strerror or error})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError("humans", str(path), f"a TOML file ({error})") from error
    return _parameters(data, f"humans ({path})")


def _parameters(data: Mapping[str, Any], where: str) -> TimingParameters:
    known = {field.name for field in fields(TimingParameters)}
    unknown = sorted(data.keys() - known)
    if unknown:
        raise ConfigError(f"{where}.{unknown[0]}", data[unknown[0]], f"no such field; known are {', '.join(known)}")
    return TimingParameters(**{key: _frozen(value) for key, value in data.items()})


def _frozen(value: Any) -> Any:
    return tuple(_frozen(item) for item in value) if isinstance(value, list) else value


def _presets() -> dict[str, dict[str, Any]]:
    text = resources.files("sjasim.assets").joinpath("presets.toml").read_text("utf-8")
    return tomllib.loads(text)
