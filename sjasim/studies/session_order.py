"""Orders in which a group dances the conditions of a study."""

from __future__ import annotations

from ..core.clock import stream

ORDERS = ("counterbalanced", "fixed", "random")
"""Names of the orders."""


def counterbalanced_orders(conditions: int) -> tuple[tuple[int, ...], ...]:
    """Return a Williams square: each condition stands equally often at each position and after each other one.

    Two conditions give the orders AB and BA. An even number of conditions needs as many orders as conditions, an odd
    one twice as many.

    Source: williams1949, the square for an even number of treatments and the pair of squares for an odd one.

    Args:
        conditions: number of conditions, at least 1.

    Returns:
        orders of condition indices from 0. Groups take them in turn.
    """
    # The first order is 0, 1, n-1, 2, n-2, ...: neighbours differ by every distance once.
    first = [0]
    for step in range(1, conditions):
        first.append((step + 1) // 2 if step % 2 else conditions - step // 2)

    orders = [tuple((index + shift) % conditions for index in first) for shift in range(conditions)]
    if conditions % 2 and conditions > 1:
        orders += [order[::-1] for order in orders]
    return tuple(orders)


def condition_order(kind: str, conditions: int, position: int, seed: int) -> tuple[int, ...]:
    """Return the order in which one group dances the conditions.

    Args:
        kind: one of `ORDERS`.
        conditions: number of conditions.
        position: place of the group among the groups that share the orders, from 0.
        seed: seed of the group; it decides a random order.
    """
    if kind == "fixed":
        return tuple(range(conditions))
    if kind == "random":
        return tuple(int(index) for index in stream(seed, "study", "order").permutation(conditions))

    orders = counterbalanced_orders(conditions)
    return orders[position % len(orders)]
