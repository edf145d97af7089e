"""Distribution of timing appropriateness: the paper's histogram, the cumulative curve, and shares within a limit.

Source: iqbal2016, section VI-B.
"""

from __future__ import annotations

import numpy as np

from ..assets.published_study import TA_BIN_S, TA_LAST_EDGE_S
from ..core import Array

LIMITS_S = (0.8, 1.2, 1.6)
"""Limits for which the paper gives the share of events [s]."""


def bin_edges() -> Array:
    """Return the (26,) edges of the paper's bins [s]."""
    return np.round(np.arange(round(TA_LAST_EDGE_S / TA_BIN_S) + 1) * TA_BIN_S, 10)


def timing_histogram(ta_s: Array) -> dict[str, object]:
    """Count values of timing appropriateness in the paper's bins.

    A bin contains its upper edge but not its lower one, apart from the first bin, which contains 0. The cumulative
    share at an edge is therefore the share of values within that time.

    Args:
        ta_s: (N,) values [s]; NaN, a step that was not performed, is left out.

    Returns:
        ``edges_s`` (26), ``counts`` (25), ``overflow`` (values beyond the last edge), ``n`` (values including
        overflow), and ``cumulative`` (26): share of all values up to each edge, so that it ends below 1 if there is
        overflow; empty without values.
    """
    values = _finite(ta_s)
    edges = bin_edges()
    within = np.searchsorted(np.sort(values), edges, side="right")

    # The first edge is 0, and a value of exactly 0 belongs to the first bin.
    counts = np.diff(np.concatenate([[0], within[1:]]))
    return {
        "edges_s": edges.tolist(),
        "counts": counts.tolist(),
        "overflow": len(values) - int(within[-1]),
        "n": len(values),
        "cumulative": (within / len(values)).tolist() if len(values) else [],
    }


def shares_within(ta_s: Array, limits_s: tuple[float, ...] = LIMITS_S) -> dict[str, float]:
    """Return the share of values up to each limit, by the limit in seconds as text; NaN without values.

    Args:
        ta_s: (N,) values [s]; NaN is left out.
        limits_s: the limits [s].
    """
    values = _finite(ta_s)
    return {f"{limit:g}": float(np.mean(values <= limit)) if len(values) else float("nan") for limit in limits_s}


def _finite(ta_s: Array) -> Array:
    values = np.asarray(ta_s, dtype=np.float64)
    return np.asarray(values[np.isfinite(values)])
