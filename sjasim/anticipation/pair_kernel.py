"""Compiled pairwise synchronisation indices, of one group or of many at once.

The indices are those of `coincidences.count_coincidences`, which also gives the index of each kind and the bounded
variant, but takes longer for the few events of an iteration.
"""

from __future__ import annotations

import math

import numpy as np

from ..core import Array, IntArray
from ..core.compiled import compiled_entry, compiled_inner


@compiled_inner
def _pair_index(times_us: IntArray, kinds: IntArray, a: IntArray, b: IntArray, tau_us: int, kind_count: int) -> float:
    """Pairwise index Q_xy of the events from a[0] to a[1] and those from b[0] to b[1]; 0 without events."""
    number_a = np.zeros(kind_count, dtype=np.int64)
    number_b = np.zeros(kind_count, dtype=np.int64)
    count = np.zeros(kind_count, dtype=np.int64)
    for i in range(a[0], a[1]):
        number_a[kinds[i]] += 1
    for j in range(b[0], b[1]):
        number_b[kinds[j]] += 1

    # A positive lag counts once in c(x|y) or in c(y|x), and a lag of 0 counts 1/2 in each.
    for i in range(a[0], a[1]):
        for j in range(b[0], b[1]):
            if kinds[i] == kinds[j] and abs(times_us[i] - times_us[j]) < tau_us:
                count[kinds[i]] += 1

    total = 0.0
    weights = 0
    for kind in range(kind_count):
        weight = number_a[kind] + number_b[kind]
        weights += weight
        if count[kind] > 0:
            total += count[kind] / math.sqrt(number_a[kind] * number_b[kind]) * weight
    return total / weights if weights > 0 else 0.0


@compiled_entry
def pair_indices(times_us: IntArray, kinds: IntArray, slices: IntArray, tau_us: int, kind_count: int) -> Array:
    """Compute the pairwise synchronisation indices of N groups of H agents.

    Args:
        times_us: (E,) time of each event [us].
        kinds: (E,) kind of each event, from 0 to K - 1.
        slices: (N, H, 2) first event and the one after the last event of each agent.
        tau_us: two events coincide if they are less than this apart [us].
        kind_count: number of kinds, K.

    Returns:
        (N, H, H) symmetric indices, 0 on the diagonal.

    Source: iqbal2016, eqs. (1)-(4).
    """
    groups = slices.shape[0]
    agents = slices.shape[1]
    pairs = np.zeros((groups, agents, agents))
    for group in range(groups):
        for a in range(agents):
            for b in range(a + 1, agents):
                index = _pair_index(times_us, kinds, slices[group, a], slices[group, b], tau_us, kind_count)
                pairs[group, a, b] = index
                pairs[group, b, a] = index
    return pairs
