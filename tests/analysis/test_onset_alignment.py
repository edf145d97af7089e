"""Alignment of the onsets of several players without a score."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.analysis.onset_alignment import chords, pulse_s, steady_pairs


def test_close_onsets_of_different_players_are_one_chord():
    found = chords([np.array([0.0, 0.5, 1.0]), np.array([0.03, 0.97]), np.array([0.46])])
    expected = [[0.0, 0.03, np.nan], [0.5, np.nan, 0.46], [1.0, 0.97, np.nan]]
    assert np.array_equal(found, expected, equal_nan=True)


def test_a_player_is_never_twice_in_a_chord():
    found = chords([np.array([0.0, 0.06]), np.array([0.08])])
    assert np.array_equal(found, [[0.0, np.nan], [0.06, 0.08]], equal_nan=True)


def test_every_onset_is_kept_whatever_is_missing():
    rng = np.random.default_rng(0)
    players = [np.sort(rng.uniform(0.0, 30.0, count)) for count in (100, 80, 3, 41)]
    found = chords(players)
    for index, own in enumerate(players):
        assert np.array_equal(found[np.isfinite(found[:, index]), index], own)
    assert (np.nanmax(found, axis=1) - np.nanmin(found, axis=1)).max() <= 0.1


def test_no_onsets_are_no_chords():
    assert chords([np.array([]), np.array([])]).shape == (0, 2)


def test_the_pulse_is_the_usual_interval_at_the_local_tempo():
    intervals = np.concatenate([np.full(30, 0.25), [1.0], np.full(30, 0.20), [0.1, 0.1]])
    pulse = pulse_s(np.concatenate([[0.0], np.cumsum(intervals)]))
    assert pulse.shape == intervals.shape
    assert pulse[[0, 10, 50, -1]] == pytest.approx([0.25, 0.25, 0.20, 0.20])


def test_steady_pairs_are_whole_and_one_pulse_apart():
    grid = np.concatenate([np.arange(10) * 0.25, 4.0 + np.arange(10) * 0.25])
    onsets = np.stack([grid, grid + 0.01], axis=1)
    onsets[3, 1] = np.nan
    # Neither over the rest after chord 9, nor next to chord 3, where a player is silent.
    assert steady_pairs(onsets).tolist() == [0, 1, 4, 5, 6, 7, 8, *range(10, 19)]
