"""Alignment of the note onsets of several players: which onsets belong to one chord.

Players have different notes, and annotations miss some of them. No score is needed: onsets of different players that
lie close together are one *chord*, and every player has at most one onset in it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core import Array, BoolArray, IntArray

WINDOW_S = 0.1
"""Longest time from the first to the last onset of a chord [s] (assumed).

Trained ensembles are within it (rasch1979), and the shortest notes of all players together rarely are.
"""

PULSE_NEIGHBOURS = 8
"""Chords before and after an interval whose intervals determine the local pulse (assumed)."""

PULSE_TOLERANCE = 0.4
"""Largest relative deviation from the local pulse of an interval that counts as one pulse (assumed)."""


def chords(onsets_s: Sequence[Array], window_s: float = WINDOW_S) -> Array:
    """Group the onsets of several players into chords.

    A chord begins with the first onset that is in none, and takes every later onset within the window, until a player
    plays a second time.

    Args:
        onsets_s: (N,) increasing onsets of each of P players [s].
        window_s: longest time from the first to the last onset of a chord [s].

    Returns:
        (C, P) onset of each player in each chord [s]; NaN where a player is silent.
    """
    players = len(onsets_s)
    times_s = np.concatenate([np.asarray(own, dtype=np.float64) for own in onsets_s])
    owners = np.repeat(np.arange(players), [len(own) for own in onsets_s])

    found: list[Array] = []
    first_s = -np.inf
    # A stable order makes chords of equal onsets independent of the platform.
    for k in np.argsort(times_s, kind="stable"):
        if times_s[k] - first_s > window_s or np.isfinite(found[-1][owners[k]]):
            found.append(np.full(players, np.nan))
            first_s = times_s[k]
        found[-1][owners[k]] = times_s[k]
    return np.array(found).reshape(-1, players)


def pulse_s(chord_s: Array) -> Array:
    """(C - 1,) local pulse at each interval between chords: the median of the intervals around it [s].

    In a piece that moves mainly in equal notes, that is the duration of such a note, at the local tempo.

    Args:
        chord_s: (C,) mean times of the chords [s].
    """
    intervals_s = np.diff(chord_s)
    padded = np.pad(intervals_s, PULSE_NEIGHBOURS, constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * PULSE_NEIGHBOURS + 1)
    return np.asarray(np.nanmedian(windows, axis=1))


def complete_chords(onsets_s: Array) -> BoolArray:
    """(C,) whether everybody plays in a chord.

    Args:
        onsets_s: (C, P) chords, as of `chords`.
    """
    return np.asarray(np.isfinite(onsets_s).all(axis=1), dtype=bool)


def steady_pairs(onsets_s: Array) -> IntArray:
    """(N,) chords in which everybody plays, and that a chord follows one pulse later in which everybody plays too.

    Args:
        onsets_s: (C, P) chords, as of `chords`.
    """
    complete = complete_chords(onsets_s)
    means_s = np.nanmean(onsets_s, axis=1)
    one_pulse = np.abs(np.diff(means_s) / pulse_s(means_s) - 1.0) < PULSE_TOLERANCE
    return np.flatnonzero(complete[:-1] & complete[1:] & one_pulse)
