"""ASHLE: people as pairs of oscillators whose frequencies adapt, with a pull towards each person's spontaneous tempo.

A sensory oscillator synchronises with what the person hears, and a motor oscillator with the sensory one. Both
frequencies learn from the phase differences. The sensory frequency is pulled weakly towards the motor frequency, and
the motor frequency strongly towards the person's spontaneous motor tempo. A person taps whenever the motor oscillator
completes a cycle.

Source: roman2023, eq. (3), with its parameters. Noise acts on the motor oscillator, as there in eq. (4). Its size, and
the weight of a partner in what a person hears, are fitted to the duets of zamm2016 with matching spontaneous tempi
(`sjasim.studies.tempo_tasks`): under a weight of 1, two people do not stay together in this implementation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core import Array
from ...core.compiled import compiled_entry
from ...core.errors import ConfigError

STEP_S = 0.002
"""Length of the integration steps, by Euler's method [s]. Source: roman2023."""

FIRST_RADIUS = 0.01
"""Radius at which the oscillators start; they grow to a radius near 1 within a cycle (assumed)."""

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class OscillatorParameters:
    """Parameters of the oscillators.

    Attributes:
        learning: rate at which a frequency learns from a phase difference (lambda 1).
        elasticity: pull of the motor frequency towards the spontaneous tempo (lambda 2).
        sensory_elasticity: pull of the sensory frequency towards the motor one (gamma).
        partner_weight: weight of other people in what a person hears; the music has a weight of 1.
        noise: standard deviation of the motor oscillator's noise after 1 s, where its radius is near 1 [s**-0.5].
    """

    learning: float = 4.0
    elasticity: float = 2.0
    sensory_elasticity: float = 0.02
    partner_weight: float = 0.03
    noise: float = 0.73

    def __post_init__(self) -> None:
        for name, high in (
            ("learning", 20.0),
            ("elasticity", 20.0),
            ("sensory_elasticity", 20.0),
            ("partner_weight", 1.0),
            ("noise", 5.0),
        ):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= high:
                raise ConfigError(f"humans.{name}", value, f"a number from 0 to {high:g}")


class Oscillators:
    """People as oscillators, in a state that continues from call to call.

    Args:
        spontaneous_s: (P,) period of each person's spontaneous tempo [s].
        parameters: of all persons.
        rng: generator of the noise.
        start_s: (P,) periods at which the persons start [s]; None for the spontaneous ones.

    Attributes:
        frequencies_hz: (P, 2) present frequencies of the sensory and the motor oscillator [Hz].
    """

    def __init__(
        self,
        spontaneous_s: Array,
        parameters: OscillatorParameters,
        rng: np.random.Generator,
        start_s: Array | None = None,
    ) -> None:
        self._spontaneous_hz = 1.0 / np.asarray(spontaneous_s, dtype=np.float64)
        self._parameters = parameters
        self._rng = rng

        first_hz = self._spontaneous_hz if start_s is None else 1.0 / np.asarray(start_s, dtype=np.float64)
        self.frequencies_hz = np.repeat(first_hz[:, None], 2, axis=1)
        self.restart()

    def restart(self) -> None:
        """Set all phases to 0, and keep the frequencies."""
        self._positions: ComplexArray = np.full((len(self._spontaneous_hz), 2), FIRST_RADIUS + 0.0j)

    def advance(self, music: ComplexArray) -> Array:
        """Integrate the oscillators, each hearing the music and the motor oscillators of all others.

        Args:
            music: (N,) the music at each step as a point on the unit circle; 0 where there is none.

        Returns:
            (N + 1, P) phases of the motor oscillators since the call [cycles].
        """
        parameters = self._parameters
        persons = len(self._spontaneous_hz)
        # Noise of a diffusion grows with the square root of the step, so that its size does not depend on the step.
        noise = self._rng.standard_normal((len(music), persons, 2)) * (parameters.noise * np.sqrt(STEP_S))
        return _integrate(
            self._positions,
            self.frequencies_hz,
            np.ascontiguousarray(music, dtype=np.complex128),
            self._spontaneous_hz,
            noise,
            (
                parameters.learning,
                parameters.elasticity,
                parameters.sensory_elasticity,
                parameters.partner_weight / max(persons - 1, 1),
            ),
        )


@compiled_entry
def _integrate(
    positions: ComplexArray,
    frequencies_hz: Array,
    music: ComplexArray,
    spontaneous_hz: Array,
    noise: Array,
    gains: tuple[float, float, float, float],
) -> Array:
    """Advance positions and frequencies in place; see `Oscillators.advance`.

    Source: roman2023, eqs. (3) and (4).
    """
    learning, elasticity, sensory_elasticity, partner_weight = gains
    persons = len(spontaneous_hz)
    cycles = np.zeros((len(music) + 1, persons))
    turn = 2j * np.pi

    for n in range(len(music)):
        heard_from_all = positions[:, 1].sum()
        # Everybody hears the others as they were before this step.
        before = positions[:, 1].copy()

        for i in range(persons):
            sensory = positions[i, 0]
            motor = before[i]
            sensory_hz = frequencies_hz[i, 0]
            motor_hz = frequencies_hz[i, 1]

            heard = music[n] + partner_weight * (heard_from_all - motor)
            direction = sensory / abs(sensory)
            # Sine of the phase difference, times the size of what drives the oscillator.
            sensory_lead = (direction * np.conj(heard)).imag
            motor_lead = (motor * np.conj(direction)).imag / abs(motor)

            # Both oscillators have a limit cycle of radius near 1.
            positions[i, 0] += STEP_S * sensory_hz * (sensory * (1.0 + turn - abs(sensory) ** 2) + heard)
            step = STEP_S * motor_hz * (motor * (1.0 + turn - abs(motor) ** 2) + direction)
            positions[i, 1] = motor + step + complex(noise[n, i, 0], noise[n, i, 1])

            # Frequencies learn from the phase differences, against their pulls.
            pull = sensory_elasticity * (np.exp((sensory_hz - motor_hz) / motor_hz) - 1.0)
            frequencies_hz[i, 0] += STEP_S * sensory_hz * (-learning * sensory_lead - pull)
            pull = elasticity * (np.exp((motor_hz - spontaneous_hz[i]) / spontaneous_hz[i]) - 1.0)
            frequencies_hz[i, 1] += STEP_S * motor_hz * (-learning * motor_lead - pull)

            # The angle between two steps is small, so that the phase never jumps by a cycle.
            turned = positions[i, 1] * np.conj(motor)
            cycles[n + 1, i] = cycles[n, i] + np.arctan2(turned.imag, turned.real) / (2.0 * np.pi)
    return cycles


def passage_times_s(cycles: Array, at: Array) -> Array:
    """Times at which a phase first reaches given values [s]; NaN for those it does not reach.

    Args:
        cycles: (N,) phase at each step [cycles].
        at: (K,) phases, in increasing order [cycles].
    """
    # Noise can turn an oscillator back for a moment; the first passage counts.
    reached = np.maximum.accumulate(cycles)
    steps = np.searchsorted(reached, at, side="left")
    inside = (steps > 0) & (steps < len(reached))

    last = np.clip(steps, 1, len(reached) - 1)
    rise = reached[last] - reached[last - 1]
    share = np.divide(at - reached[last - 1], rise, out=np.ones(len(at)), where=rise > 0.0)
    out = np.where(inside, (last - 1 + share) * STEP_S, np.nan)
    return np.asarray(np.where((steps == 0) & (at <= reached[0]), 0.0, out))


def metronome(period_s: float, duration_s: float, clicks: int | None = None) -> ComplexArray:
    """(N,) sinusoidal metronome at each step, silent after a number of periods.

    Args:
        period_s: period [s].
        duration_s: duration of the task [s].
        clicks: number of periods after which it stops; None for never.
    """
    t_s = np.arange(round(duration_s / STEP_S)) * STEP_S
    heard = np.exp(2j * np.pi * t_s / period_s)
    if clicks is not None:
        heard[t_s >= clicks * period_s] = 0.0
    return np.asarray(heard)


def tap_times_s(persons: Oscillators, music: ComplexArray, taps: int) -> Array:
    """Times of the persons' taps from the start of the music [s].

    Args:
        persons: people with phases of 0; a tap is due at 0 and after every cycle.
        music: (N,) what they hear.
        taps: number of taps.

    Returns:
        (P, taps) times; NaN for taps after the end of the music.
    """
    cycles = persons.advance(music)
    at = np.arange(taps, dtype=np.float64)
    return np.array([passage_times_s(cycles[:, i], at) for i in range(cycles.shape[1])])


def asynchronies_s(taps_s: Array, clicks_s: Array | Sequence[float]) -> Array:
    """Each tap's distance from the nearest click, positive where the tap is late [s]; taps that are NaN are left out.

    Args:
        taps_s: (N,) times of taps.
        clicks_s: (K,) times of clicks, in increasing order.
    """
    clicks = np.asarray(clicks_s, dtype=np.float64)
    taps = taps_s[np.isfinite(taps_s)]
    after = np.clip(np.searchsorted(clicks, taps), 1, len(clicks) - 1)
    nearest = np.where(taps - clicks[after - 1] < clicks[after] - taps, clicks[after - 1], clicks[after])
    return np.asarray(taps - nearest)
