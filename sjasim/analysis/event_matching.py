"""One-to-one matching of times."""

from __future__ import annotations

import numpy as np

from ..core import Array, IntArray


def matched(a_s: Array, b_s: Array, within_s: float) -> tuple[IntArray, IntArray]:
    """Pairs of times no farther apart than ``within_s``: as many as possible, and of those the closest in squares.

    Args:
        a_s: (N,) times [s], in any order.
        b_s: (M,) times [s].
        within_s: largest distance of a pair [s].

    Returns:
        indices into ``a_s`` and into ``b_s`` of the K pairs, in the order of ``a_s``.
    """
    from scipy.optimize import linear_sum_assignment

    gap = np.abs(np.subtract.outer(np.asarray(a_s, dtype=np.float64), np.asarray(b_s, dtype=np.float64)))
    forbidden = 1.0 + min(gap.shape, default=0)
    cost = np.where(gap <= within_s, (gap / within_s) ** 2, forbidden)
    rows, columns = linear_sum_assignment(cost)
    kept = gap[rows, columns] <= within_s
    return rows[kept], columns[kept]
