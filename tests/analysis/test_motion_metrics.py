"""Measures of motion, on motions whose values are known."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.analysis.motion_metrics import foot_slips, rise_times, timing_errors
from sjasim.core import Cue, Kind, Move

T_S = np.arange(0.0, 8.0, 0.02)


def cue(move: Move = Move.FORWARD, t_s: float = 2.0, duration_s: float = 2.0) -> Cue:
    return Cue("dancer_1", move, 1, 0, 0.0, t_s, duration_s)


def ramps(begin_s: float, end_s: float, sign: float = 1.0) -> np.ndarray:
    """Roots that move along y with heading +y, at up to 0.4 m/s with ramps of 1 m/s^2."""
    speed = np.clip(np.minimum(T_S - begin_s, end_s - T_S), 0.0, 0.4)
    roots = np.zeros((len(T_S), 6))
    roots[:, 1] = sign * np.cumsum(speed) * 0.02
    roots[:, 3] = np.pi / 2
    return roots


@pytest.mark.parametrize(("move", "sign"), [(Move.FORWARD, 1.0), (Move.BACKWARD, -1.0)])
def test_a_late_start_and_an_early_stop_are_measured(move, sign):
    roots = ramps(1.95, 4.05, sign)  # crosses 0.10 m/s at 2.05 and 3.95 s
    (start, late), (stop, early) = timing_errors(T_S, roots, np.ones(len(T_S)), [cue(move)])
    assert (start.value, stop.value) == (f"start_{move.value}", f"stop_{move.value}")
    assert (late, early) == pytest.approx((0.05, -0.05), abs=0.02)


def test_a_clap_is_the_hands_closest_approach():
    hands = np.abs(T_S - 3.03)
    ((kind, late),) = timing_errors(T_S, ramps(9.0, 9.0), hands, [cue(Move.CLAP, 3.0, 0.0)])
    assert kind is Kind.CLAP
    assert late == pytest.approx(0.03, abs=0.011)


def test_an_absent_event_is_nan():
    errors = timing_errors(T_S, ramps(9.0, 9.0), np.ones(len(T_S)), [cue()])
    assert np.isnan([error for _, error in errors]).all()
    assert np.isnan(rise_times(T_S, ramps(9.0, 9.0), [cue()])).all()


def test_a_rise_by_0_2_m_s_at_1_m_s2_takes_0_2_s():
    assert rise_times(T_S, ramps(1.9, 4.1), [cue(), cue(Move.CLAP, 6.0, 0.0)]) == pytest.approx([0.2], abs=0.01)


def test_a_slip_is_the_largest_distance_of_a_standing_foot():
    landing = np.zeros((len(T_S), 2))
    landing[(T_S > 1.0) & (T_S < 1.5), 0] = 0.1
    landing[(T_S > 4.0) & (T_S < 4.5), 0] = 0.1
    feet = np.zeros((len(T_S), 2, 2))
    feet[(T_S > 2.0) & (T_S < 3.0), 0, 1] = 0.007  # and back again
    feet[:, 1, 0] = T_S  # the right one never swings
    assert foot_slips(T_S, feet, landing) == pytest.approx([0.007])
