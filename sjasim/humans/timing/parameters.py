"""Parameters of the ensemble timing model: values, checks, presets and parameter files."""

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
"""Number of dancers to which a single coupling gain refers; larger and smaller groups correct as much in all
(assumed)."""


@dataclass(frozen=True, slots=True)
class TimingParameters:
    """Parameters of `EnsembleTiming`.

    Tuples hold a value for the first, second, ... dancer; dancers beyond their end have the neutral value.

    Attributes:
        timekeeper_s: standard deviation of the timekeeper noise of each event [s].
        motor_s: standard deviation of the motor noise, which later events do not inherit [s].
        common_s: standard deviation of the group's common shift [s].
        common_correlation: correlation of the common shift from one event to the next.
        coupling: phase correction gain: the share of the asynchrony with each other dancer that a dancer corrects at
            each event. A single number refers to a group of three; other groups then correct as much in all. A matrix
            has a row for each dancer and a column for each dancer that it corrects towards; its diagonal is ignored.
            Asynchronies must not grow under the gains.
        correction: factor of each dancer's own gains; 0 makes a leader who does not correct.
        robot_coupling: share of the asynchrony with the robot that dancers correct at each move: one value for all, or
            one for each.
        music_coupling: share of the asynchrony with the music that a dancer corrects at each event.
        anticipation: share of a tempo change that dancers foresee; with 0 they expect the tempo of the last interval.
        group_spread: standard deviation of the logarithm of the noise scale, from group to group.
        dancer_spread: the same, from dancer to dancer.
        iteration_spread: the same, from iteration to iteration.
        scale: factor of each dancer's noise.
        entrainment: exponent of the robot's last timing error in the dancers' noise scale.
        lapse: probability that a dancer leaves out a phrase (forward and backward) or a clap.
        late_s: constant lateness of each dancer [s].
        drift: relative slowness of each dancer's own tempo; .01 falls behind by 10 ms per second unless corrected.
        about: source of the values.
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
                _check_range(name, item, low, high)

        if not isinstance(self.coupling, tuple):
            _check_range("coupling", self.coupling, 0.0, 0.6)
        elif any(not isinstance(row, tuple) or len(row) != len(self.coupling) for row in self.coupling):
            raise ConfigError("humans.coupling", self.coupling, "a number, or as many rows as columns")
        else:
            for gain in (gain for row in self.coupling for gain in row):
                _check_range("coupling", gain, -1.0, 1.0)
            # Raises where asynchronies would grow; a single number is checked once the group's size is known.
            self.transition_matrix(len(self.coupling))

    def per_dancer(self, name: str, dancers: int, neutral: float) -> Array:
        """(D,) values of a field for every dancer.

        Args:
            name: the field; where it holds a single number, all dancers have it.
            dancers: how many.
            neutral: value of the dancers beyond the end of the field's tuple.
        """
        value = getattr(self, name)
        if not isinstance(value, tuple):
            return np.full(dancers, float(value))

        out = np.full(dancers, neutral)
        given = value[:dancers]
        out[: len(given)] = given
        return out

    def coupling_gains(self, dancers: int) -> Array:
        """(D, D) share of the asynchrony with each other dancer (column) that each dancer (row) corrects at an event.

        The diagonal is 0.

        Raises:
            ConfigError: the coupling matrix is for another number of dancers.
        """
        if isinstance(self.coupling, tuple):
            if len(self.coupling) != dancers:
                allowed = f"{dancers} rows of {dancers} for a group of {dancers}, or a single number"
                raise ConfigError("humans.coupling", self.coupling, allowed)
            matrix = np.array(self.coupling, dtype=np.float64)
        else:
            matrix = np.full((dancers, dancers), self.coupling * REFERENCE_GROUP_SIZE / dancers)

        np.fill_diagonal(matrix, 0.0)
        return np.asarray(self.per_dancer("correction", dancers, 1.0)[:, None] * matrix)

    def transition_matrix(self, dancers: int) -> Array:
        """(D, D) matrix that maps own deviations at one event to those at the next, without the robot and noise.

        Raises:
            ConfigError: the coupling matrix has another size, or asynchronies would grow from event to event.
        """
        gains = self.coupling_gains(dancers)
        matrix = np.eye(dancers) + gains - np.diag(gains.sum(axis=1) + self.music_coupling)

        robot_gains = self.per_dancer("robot_coupling", dancers, 0.0)
        for name, gain in (("coupling", np.zeros(dancers)), ("robot_coupling", robot_gains)):
            growth = float(np.abs(np.linalg.eigvals(matrix - np.diag(gain))).max())
            # The tolerance admits the eigenvalue 1 of a group that nothing ties to the music.
            if growth > 1.0 + 1e-9:
                allowed = f"gains under which differences die out (largest eigenvalue at most 1, not {growth:.2f})"
                raise ConfigError(f"humans.{name}", getattr(self, name), allowed)

        return np.asarray(matrix)


_RANGES: Mapping[str, tuple[float, float]] = {
    **dict.fromkeys(("timekeeper_s", "motor_s", "common_s"), (0.0, 5.0)),
    **dict.fromkeys(("group_spread", "dancer_spread", "iteration_spread", "entrainment"), (0.0, 5.0)),
    **dict.fromkeys(("correction", "robot_coupling", "music_coupling", "anticipation", "lapse"), (0.0, 1.0)),
    "common_correlation": (0.0, 0.999),
    "scale": (0.0, 10.0),
    "late_s": (-5.0, 5.0),
    "drift": (-0.2, 0.2),
}
"""Field -> least and largest allowed value."""


def _check_range(name: str, value: object, low: float, high: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ConfigError(f"humans.{name}", value, f"a number from {low:g} to {high:g}")


def preset_names() -> tuple[str, ...]:
    """Names of the presets that ship with sjasim."""
    return tuple(_presets())


def preset(name: str) -> TimingParameters:
    """Parameters of a preset.

    Raises:
        UnknownNameError: no preset has the name.
    """
    table = _presets()
    if name not in table:
        raise UnknownNameError("humans preset", name, (*table, "FILE.toml", "replay:FILE"))

    return _parameters(table[name], f"humans.{name}")


def read_parameters(path: Path) -> TimingParameters:
    """Parameters from a TOML file of `TimingParameters` fields, as ``python -m sjasim.calibrate`` writes it.

    Raises:
        ConfigError: the file cannot be read, is not TOML, or has a wrong field.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError("humans", str(path), f"a readable TOML file ({error.strerror or error})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError("humans", str(path), f"a TOML file ({error})") from error

    return _parameters(data, f"humans ({path})")


def _parameters(data: Mapping[str, Any], where: str) -> TimingParameters:
    """Parameters from plain data; ``where`` names its origin in messages."""
    known = {field.name for field in fields(TimingParameters)}
    unknown = sorted(data.keys() - known)
    if unknown:
        raise ConfigError(f"{where}.{unknown[0]}", data[unknown[0]], f"no such field; known are {', '.join(known)}")

    return TimingParameters(**{key: _as_tuples(value) for key, value in data.items()})


def _as_tuples(value: Any) -> Any:
    """The value with lists, also nested ones, made tuples."""
    return tuple(_as_tuples(item) for item in value) if isinstance(value, list) else value


def _presets() -> dict[str, dict[str, Any]]:
    text = resources.files("sjasim.assets").joinpath("presets.toml").read_text("utf-8")
    return tomllib.loads(text)
