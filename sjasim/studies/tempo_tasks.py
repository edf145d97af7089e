"""Three tasks that show people's pull towards their spontaneous tempo, simulated with the oscillators of ASHLE.

Musicians play with a metronome that is faster or slower than their spontaneous rate; pianists start alone at another
rate than their spontaneous one; two pianists play together. Every task has the people, rates and lengths of its study.

Source: roman2023 (the tasks as simulations); scheurich2018, zamm2018 and zamm2016 (people).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace

import numpy as np

from ..assets import tempo_studies as people
from ..core import Array
from ..core.clock import stream
from ..humans.timing.ashle import STEP_S, OscillatorParameters, Oscillators, asynchronies_s, metronome, tap_times_s
from .reproduction_report import ReproducedValue, Reproduction

PACED_S = 50.0
"""Duration of a performance with a metronome, of which the second half counts [s]. Source: roman2023."""

UNPACED_TAPS = 128
"""Tones of a performance alone. Source: roman2023."""

UNPACED_MARGIN = 1.5
"""Simulated time of a performance alone, over that of its tones at the slower of its first and spontaneous rates."""

DUET_CLICKS = 4
"""Clicks before a duet. Source: zamm2016."""

DUET_REPETITIONS = 4
"""Repetitions of the melody in a duet. Source: zamm2016."""

DUET_TONES = 16
"""Tones of the melody of a duet. Source: zamm2016."""

DUET_LONGEST_S = 50.0
"""Duration of the simulation of a duet, long enough for its slowest pairs [s]."""

FIRST_TONE = 4
"""Tones of a duet after the clicks that do not count, while the two still find together. Source: roman2023."""

LARGEST_SHIFT = 6
"""Largest number of tones by which the two parts of a duet are shifted to align them."""

Progress = Callable[[float], None]


DUET_PERFORMANCES = 10
"""Simulated performances of each duet, from which the simulated studies draw."""


def reproduce_tempo_tasks(studies: int, seed: int, progress: Progress) -> Reproduction:
    """Simulate the three tasks and compare them with people.

    Noise acts in duets only, as in roman2023: without music or a partner, nothing holds noisy oscillators at a tempo.
    A simulated study draws as many people as the real one, with replacement, and one performance of each. The interval
    of a value holds 95 % of the simulated studies, after people's own standard error is added to each of them.

    Args:
        studies: number of simulated studies.
        seed: seed of all random numbers.
        progress: is called with the share that is done, 0 to 1.
    """
    parameters = OscillatorParameters()
    rng = stream(seed, "reproduce", "ashle")
    quiet = replace(parameters, noise=0.0)

    # Without noise, all performances of a person are the same.
    paced = paced_asynchronies_ms(quiet, rng)[None]
    progress(0.25)
    unpaced = unpaced_slopes_ms(quiet, rng)[None]
    progress(0.5)
    duets: dict[str, list[Array]] = {kind: [] for kind in people.DUET_PERIODS_MS}
    for number in range(DUET_PERFORMANCES):
        for kind, found in duets.items():
            found.append(duet_asynchronies_ms(kind, parameters, rng))
        progress(0.5 + 0.5 * (number + 1) / DUET_PERFORMANCES)

    rows = []
    for ratio, column in zip(people.PACED_ASYNCHRONY_MS, np.moveaxis(paced, 2, 0), strict=True):
        label = ("asynchrony [ms]", f"metronome {100 * ratio:.0f} %", "fitted", "scheurich2018")
        rows.append(_row(label, people.PACED_ASYNCHRONY_MS[ratio], column, studies, rng))
    for rate, column in zip(people.UNPACED_SLOPE_MS, np.moveaxis(unpaced, 2, 0), strict=True):
        label = ("drift [ms/tone]", f"alone, {rate}", "held out", "zamm2018")
        rows.append(_row(label, people.UNPACED_SLOPE_MS[rate], column, studies, rng))
    for kind, found in duets.items():
        role = "fitted" if kind == "matching" else "held out"
        for repetition, column in enumerate(np.moveaxis(np.array(found), 2, 0)):
            label = ("asynchrony [ms]", f"{kind} {repetition + 1}", role, "zamm2016")
            rows.append(_row(label, people.DUET_ASYNCHRONY_MS[kind][repetition], column, studies, rng))
    settings = {"studies": studies, "seed": seed, "parameters": asdict(parameters)}
    return Reproduction("ashle", settings, rows)


def paced_asynchronies_ms(parameters: OscillatorParameters, rng: np.random.Generator) -> Array:
    """(20, 4) asynchrony of each musician in each condition, less that at the spontaneous rate [ms]."""
    ratios = (1.0, *people.PACED_ASYNCHRONY_MS)
    rows = []
    for spontaneous_ms in people.PACED_PERIODS_MS:
        spontaneous_s = spontaneous_ms / 1e3
        found = []
        for ratio in ratios:
            period_s = ratio * spontaneous_s
            clicks_s = np.arange(0.0, PACED_S + period_s, period_s)
            person = Oscillators(np.array([spontaneous_s]), parameters, rng)
            taps_s = tap_times_s(person, metronome(period_s, PACED_S), 2 * len(clicks_s))[0]
            # The first half, in which the frequencies still adapt, does not count.
            found.append(float(asynchronies_s(taps_s[taps_s > PACED_S / 2], clicks_s).mean()))
        rows.append(np.array(found[1:]) - found[0])
    return 1e3 * np.array(rows)


def unpaced_slopes_ms(parameters: OscillatorParameters, rng: np.random.Generator) -> Array:
    """(24, 4) change of the interval per tone of each pianist at each rate, less that at the spontaneous rate [ms]."""
    rows = []
    for index, spontaneous_ms in enumerate(people.UNPACED_PERIODS_MS):
        changes = (0.0, *(own[index] for own in people.UNPACED_CHANGES_MS.values()))
        slopes = [_slope_ms(spontaneous_ms, spontaneous_ms + change, parameters, rng) for change in changes]
        rows.append(np.array(slopes[1:]) - slopes[0])
    return np.array(rows)


def _slope_ms(
    spontaneous_ms: float, first_ms: float, parameters: OscillatorParameters, rng: np.random.Generator
) -> float:
    """Regression slope of the intervals on their number [ms per tone]."""
    person = Oscillators(np.array([spontaneous_ms / 1e3]), parameters, rng, np.array([first_ms / 1e3]))
    # A performance lasts no longer than at the slower of the two rates.
    longest_s = UNPACED_MARGIN * UNPACED_TAPS * max(spontaneous_ms, first_ms) / 1e3
    silence = np.zeros(round(longest_s / STEP_S), dtype=np.complex128)
    intervals_ms = 1e3 * np.diff(tap_times_s(person, silence, UNPACED_TAPS)[0])
    return float(np.polyfit(np.arange(len(intervals_ms)), intervals_ms, 1)[0])


def duet_asynchronies_ms(kind: str, parameters: OscillatorParameters, rng: np.random.Generator) -> Array:
    """(10, 4) mean absolute asynchrony of each pair in each repetition of the melody [ms].

    Args:
        kind: which pairs, a key of `DUET_PERIODS_MS`.
        parameters: of both pianists.
        rng: generator of the noise.
    """
    clicks = metronome(people.DUET_METRONOME_MS / 1e3, DUET_LONGEST_S, DUET_CLICKS)
    start_s = DUET_CLICKS * people.DUET_METRONOME_MS / 1e3
    tones = DUET_REPETITIONS * DUET_TONES

    rows = []
    for pair_ms in people.DUET_PERIODS_MS[kind]:
        pair = Oscillators(np.array(pair_ms) / 1e3, parameters, rng)
        taps_s = tap_times_s(pair, clicks, round(2 * DUET_LONGEST_S / (min(pair_ms) / 1e3)))
        first, second = (own[own > start_s] for own in taps_s)
        apart_s = aligned_asynchronies_s(first[FIRST_TONE : FIRST_TONE + tones], second)
        rows.append(apart_s.reshape(DUET_REPETITIONS, DUET_TONES).mean(axis=1))
    return 1e3 * np.array(rows)


def aligned_asynchronies_s(first_s: Array, second_s: Array) -> Array:
    """(N,) absolute asynchronies of the tones of two parts, shifted so that they agree best [s].

    Args:
        first_s: (N,) tones of one part.
        second_s: tones of the other part, of which N consecutive ones from one of the first `FIRST_TONE` +
            `LARGEST_SHIFT` tones on are compared.
    """
    length = len(first_s)
    shifts = range(min(FIRST_TONE + LARGEST_SHIFT, len(second_s) - length) + 1)
    return min((np.abs(first_s - second_s[shift : shift + length]) for shift in shifts), key=lambda apart: apart.mean())


def _row(
    label: tuple[str, str, str, str],
    published: tuple[float, float],
    found: Array,
    studies: int,
    rng: np.random.Generator,
) -> ReproducedValue:
    """The row of one value.

    Args:
        label: the value, its condition, its role and its source.
        published: people's mean and its standard error.
        found: (R, P) simulated values of each performance and person.
        studies: number of simulated studies.
        rng: generator of the studies.
    """
    performances, persons = found.shape
    # People and performances are drawn independently.
    drawn = found[rng.integers(performances, size=(studies, persons)), rng.integers(persons, size=(studies, persons))]
    means = drawn.mean(axis=1) + published[1] * rng.standard_normal(studies)
    low, high = np.quantile(means, (0.025, 0.975))
    value, condition, role, source = label
    return ReproducedValue(
        value=value,
        condition=condition,
        people=published[0],
        mean=float(found.mean()),
        low=float(low),
        high=float(high),
        role="fitted" if role == "fitted" else "held out",
        source=source,
    )
