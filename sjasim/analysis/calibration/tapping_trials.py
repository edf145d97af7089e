"""Event times of groups, arranged for a fit of the human timing model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core import Array, IntArray
from ...core.errors import SjasimError


class FitError(SjasimError):
    """There are too few events for a fit, or the model cannot describe them."""


@dataclass(frozen=True, slots=True)
class TappingTrials:
    """N trials (iterations of a dance, or runs of tapping) of E events by groups of D dancers.

    Attributes:
        agents: the D dancers.
        late_s: (N, E, D) event times minus the music's beats or, in free time, minus the group's mean [s]; NaN where a
            dancer has no event.
        session: (N,) index of the session that each trial belongs to.
        music: whether people kept to music whose beats are known; otherwise they tapped in free time.
        phrases: groups of event indices that a dancer omits together.
        unused: number of events that belong to no trial, since another one of the same dancer was nearer.
        warnings: reservations about a fit, a sentence each.
    """

    agents: tuple[str, ...]
    late_s: Array
    session: IntArray
    music: bool
    phrases: tuple[tuple[int, ...], ...] = ()
    unused: int = 0
    warnings: tuple[str, ...] = ()


def finite_mean(values: Array, axis: int | tuple[int, ...]) -> Array:
    """Mean of the finite values along some axes; NaN where there are none."""
    count = np.isfinite(values).sum(axis=axis)
    return np.asarray(np.where(count, np.nansum(values, axis=axis) / np.maximum(count, 1), np.nan))
