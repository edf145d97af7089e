"""A string quartet with an assigned leader: how far each player corrects towards each other one.

The players' note onsets come from a folder of text files, which its users fetch themselves. Gains and noise of linear
phase correction are estimated from all takes of a condition. Simulated quartets with these estimates play the same
chords, and are measured in the same way.

Source: tomczak2022 (the data set); wing2014, eq. (1) (the model).
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..analysis.calibration.phase_correction_regression import EnsembleIntervals, EnsembleRegression, regress_ensemble
from ..analysis.onset_alignment import WINDOW_S, chords, complete_chords, pulse_s, steady_pairs
from ..core import Array, IntArray
from ..core.clock import stream
from ..core.errors import RecordError
from .reproduction_report import ReproducedValue, Reproduction

FILE_NAME = re.compile(r"(?P<player>[^-]+)-Q-JH-(?P<leader>[^-]+)-(?P<condition>[^-]+)-(?P<take>[^-]+)\.txt")
"""Names of the files: player, leader, condition and take."""

Onsets = Mapping[str, Array]
"""Player -> (N,) increasing note onsets of a take [s]."""


@dataclass(frozen=True, slots=True)
class Take:
    """One take, aligned; C chords, P players.

    Attributes:
        onsets_s: (C, P) onsets; NaN where a player is silent.
        pulse_s: (C - 1,) local pulse at each interval between chords.
        steady: chords at which a steady interval begins that everybody plays.
    """

    onsets_s: Array
    pulse_s: Array
    steady: IntArray


def reproduce_quartet(folder: Path, studies: int, seed: int, progress: Callable[[float], None]) -> Reproduction:
    """Estimate gains and noise from a folder of onsets, and compare simulated quartets with the real one.

    Args:
        folder: files named ``PLAYER-Q-JH-LEADER-CONDITION-TAKE.txt``; other files are ignored.
        studies: number of simulated studies.
        seed: seed of all random numbers.
        progress: is called with the share that is done, 0 to 1.

    Raises:
        RecordError: the folder or a file cannot be used; the message names it.
        FitError: a condition has too few notes that everybody plays.
    """
    recorded = read_onsets(folder)
    rows: list[ReproducedValue] = []
    conditions = []
    for done, ((leader, condition), takes) in enumerate(sorted(recorded.items())):
        players = sorted(next(iter(takes.values())))
        aligned = [align([onsets[player] for player in players]) for onsets in takes.values()]
        fit = regress_ensemble([intervals_of(take) for take in aligned])
        people = measures(aligned, fit, players.index(leader))

        rng = stream(seed, "reproduce", "quartet", leader, condition)
        simulated = simulated_measures(aligned, fit, players.index(leader), studies, rng)
        rows += [_row(name, f"{leader} leads, {condition}", value, simulated[name]) for name, value in people.items()]
        conditions.append(_details(leader, condition, players, takes, aligned, fit))
        progress((done + 1) / len(recorded))

    settings = {"studies": studies, "seed": seed, "window_s": WINDOW_S}
    return Reproduction("quartet", settings, rows, {"conditions": conditions})


def read_onsets(folder: Path) -> dict[tuple[str, str], dict[str, Onsets]]:
    """Read the onsets of a folder: (leader, condition) -> take -> player -> onsets.

    Raises:
        RecordError: there are no takes, a take lacks a player, the leader does not play, or a file is not a list of
            times.
    """
    if not folder.is_dir():
        raise RecordError(f"{folder} is not a folder of onset files")

    found: dict[tuple[str, str], dict[str, dict[str, Array]]] = {}
    for path in sorted(folder.iterdir()):
        match = FILE_NAME.fullmatch(path.name)
        if match is not None:
            takes = found.setdefault((match["leader"], match["condition"]), {})
            takes.setdefault(match["take"], {})[match["player"]] = _read_times(path)
    if not found:
        raise RecordError(f"{folder} has no file named PLAYER-Q-JH-LEADER-CONDITION-TAKE.txt")

    # A take without one of its players would silently be another ensemble.
    for (leader, condition), takes in found.items():
        players = sorted({player for onsets in takes.values() for player in onsets})
        if leader not in players:
            raise RecordError(f"{folder}: {leader} leads {condition}, but has no file there")
        for take, onsets in takes.items():
            missing = [player for player in players if player not in onsets]
            if missing:
                raise RecordError(f"{folder}: take {take} of {condition}, led by {leader}, has no file of {missing[0]}")
    return {key: dict(takes) for key, takes in found.items()}


def _read_times(path: Path) -> Array:
    """(N,) sorted times of a file with one onset a line; blank lines are allowed [s]."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise RecordError(f"{path} cannot be read: {error}") from None

    times_s = []
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            time_s = float(line)
        except ValueError:
            time_s = float("nan")
        if not np.isfinite(time_s):
            raise RecordError(f"{path}, line {number}: {line.strip()!r} is not a time in seconds")
        times_s.append(time_s)
    if not times_s:
        raise RecordError(f"{path} has no onsets")
    return np.sort(np.array(times_s))


def align(onsets_s: Sequence[Array]) -> Take:
    """Group the onsets of all players into chords, and find the steady intervals between them."""
    grouped_s = chords(onsets_s)
    return Take(grouped_s, pulse_s(np.nanmean(grouped_s, axis=1)), steady_pairs(grouped_s))


def intervals_of(take: Take) -> EnsembleIntervals:
    """Steady intervals of a take, less the local pulse."""
    k = take.steady
    return EnsembleIntervals(take.onsets_s[k], take.onsets_s[k + 1] - take.onsets_s[k] - take.pulse_s[k, None], k)


def measures(takes: Sequence[Take], fit: EnsembleRegression, leader: int) -> dict[str, float]:
    """What is compared: name with unit -> value.

    Asynchronies are taken over all chords that everybody plays, over those that follow such a chord after one pulse
    (steady), and over the others, which follow rests or longer notes.

    Args:
        takes: all takes of a condition.
        fit: estimates from them.
        leader: index of the leader.
    """
    gains = fit.gains
    steady = [take.steady + 1 for take in takes]
    complete = [np.flatnonzero(complete_chords(take.onsets_s)) for take in takes]
    other = [np.setdiff1d(own, after) for own, after in zip(complete, steady, strict=True)]

    others = np.arange(len(gains)) != leader
    return {
        "pairwise s.d. [ms]": _pairwise_sd_ms(takes, complete),
        "s.d., steady [ms]": _pairwise_sd_ms(takes, steady),
        "s.d., others [ms]": _pairwise_sd_ms(takes, other),
        "mean gain": float(gains[~np.eye(len(gains), dtype=bool)].mean()),
        "others to leader": float(gains[others, leader].mean()),
        "leader to others": float(gains[leader, others].mean()),
        "timekeeper [ms]": 1e3 * fit.timekeeper_s,
        "motor [ms]": 1e3 * fit.motor_s,
    }


def _pairwise_sd_ms(takes: Sequence[Take], selected: Sequence[IntArray]) -> float:
    """Standard deviation of the asynchronies of two players, mean over pairs and takes [ms].

    Args:
        takes: all takes.
        selected: (N,) chords of each take that count; takes with fewer than two are left out.
    """
    spreads_s = []
    for take, chosen in zip(takes, selected, strict=True):
        if len(chosen) > 1:
            own_s = take.onsets_s[chosen]
            pairs = itertools.combinations(range(own_s.shape[1]), 2)
            spreads_s += [(own_s[:, i] - own_s[:, j]).std(ddof=1) for i, j in pairs]
    return float(1e3 * np.mean(spreads_s)) if spreads_s else 0.0


def simulated_measures(
    takes: Sequence[Take], fit: EnsembleRegression, leader: int, studies: int, rng: np.random.Generator
) -> dict[str, Array]:
    """(S,) measures of each simulated study, which has the takes, chords and rests of the real one.

    Args:
        takes: all takes of a condition.
        fit: estimates with which the players are simulated.
        leader: index of the leader.
        studies: number of simulated studies.
        rng: generator of all noise.
    """
    played = [simulated_onsets_s(take, fit, studies, rng) for take in takes]
    found = []
    for study in range(studies):
        own = [_as_measured(take, onsets_s[study]) for take, onsets_s in zip(takes, played, strict=True)]
        found.append(measures(own, regress_ensemble([intervals_of(take) for take in own]), leader))
    return {name: np.array([study[name] for study in found]) for name in found[0]}


def simulated_onsets_s(take: Take, fit: EnsembleRegression, studies: int, rng: np.random.Generator) -> Array:
    """(S, C, P) onsets of simulated players, who keep time through their rests [s].

    Steady intervals have the local pulse, others their length in the take; all have the tempo noise of the fit.

    Source: wing2014, eq. (1): A(k + 1) = A(k) - correction of A(k) + T + M(k + 1) - M(k).
    """
    count, players = take.onsets_s.shape
    intervals_s = np.diff(np.nanmean(take.onsets_s, axis=1))
    intervals_s[take.steady] = take.pulse_s[take.steady]

    # A row of the matrix adds up to 0: asynchronies count, not times.
    correction = np.diag(fit.gains.sum(axis=1)) - fit.gains
    motor_s = fit.motor_s * rng.standard_normal((count, studies, players))
    steps_s = fit.timekeeper_s * rng.standard_normal((count, studies, players))
    steps_s[1:] += fit.tempo_s * rng.standard_normal((count - 1, studies, 1)) + intervals_s[:, None, None]

    onsets_s = np.empty((count, studies, players))
    keeper_s = steps_s[0]
    for k in range(count):
        # Motor noise moves the onset, not the timekeeper behind it.
        onsets_s[k] = keeper_s + motor_s[k]
        if k + 1 < count:
            keeper_s = keeper_s - onsets_s[k] @ correction.T + steps_s[k + 1]
    return np.swapaxes(onsets_s, 0, 1)


def _as_measured(take: Take, onsets_s: Array) -> Take:
    """A simulated take as it would be measured: rests are silent, and chords that are too wide are not found."""
    heard_s = np.where(np.isfinite(take.onsets_s), onsets_s, np.nan)
    heard_s[onsets_s.max(axis=1) - onsets_s.min(axis=1) > WINDOW_S] = np.nan
    # Steady intervals need both of their chords.
    complete = complete_chords(heard_s)
    return Take(heard_s, take.pulse_s, take.steady[complete[take.steady] & complete[take.steady + 1]])


def _row(name: str, condition: str, people: float, simulated: Array) -> ReproducedValue:
    """The row of one value; spreads between players are not fitted, all else is."""
    low, high = np.quantile(simulated, (0.025, 0.975))
    role: Literal["fitted", "held out"] = "held out" if "s.d." in name else "fitted"
    return ReproducedValue(
        name, condition, people, float(simulated.mean()), float(low), float(high), role, "tomczak2022, as given"
    )


def _details(
    leader: str,
    condition: str,
    players: Sequence[str],
    takes: Mapping[str, Onsets],
    aligned: Sequence[Take],
    fit: EnsembleRegression,
) -> dict[str, Any]:
    """What was aligned and estimated in a condition, for reproduce.json."""
    complete = [int(complete_chords(take.onsets_s).sum()) for take in aligned]
    return {
        "leader": leader,
        "condition": condition,
        "takes": list(takes),
        "players": list(players),
        "onsets": [{player: len(onsets[player]) for player in players} for onsets in takes.values()],
        "chords": [len(take.onsets_s) for take in aligned],
        "complete_chords": complete,
        "intervals": fit.intervals,
        "gains": fit.gains.tolist(),
        "gain_errors": fit.errors.tolist(),
        "tempo_s": fit.tempo_s,
    }
