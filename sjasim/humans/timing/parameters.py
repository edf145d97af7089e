"""Parameters of the ensemble timing model: values, checks, presets and parameter files."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ...config.toml_file import plain_to_toml
from ...core import Array
from ...core.errors import ConfigError, UnknownNameError
from ...core.registry import names

ENSEMBLE = "ensemble"
"""Name of the model that `TimingParameters` and the presets are for, and of files that name no model."""

NOVICES = "novices"
"""Preset of people with an expertise of 0."""

EXPERTS = "musicians"
"""Preset of people with an expertise of 1."""

STABILITY_TOLERANCE = 1e-6
"""Excess of the largest eigenvalue over 1 that counts as rounding.

A group that nothing ties to the music has the eigenvalue 1, and twice so with period correction.
"""


@dataclass(frozen=True, slots=True)
class TimingParameters:
    """Parameters of `EnsembleTiming`.

    Tuples hold a value for the first, second, ... dancer; dancers beyond their end have the neutral value. Only the
    tuple of ``practice`` holds a value for the first, second, ... danced iteration.

    Attributes:
        timekeeper_s: standard deviation of the timekeeper noise of each event [s].
        motor_s: standard deviation of the motor noise [s]. The timekeeper does not inherit it; the dancers observe it
            and correct it like any other asynchrony.
        common_s: standard deviation of the group's common shift [s].
        common_correlation: correlation of the common shift from one event to the next.
        coupling: phase correction gain: the share of the observed asynchrony with each other dancer that a dancer
            corrects at each event (alpha of wing2014), whatever the group's size. One gain for all pairs, or a matrix
            with a row for each dancer and a column for each dancer that it corrects towards; its diagonal is ignored.
            Asynchronies must not grow under the gains: a single gain is at most 2 / D in a group of D dancers.
        period_correction: share of the observed asynchrony with each other dancer by which a dancer changes its tempo,
            for the following intervals as well (beta of vandersteen2013); 0 for phase correction alone.
        correction: factor of each dancer's own gains of both kinds; 0 makes a leader who does not correct.
        robot_coupling: share of the observed asynchrony with the robot that dancers correct at each move: one value for
            all, or one for each.
        music_coupling: share of the asynchrony with the music that a dancer corrects at each event; the music is where
            the group as a whole takes it to be, common shift included.
        anticipation: share of a tempo change that dancers foresee; with 0 they expect the tempo of the last interval.
        group_spread: standard deviation of the logarithm of the noise scale, from group to group.
        dancer_spread: the same, from dancer to dancer.
        iteration_spread: the same, from iteration to iteration.
        scale: factor of each dancer's noise.
        practice: relative decrease of the dancers' own noise, timekeeper and motor, from one danced iteration to the
            next: the same decrease each time, or one for each transition and 0 afterwards. The first danced iteration
            and a rehearsal before it have a factor of 1. Negative values stand for fatigue.
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
    period_correction: float = 0.0
    correction: tuple[float, ...] = ()
    robot_coupling: float | tuple[float, ...] = 0.0
    music_coupling: float = 0.0
    anticipation: float = 1.0
    group_spread: float = 0.0
    dancer_spread: float = 0.0
    iteration_spread: float = 0.0
    scale: tuple[float, ...] = ()
    practice: float | tuple[float, ...] = 0.0
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
            _check_range("coupling", self.coupling, 0.0, 1.0)
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

    def practice_factor(self, iteration: int) -> float:
        """Factor of the dancers' own noise in an iteration; 1 in the rehearsal (0) and the first danced iteration (1).

        Args:
            iteration: index of the iteration.
        """
        transitions = max(iteration - 1, 0)
        if isinstance(self.practice, tuple):
            return float(np.prod([1.0 - decrease for decrease in self.practice[:transitions]]))
        return float((1.0 - self.practice) ** transitions)

    def coupling_gains(self, dancers: int) -> Array:
        """(D, D) share of the asynchrony with each other dancer (column) that each dancer (row) corrects at an event.

        The diagonal is 0. Source: wing2014, eq. (1), where the gains are alpha.

        Raises:
            ConfigError: the coupling matrix is for another number of dancers.
        """
        if isinstance(self.coupling, tuple):
            if len(self.coupling) != dancers:
                allowed = f"{dancers} rows of {dancers} for a group of {dancers}, or a single number"
                raise ConfigError("humans.coupling", self.coupling, allowed)
            matrix = np.array(self.coupling, dtype=np.float64)
        else:
            matrix = np.full((dancers, dancers), float(self.coupling))

        np.fill_diagonal(matrix, 0.0)
        return np.asarray(self.per_dancer("correction", dancers, 1.0)[:, None] * matrix)

    def period_gains(self, dancers: int) -> Array:
        """(D, D) matrix that maps observed deviations to the shortening of each dancer's next interval.

        Source: vandersteen2013 (period correction), applied to each partner as wing2014 does for the phase (assumed).
        """
        gains = np.full((dancers, dancers), self.period_correction)
        np.fill_diagonal(gains, 0.0)
        gains *= self.per_dancer("correction", dancers, 1.0)[:, None]
        return np.asarray(np.diag(gains.sum(axis=1)) - gains)

    def transition_matrix(self, dancers: int) -> Array:
        """(D, D) matrix that maps observed deviations at one event to those expected at the next.

        Neither the robot nor period correction is in it.

        Raises:
            ConfigError: the coupling matrix has another size, or asynchronies would grow from event to event.
        """
        self._check_stability(dancers)
        gains = self.coupling_gains(dancers)
        return np.asarray(np.eye(dancers) + gains - np.diag(gains.sum(axis=1) + self.music_coupling))

    def _check_stability(self, dancers: int) -> None:
        """Raise `ConfigError`, with the largest allowed gains, if asynchronies would grow from event to event."""
        gains = self.coupling_gains(dancers)
        phase = np.diag(gains.sum(axis=1)) - gains
        period = self.period_gains(dancers)
        robot = np.diag(self.per_dancer("robot_coupling", dancers, 0.0))
        music = self.music_coupling * np.eye(dancers)
        none = np.zeros((dancers, dancers))

        # One kind of correction after the other, so that the message names the one that is too strong.
        for name, variable, fixed, of_period in (
            ("coupling", phase, music, none),
            ("robot_coupling", robot, music + phase, none),
            ("period_correction", none, music + phase + robot, period),
        ):
            if _growth(variable + fixed, of_period) <= 1.0 + STABILITY_TOLERANCE:
                continue

            factor = _largest_factor(variable, fixed, of_period)
            value = getattr(self, name)
            most = f"{factor:.3g} times these gains" if isinstance(value, tuple) else f"a gain of {factor * value:.3g}"
            allowed = f"gains under which differences die out: at most {most} for {dancers} dancers"
            raise ConfigError(f"humans.{name}", value, allowed)


def _growth(phase: Array, period: Array) -> float:
    """Largest absolute eigenvalue of the dancers' deviations and tempi, from one event to the next.

    Intervals are taken to be equal.

    Args:
        phase: (D, D) share of each dancer's observed deviation (column) that a dancer (row) corrects in its phase.
        period: (D, D) the same in its period.
    """
    dancers = len(phase)
    unit = np.eye(dancers)
    if not period.any():
        return float(np.abs(np.linalg.eigvals(unit - phase)).max())

    both = np.block([[unit - phase - period, unit], [-period, unit]])
    return float(np.abs(np.linalg.eigvals(both)).max())


def _largest_factor(phase: Array, fixed: Array, period: Array) -> float:
    """Largest factor of unstable gains under which asynchronies do not grow; 0 if there is none."""
    stable = 0.0
    unstable = 1.0
    for _ in range(30):
        middle = 0.5 * (stable + unstable)
        if _growth(middle * phase + fixed, middle * period) <= 1.0 + STABILITY_TOLERANCE:
            stable = middle
        else:
            unstable = middle
    # Rounding also removes what the tolerance lets pass of gains that no factor makes stable.
    return round(stable, 4)


_RANGES: Mapping[str, tuple[float, float]] = {
    **dict.fromkeys(("timekeeper_s", "motor_s", "common_s"), (0.0, 5.0)),
    **dict.fromkeys(("group_spread", "dancer_spread", "iteration_spread", "entrainment"), (0.0, 5.0)),
    **dict.fromkeys(("correction", "robot_coupling", "music_coupling", "anticipation", "lapse"), (0.0, 1.0)),
    "period_correction": (0.0, 1.0),
    "practice": (-1.0, 0.99),
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


@cache
def preset(name: str) -> TimingParameters:
    """Parameters of a preset.

    Raises:
        UnknownNameError: no preset has the name.
    """
    table = _presets()
    if name not in table:
        raise UnknownNameError(
            "humans preset", name, (*table, *names("humans"), "expertise:0.5", "FILE.toml", "replay:FILE")
        )

    return parameters_from(table[name], f"humans.{name}")


def parameters_at_expertise(expertise: float) -> TimingParameters:
    """Parameters of people between the presets `NOVICES` (0) and `EXPERTS` (1).

    Standard deviations of noise are interpolated geometrically, since variability differs between people by factors;
    gains, spreads and the lapse rate linearly.

    That variability falls and correction rises with musical training: scheurich2018, repp2013. That all of them follow
    one number, and how, is assumed.

    Args:
        expertise: 0 for people without training, 1 for trained musicians.

    Raises:
        ConfigError: the expertise is not from 0 to 1.
    """
    if isinstance(expertise, bool) or not 0.0 <= expertise <= 1.0:
        raise ConfigError("humans.expertise", expertise, f"a number from 0 ({NOVICES}) to 1 ({EXPERTS})")

    novices = preset(NOVICES)
    experts = preset(EXPERTS)
    values: dict[str, Any] = {"about": f"expertise {expertise:g} between {NOVICES} (0) and {EXPERTS} (1)"}
    for item in fields(TimingParameters):
        low = getattr(novices, item.name)
        high = getattr(experts, item.name)
        if item.name in ("timekeeper_s", "motor_s", "common_s"):
            values[item.name] = float(low ** (1.0 - expertise) * high**expertise)
        elif isinstance(low, float):
            values[item.name] = float((1.0 - expertise) * low + expertise * high)
    return TimingParameters(**values)


def read_table(path: Path) -> dict[str, Any]:
    """Fields of a TOML file of parameters, such as ``python -m sjasim.calibrate`` writes it.

    Raises:
        ConfigError: the file cannot be read, or is not TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError("humans", str(path), f"a readable TOML file ({error.strerror or error})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError("humans", str(path), f"a TOML file ({error})") from error


def read_parameters(path: Path) -> TimingParameters | None:
    """Parameters from a TOML file of `TimingParameters` fields; None for a file that names another model.

    Raises:
        ConfigError: the file cannot be read, is not TOML, or has a wrong field.
    """
    data = read_table(path)
    if data.pop("model", ENSEMBLE) != ENSEMBLE:
        return None
    return parameters_from(data, f"humans ({path})")


def parameters_toml(parameters: TimingParameters) -> str:
    """Text of a parameter file, without the fields that have their default."""
    default = TimingParameters()
    values = {field.name: getattr(parameters, field.name) for field in fields(TimingParameters)}
    return plain_to_toml({name: value for name, value in values.items() if value != getattr(default, name)})


def parameters_from(data: Mapping[str, Any], where: str) -> TimingParameters:
    """Parameters from plain data.

    Args:
        data: fields of `TimingParameters`.
        where: names the origin of the data in messages.

    Raises:
        ConfigError: a field is unknown, or its value is not allowed.
    """
    known = {field.name for field in fields(TimingParameters)}
    unknown = sorted(data.keys() - known)
    if unknown:
        raise ConfigError(f"{where}.{unknown[0]}", data[unknown[0]], f"no such field; known are {', '.join(known)}")

    return TimingParameters(**{key: _as_tuples(value) for key, value in data.items()})


def _as_tuples(value: Any) -> Any:
    """The value with lists, also nested ones, made tuples."""
    return tuple(_as_tuples(item) for item in value) if isinstance(value, list) else value


@cache
def _presets() -> dict[str, dict[str, Any]]:
    text = resources.files("sjasim.assets").joinpath("presets.toml").read_text("utf-8")
    return tomllib.loads(text)
