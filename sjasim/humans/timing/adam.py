"""ADAM, the adaptation and anticipation model: people correct past asynchronies and predict coming intervals.

At each event a person plans the next one twice. *Adaptation* adds the person's own period and corrects a share of the
last asynchrony, in the phase and in the period. *Anticipation* extrapolates the intervals of what the person hears. The
*joint* module moves the first plan towards the second. What a person hears is the music, the mean of the other people,
or a weighted mean of both.

Source: vandersteen2013 (adaptation, anticipation and joint module). Assumed: a person synchronises with the mean of
several partners; intervals of different length count by their tempo; motor noise is normally distributed.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from ...choreography.timetable import Timetable
from ...core import Array
from ...core.compiled import compiled_entry
from ...core.errors import ConfigError
from ...core.registry import register
from .whole_iteration import WholeIterationTiming


@dataclass(frozen=True, slots=True)
class AdamParameters:
    """Parameters of ADAM. The defaults are musicians who dance, as assumed for the preset ``musicians``.

    The gains lie within the range that vandersteen2013 simulates; which of them dancers have is assumed.

    Attributes:
        phase_correction: share of an asynchrony that is corrected in the next interval alone (alpha).
        period_correction: share of an asynchrony that is corrected in the next and all later intervals (beta).
        prediction: share of a tempo change that is extrapolated; with 0 the last interval is expected again (delta).
        anticipation: weight of the predicted time against the adapted one (gamma).
        timekeeper_s: standard deviation of the timekeeper noise of each event [s].
        motor_s: standard deviation of the motor noise, which later events do not inherit [s].
        music_share: weight of the music in what a dancer hears; the others have the rest.
        dancer_spread: standard deviation of the logarithm of the noise scale, from dancer to dancer.
        lapse: probability that a dancer leaves out a phrase (forward and backward) or a clap.
    """

    phase_correction: float = 0.4
    period_correction: float = 0.1
    prediction: float = 0.5
    anticipation: float = 0.2
    timekeeper_s: float = 0.025
    motor_s: float = 0.012
    music_share: float = 0.5
    dancer_spread: float = 0.2
    lapse: float = 0.01

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            high = 2.0 if item.name in ("phase_correction", "dancer_spread") else 1.0
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= high:
                raise ConfigError(f"humans.{item.name}", value, f"a number from 0 to {high:g}")

    @property
    def gains(self) -> tuple[float, float, float, float]:
        """Phase correction, period correction, prediction and anticipation."""
        return self.phase_correction, self.period_correction, self.prediction, self.anticipation


@compiled_entry
def adam_times_s(
    music_s: Array,
    beats: Array,
    music_share: Array,
    gains: tuple[float, float, float, float],
    timekeeper_s: Array,
    motor_s: Array,
) -> Array:
    """Event times of people who synchronise with music, with one another, or with both [s].

    Tapping with a metronome is one person with a music share of 1; a duet is two with a share of 0 after the pacing
    tones. The first event of everybody is that of the music plus noise.

    Args:
        music_s: (E,) times of the events in the music; those with a share of 0 do not count, but the first two, whose
            interval everybody begins with.
        beats: (E,) the events in beats, strictly increasing.
        music_share: (E,) weight of the music in what people hear at each event.
        gains: phase correction, period correction, prediction and anticipation; see `AdamParameters`.
        timekeeper_s: (P, E) timekeeper noise of each person.
        motor_s: (P, E) motor noise.

    Returns:
        (P, E) times.
    """
    phase_gain, period_gain, prediction, anticipation = gains
    persons, events = timekeeper_s.shape
    times_s = np.empty((persons, events))
    heard_s = np.empty((persons, events))
    period_s = np.full(persons, (music_s[1] - music_s[0]) / (beats[1] - beats[0]))
    times_s[:, 0] = music_s[0] + timekeeper_s[:, 0] + motor_s[:, 0]

    for k in range(events - 1):
        ahead = beats[k + 1] - beats[k]
        last = beats[k] - beats[k - 1] if k > 0 else ahead
        total_s = times_s[:, k].sum()

        for i in range(persons):
            share = music_share[k] if persons > 1 else 1.0
            others_s = (total_s - times_s[i, k]) / (persons - 1) if persons > 1 else 0.0
            # A single person hears nothing but the music.
            heard_s[i, k] = share * music_s[k] + (1.0 - share) * others_s
            asynchrony_s = times_s[i, k] - heard_s[i, k]

            # Adaptation: the own period, and a share of the last asynchrony.
            period_s[i] -= period_gain * asynchrony_s / last
            adapted_s = times_s[i, k] + ahead * period_s[i] - phase_gain * asynchrony_s

            # Anticipation: the tempo of the last interval, plus a share of its change from the one before.
            tempo_s = period_s[i]
            if k > 0:
                tempo_s = (heard_s[i, k] - heard_s[i, k - 1]) / last
            if k > 1:
                before = beats[k - 1] - beats[k - 2]
                change_s = tempo_s - (heard_s[i, k - 1] - heard_s[i, k - 2]) / before
                # Tempi belong to the middles of their intervals.
                tempo_s += prediction * change_s * (ahead + last) / (last + before)
            predicted_s = heard_s[i, k] + ahead * tempo_s

            # Joint module: the plan moves towards the prediction.
            joint_s = adapted_s - anticipation * (adapted_s - predicted_s)
            times_s[i, k + 1] = joint_s + timekeeper_s[i, k + 1] + motor_s[i, k + 1] - motor_s[i, k]
    return times_s


def tap_times_s(
    stimulus_s: Array, music_share: Array, persons: int, parameters: AdamParameters, rng: np.random.Generator
) -> Array:
    """(P, E) tap times of people at the tones of a stimulus, one beat apart [s].

    Args:
        stimulus_s: (E,) times of the tones.
        music_share: (E,) weight of the stimulus against the other people; see `adam_times_s`.
        persons: number of people.
        parameters: of all people, who are equally noisy.
        rng: generator of the noise.
    """
    noise = rng.standard_normal((2, persons, len(stimulus_s)))
    return adam_times_s(
        np.ascontiguousarray(stimulus_s, dtype=np.float64),
        np.arange(len(stimulus_s), dtype=np.float64),
        np.ascontiguousarray(music_share, dtype=np.float64),
        parameters.gains,
        parameters.timekeeper_s * noise[0],
        parameters.motor_s * noise[1],
    )


@register("humans", "adam", AdamParameters)
class AdamTiming(WholeIterationTiming):
    """Implements `HumanTiming` by ADAM: dancers adapt to and anticipate the music and one another.

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
        parameters: AdamParameters,
        timetable: Timetable,
        dancers: int,
        people: np.random.Generator,
        performance: np.random.Generator,
    ) -> None:
        super().__init__(timetable, dancers, performance, parameters.lapse)
        self._parameters = parameters
        spread = parameters.dancer_spread
        self._scale = np.exp(spread * people.standard_normal(dancers) - spread**2 / 2)

    def _planned_times_s(self, iteration: int) -> Array:
        """(D, E) planned event times; each iteration begins with the music."""
        parameters = self._parameters
        events = len(self._beats)
        noise = self._scale[:, None] * self._rng.standard_normal((2, self._dancers, events))
        return adam_times_s(
            self._music_s(iteration),
            self._beats,
            np.full(events, parameters.music_share),
            parameters.gains,
            parameters.timekeeper_s * noise[0],
            parameters.motor_s * noise[1],
        )
