"""Dancers who keep time as the oscillators of ASHLE do: each has a spontaneous tempo that pulls."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...choreography.timetable import Timetable
from ...core import Array
from ...core.errors import ConfigError
from ...core.registry import register
from .ashle import STEP_S, ComplexArray, OscillatorParameters, Oscillators, passage_times_s
from .whole_iteration import WholeIterationTiming

LEAD_IN_BEATS = 6
"""Beats of music that dancers hear before an iteration begins (assumed)."""

LATEST_BEATS = 4
"""Beats after the last event of an iteration until which oscillators are followed; a later event stands there."""


@dataclass(frozen=True, slots=True)
class AshleParameters:
    """Parameters of dancers who are oscillators.

    Attributes:
        spontaneous_s: mean spontaneous period of the dancers [s]; the mean of musicians in scheurich2018.
        spontaneous_spread: standard deviation of its logarithm, from dancer to dancer; that of the same musicians.
        oscillators: parameters of the oscillators.
        lapse: probability that a dancer leaves out a phrase (forward and backward) or a clap.
    """

    spontaneous_s: float = 0.406
    spontaneous_spread: float = 0.25
    oscillators: OscillatorParameters = field(default_factory=OscillatorParameters)
    lapse: float = 0.01

    def __post_init__(self) -> None:
        for name, low, high in (
            ("spontaneous_s", 0.1, 2.0),
            ("spontaneous_spread", 0.0, 1.0),
            ("lapse", 0.0, 1.0),
        ):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
                raise ConfigError(f"humans.{name}", value, f"a number from {low:g} to {high:g}")


@register("humans", "ashle", AshleParameters)
class AshleTiming(WholeIterationTiming):
    """Implements `HumanTiming` by oscillators that hear the music and one another.

    Every dancer counts the beat on the metrical level that is nearest to its spontaneous tempo: half or twice the
    spontaneous period counts as the same tempo (assumed). An event happens when the motor oscillator has completed as
    many cycles as the music has beats. Frequencies carry over from one iteration to the next, phases begin anew.

    Args:
        parameters: parameters of the model.
        timetable: the dance in session time.
        dancers: number of dancers.
        people: generator of the persons; the same persons meet every method.
        performance: generator of this performance.

    Raises:
        ConfigError: the number of dancers is not 1 to `MAX_DANCERS`.
    """

    def __init__(
        self,
        parameters: AshleParameters,
        timetable: Timetable,
        dancers: int,
        people: np.random.Generator,
        performance: np.random.Generator,
    ) -> None:
        super().__init__(timetable, dancers, performance, parameters.lapse)
        beat_s = timetable.time_s(timetable.first, 1.0) - timetable.time_s(timetable.first, 0.0)
        own_s = parameters.spontaneous_s * np.exp(parameters.spontaneous_spread * people.standard_normal(dancers))
        self._oscillators = Oscillators(_at_level_of(beat_s, own_s), parameters.oscillators, performance)

    def _planned_times_s(self, iteration: int) -> Array:
        """(D, E) planned event times: when the motor oscillators reach the beats of the events."""
        self._oscillators.restart()
        begin_s = self._timetable.time_s(iteration, -float(LEAD_IN_BEATS))
        cycles = self._oscillators.advance(self._music(iteration, begin_s))

        # A dancer who has counted a cycle more or less by beat 0 joins the beat that is nearest.
        at_beat_0 = round((self._timetable.time_s(iteration, 0.0) - begin_s) / STEP_S)
        counted = np.rint(cycles[at_beat_0]) - LEAD_IN_BEATS
        last_s = begin_s + (len(cycles) - 1) * STEP_S
        planned_s = [
            begin_s + passage_times_s(own - counted[dancer], self._beats + LEAD_IN_BEATS)
            for dancer, own in enumerate(cycles.T)
        ]
        return np.nan_to_num(np.array(planned_s), nan=last_s)

    def _music(self, iteration: int, begin_s: float) -> ComplexArray:
        """(N,) the music of an iteration and its lead-in, as a sinusoid with one period a beat."""
        beats = np.arange(-LEAD_IN_BEATS, np.ceil(self._beats[-1]) + LATEST_BEATS + 1)
        times_s = [self._timetable.time_s(iteration, float(beat)) - begin_s for beat in beats]
        steps_s = np.arange(round(times_s[-1] / STEP_S)) * STEP_S
        return np.asarray(np.exp(2j * np.pi * np.interp(steps_s, times_s, beats)))


def _at_level_of(beat_s: float, spontaneous_s: Array) -> Array:
    """(D,) spontaneous periods, halved or doubled until they are nearest to the beat [s]."""
    octaves = np.rint(np.log2(beat_s / spontaneous_s))
    return np.asarray(spontaneous_s * 2.0**octaves)
