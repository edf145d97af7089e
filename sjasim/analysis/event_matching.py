"""One-to-one matching of two sets of event times."""

from __future__ import annotations

import numpy as np

from ..core import Array, IntArray


def match_times(a_s: Array, b_s: Array, within_s: float) -> tuple[IntArray, IntArray]:
    """Match times that are at most ``within_s`` apart: as many pairs as possible, then with the least squared distance.

    Args:
        a_s: (N,) times [s], in any order.
        b_s: (M,) times [s], in any order.
        within_s: largest distance of a pair [s].

    Returns:
        (K,) indices into ``a_s`` and (K,) indices into ``b_s`` of the pairs, in the order of ``a_s``. Without times in
        one of the sets, K is 0.
    """
    from scipy.optimize import linear_sum_assignment

    distance = np.abs(np.subtract.outer(np.asarray(a_s, dtype=np.float64), np.asarray(b_s, dtype=np.float64)))

    # A pair that is too far apart costs more than all allowed pairs together, so that none is made while an allowed one
    # can take its place.
    forbidden_cost = 1.0 + min(distance.shape, default=0)
    cost = np.where(distance <= within_s, (distance / within_s) ** 2, forbidden_cost)
    rows, columns = linear_sum_assignment(cost)

    allowed = distance[rows, columns] <= within_s
    return rows[allowed], columns[allowed]
