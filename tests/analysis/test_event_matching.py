"""Matching is one to one, makes as many pairs as possible, and never exceeds the limit."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sjasim.analysis.event_matching import match_times

TIMES = st.lists(st.floats(0, 5), max_size=6)


def largest(a, b, within):
    """Size of the largest matching, by exhaustive search."""
    if not a:
        return 0
    best = largest(a[1:], b, within)
    for i, time in enumerate(b):
        if abs(time - a[0]) <= within:
            best = max(best, 1 + largest(a[1:], b[:i] + b[i + 1 :], within))
    return best


@given(TIMES, TIMES)
@settings(max_examples=80)
def test_the_number_of_pairs_is_the_largest_possible(a, b):
    rows, columns = match_times(np.array(a), np.array(b), 0.4)
    assert len(set(rows)) == len(set(columns)) == len(rows) == largest(a, b, 0.4)
    assert all(abs(a[i] - b[j]) <= 0.4 for i, j in zip(rows, columns, strict=True))


def test_a_constant_shift_matches_in_order():
    a = np.array([1.0, 1.001, 1.3])
    rows, columns = match_times(a + 0.05, a, 0.4)
    assert rows.tolist() == columns.tolist() == [0, 1, 2]


def test_an_empty_set_has_no_pairs():
    assert len(match_times(np.zeros(0), np.array([1.0]), 0.4)[0]) == 0
