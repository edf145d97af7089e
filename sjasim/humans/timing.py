"""When dancers really move: nominal beats plus the group's common shift plus each dancer's own deviation.

The common shift is an AR(1) process over the iteration's events; own deviations follow linear phase correction in
an ensemble, with timekeeper and motor noise. A badly timed robot disturbs people, a well-timed one steadies them.

Source: vorberg1996, section 3 (phase correction); wing2014, eq. (1) (the ensemble's form). Shortest moves and holds
are assumed; they keep the order of events.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, fields
from importlib import resources
from typing import Any, Protocol

import numpy as np

from ..choreography.score import MOVE_EVENTS, Timetable
from ..errors import ConfigError, UnknownNameError
from ..types import Array, Cue, Move, dancer_name

SHORTEST_MOVE_S = 0.8
SHORTEST_HOLD_S = 0.15
USUAL_APPROPRIATENESS_S = 0.70
"""Mean timing error of the robot at which people are as noisy as their preset says [s]."""
TURN_AFTER_CLAP_S = 0.25
"""A dancer begins to turn so long after the clap [s] (assumed)."""


@dataclass(frozen=True, slots=True)
class TimingParameters:
    """Parameters of the human timing model.

    Attributes:
        timekeeper_s: standard deviation of each event's own timekeeper noise.
        motor_s: standard deviation of the noise that is not carried on.
        common_s: standard deviation of the group's common shift.
        common_correlation: correlation of that shift from event to event.
        coupling: share of its lead over each other dancer that a dancer gives up per event in a group of three;
            larger and smaller groups correct as much in all (assumed), and beyond .6 the ensemble is unstable.
        group_spread: log standard deviation of a group's noise scale.
        iteration_spread: the same from iteration to iteration.
        entrainment: exponent of the robot's last timing error in the dancers' own noise.
        lapse: probability that a dancer leaves out a phrase (forward and backward) or a clap.
        late_s: constant lateness of the first, second, ... dancer.
        about: where the values come from.
    """

    timekeeper_s: float = 0.0
    motor_s: float = 0.0
    common_s: float = 0.0
    common_correlation: float = 0.0
    coupling: float = 0.0
    group_spread: float = 0.0
    iteration_spread: float = 0.0
    entrainment: float = 0.0
    lapse: float = 0.0
    late_s: tuple[float, ...] = ()
    about: str = ""

    def __post_init__(self) -> None:
        for name in ("timekeeper_s", "motor_s", "common_s", "group_spread", "iteration_spread", "entrainment"):
            _within(name, getattr(self, name), 0.0, 5.0)
        _within("common_correlation", self.common_correlation, 0.0, 0.999)
        _within("coupling", self.coupling, 0.0, 0.6)
        _within("lapse", self.lapse, 0.0, 1.0)
        for late in self.late_s:
            _within("late_s", late, -5.0, 5.0)


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
        raise UnknownNameError("humans preset", name, tuple(table))
    values: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in table[name].items()
    }
    unknown = values.keys() - {field.name for field in fields(TimingParameters)}
    if unknown:
        raise ConfigError(f"humans.{name}", sorted(unknown), "fields of TimingParameters")
    return TimingParameters(**values)


def _presets() -> dict[str, dict[str, Any]]:
    text = resources.files(__package__.rpartition(".")[0]).joinpath("assets/presets.toml").read_text("utf-8")
    return tomllib.loads(text)


class HumanTiming(Protocol):
    """A human timing model: one class that gives event times, an iteration at a time."""

    def draw(self, iteration: int, appropriateness_s: float | None, not_before_s: Array) -> tuple[tuple[Cue, ...], ...]:
        """Cues of every dancer for an iteration, in order of time.

        Args:
            iteration: which one; each is asked for once, in order.
            appropriateness_s: the robot's mean timing error in the iteration before, or None if it did not move.
            not_before_s: (D,) session time before which each dancer cannot begin.
        """
        ...


class EnsembleTiming:
    """The model of this module.

    Args:
        parameters: of the model.
        timetable: the dance on the session's clock.
        dancers: how many.
        people: random stream of the persons; the same people meet every method.
        performance: random stream of this take.

    Raises:
        ConfigError: a group of none, or of more than 8.
    """

    def __init__(
        self,
        parameters: TimingParameters,
        timetable: Timetable,
        dancers: int,
        people: np.random.Generator,
        performance: np.random.Generator,
    ) -> None:
        if isinstance(dancers, bool) or not 1 <= dancers <= 8:
            raise ConfigError("group", dancers, "1 to 8 dancers")
        self._p = parameters
        self._coupling = parameters.coupling * 3.0 / dancers
        self._timetable = timetable
        self._dancers = dancers
        self._rng = performance
        self._scale = _lognormal(parameters.group_spread, people)
        self._steps = timetable.choreography.steps()
        self._late = np.zeros(dancers)
        given = parameters.late_s[:dancers]
        self._late[: len(given)] = given

    def draw(self, iteration: int, appropriateness_s: float | None, not_before_s: Array) -> tuple[tuple[Cue, ...], ...]:
        """See `HumanTiming`."""
        p, rng = self._p, self._rng
        last = USUAL_APPROPRIATENESS_S if appropriateness_s is None else appropriateness_s
        scale = self._scale * _lognormal(p.iteration_spread, rng)
        own = np.clip(scale * (np.clip(last, 0.05, 3.0) / USUAL_APPROPRIATENESS_S) ** p.entrainment, 0.1, 5.0)
        nominal = np.array([self._timetable.time_s(iteration, step.beat) for step in self._steps])
        times = nominal + scale * p.common_s * self._common() + self._own(own) + self._late[:, None]
        lapses = rng.random((self._dancers, len(self._steps))) < p.lapse
        return tuple(
            self._cues(
                dancer,
                iteration,
                _ordered(times[dancer], len(self._steps), float(not_before_s[dancer])),
                lapses[dancer],
            )
            for dancer in range(self._dancers)
        )

    def _common(self) -> Array:
        """(1, E) common shift in units of its standard deviation."""
        noise = self._rng.standard_normal(len(self._steps))
        rho = self._p.common_correlation
        shift = np.empty((1, len(noise)))
        shift[0, 0] = noise[0]
        for k in range(1, len(noise)):
            shift[0, k] = rho * shift[0, k - 1] + np.sqrt(1.0 - rho**2) * noise[k]
        return shift

    def _own(self, scale: float) -> Array:
        """(D, E) own deviations [s]."""
        p, shape = self._p, (self._dancers, len(self._steps))
        timekeeper = p.timekeeper_s * scale * self._rng.standard_normal(shape)
        motor = p.motor_s * scale * self._rng.standard_normal(shape)
        phase = timekeeper[:, 0].copy()
        out = np.empty(shape)
        for k in range(shape[1]):
            if k:
                phase = phase - self._coupling * (self._dancers * phase - phase.sum()) + timekeeper[:, k]
            out[:, k] = phase
        return out + motor

    def _cues(self, dancer: int, iteration: int, times: Array, lapses: np.ndarray) -> tuple[Cue, ...]:
        choreography = self._timetable.choreography
        cues: list[Cue] = []
        skipping = False
        for index, item in enumerate(choreography.moves):
            first = choreography.first_ordinal(index)
            t, duration = float(times[first]), 0.0
            if len(MOVE_EVENTS[item.move]) == 2:
                duration = float(times[first + 1]) - t
                skipping = bool(lapses[first]) if item.move is Move.FORWARD else skipping
                if skipping:
                    continue
            elif item.move is Move.TURN:
                duration = self._timetable.time_s(iteration, item.beat + item.beats)
                duration -= self._timetable.time_s(iteration, item.beat)
                t += TURN_AFTER_CLAP_S
            elif lapses[first]:
                continue
            cues.append(Cue(dancer_name(dancer), item.move, iteration, first, item.beat, t, duration))
        return tuple(cues)


def _ordered(times: Array, count: int, not_before_s: float) -> Array:
    """Event times in order: no move and no hold is shorter than people can make it."""
    out = times.copy()
    earliest = not_before_s
    for k in range(count):
        out[k] = max(out[k], earliest)
        earliest = out[k] + (SHORTEST_MOVE_S if k % 2 == 0 else SHORTEST_HOLD_S)
    return out


def _lognormal(spread: float, rng: np.random.Generator) -> float:
    """A factor with mean 1 and the given log standard deviation; one draw is spent whatever the spread."""
    return float(np.exp(spread * rng.standard_normal() - spread**2 / 2))
