"""Orders of conditions: counterbalancing."""

import itertools
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sjasim.studies.session_order import condition_order, counterbalanced_orders


def test_two_conditions_are_danced_in_both_orders():
    assert counterbalanced_orders(2) == ((0, 1), (1, 0))


@given(st.integers(1, 9))
def test_each_condition_stands_equally_often_at_each_position_and_after_each_other(conditions):
    orders = counterbalanced_orders(conditions)
    assert all(sorted(order) == list(range(conditions)) for order in orders)
    places = Counter((index, place) for order in orders for place, index in enumerate(order))
    assert set(places.values()) == {len(orders) / conditions}
    assert len(places) == conditions**2
    neighbours = Counter(pair for order in orders for pair in itertools.pairwise(order))
    assert len(neighbours) == conditions * (conditions - 1)
    assert len(set(neighbours.values())) <= 1


def test_a_fixed_order_is_the_listed_one_and_a_random_order_depends_on_the_seed_alone():
    assert condition_order("fixed", 4, 3, 17) == (0, 1, 2, 3)
    drawn = [condition_order("random", 5, 0, seed) for seed in range(40)]
    assert drawn == [condition_order("random", 5, 9, seed) for seed in range(40)]
    assert len(set(drawn)) > 20


@pytest.mark.parametrize("position", range(5))
def test_groups_take_the_orders_in_turn(position):
    assert condition_order("counterbalanced", 2, position, 0) == ((0, 1), (1, 0))[position % 2]
