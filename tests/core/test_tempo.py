"""Times of beats in music with a steady tempo, a changing tempo, and pauses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sjasim.core.errors import ConfigError
from sjasim.core.tempo import TempoMap


def test_a_steady_tempo():
    assert TempoMap.steady(118).time_s(4.0) == pytest.approx(4 * 60 / 118)
    assert [TempoMap.steady(60).time_s(beat) for beat in (-1.0, 0.5, 100.0)] == pytest.approx([-1.0, 0.5, 100.0])
    assert TempoMap.changing(60, (), ()) == TempoMap.steady(60)


def test_a_tempo_map_interpolates_and_extrapolates():
    music = TempoMap((0.0, 4.0, 8.0), (0.0, 2.0, 6.0))
    assert [music.time_s(beat) for beat in (-2, 0, 2, 4, 6, 8, 10)] == [-1, 0, 1, 2, 4, 6, 8]
    assert music.shifted(3.0).time_s(4.0) == 5.0


@pytest.mark.parametrize(
    "points", [((0.0,), (0.0,)), ((0.0, 0.0), (0.0, 1.0)), ((0.0, 1.0), (1.0, 0.5)), ((0.0, 1.0), (0.0,))]
)
def test_a_tempo_must_rise(points):
    with pytest.raises(ConfigError, match="tempo"):
        TempoMap(*points)


def test_an_accelerando_is_slow_before_linear_within_and_fast_after():
    music = TempoMap.changing(60.0, ((8.0, 1.0), (16.0, 2.0)), ())
    assert music.time_s(0.0) == 0.0
    assert [music.time_s(beat) for beat in (-4.0, 8.0)] == pytest.approx([-4.0, 8.0])
    fine = np.linspace(8.0, 16.0, 100_001)
    by_sum = np.mean(1.0 / (1.0 + (fine - 8.0) / 8.0)) * 8.0
    assert music.time_s(16.0) - music.time_s(8.0) == pytest.approx(by_sum, rel=1e-4)
    assert music.time_s(40.0) - music.time_s(16.0) == pytest.approx(12.0)


def test_a_ritardando_slows_down():
    music = TempoMap.changing(120.0, ((0.0, 1.0), (32.0, 0.5)), ())
    beats = np.diff([music.time_s(beat) for beat in range(33)])
    assert np.all(np.diff(beats) > 0)
    assert beats[-1] == pytest.approx(1.0, rel=0.02)


def test_a_pause_comes_before_its_beat_and_moves_everything_after_it():
    music = TempoMap.changing(60.0, (), ((12.0, 3.0), (20.0, 1.0)))
    assert [music.time_s(beat) for beat in (0, 11, 12, 19, 20, 30)] == pytest.approx([0, 11, 15, 22, 24, 34])
    assert music.time_s(0.0) == 0.0


@given(
    st.lists(st.tuples(st.floats(0, 200), st.floats(0.5, 2.0)), max_size=5, unique_by=lambda point: round(point[0])),
    st.lists(st.tuples(st.integers(1, 200), st.floats(0, 10)), max_size=3, unique_by=lambda point: point[0]),
    st.floats(-50, 300),
)
def test_time_and_beat_are_inverse(tempo, pauses, beat):
    music = TempoMap.changing(118.0, sorted(tempo), sorted(pauses))
    assert music.time_s(0.0) == pytest.approx(0.0, abs=1e-9)
    assert music.beat(music.time_s(beat)) == pytest.approx(beat, abs=1e-6)
