"""Event times of groups, arranged for a fit of the human timing model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...core import Array, IntArray
from ...core.errors import SjasimError

Time = Literal["music", "steady", "free"]
"""What people kept to.

``music``: music whose beats are known. ``steady``: their own tempo, which is steady within an iteration, as in tapping
without a metronome. ``free``: their own tempo, which may change at every event.
"""


class FitError(SjasimError):
    """There are too few events for a fit, or the model cannot describe them."""


@dataclass(frozen=True, slots=True)
class TappingTrials:
    """N trials (iterations of a dance, or runs of tapping) of E events by groups of D dancers.

    Attributes:
        agents: the D dancers.
        late_s: (N, E, D) event times minus their expected times [s]; NaN where a dancer has no event. What is expected
            are the music's beats or, without music, the group's own time.
        session: (N,) index of the session that each trial belongs to.
        time: what people kept to.
        pacers: dancers who keep exact time whatever the others do, such as a metronome; indices into ``agents``.
        expects_time: whether the expected times come from the tempo or the score; otherwise they are the group's mean
            time of each event, and only differences between dancers count.
        phrases: groups of event indices that a dancer omits together.
        unused: number of events that belong to no trial, since another one of the same dancer was nearer.
        warnings: reservations about a fit, a sentence each.
    """

    agents: tuple[str, ...]
    late_s: Array
    session: IntArray
    time: Time
    pacers: tuple[int, ...] = ()
    expects_time: bool = True
    phrases: tuple[tuple[int, ...], ...] = ()
    unused: int = 0
    warnings: tuple[str, ...] = ()


def finite_mean(values: Array, axis: int | tuple[int, ...]) -> Array:
    """Mean of the finite values along some axes; NaN where there are none."""
    count = np.isfinite(values).sum(axis=axis)
    return np.asarray(np.where(count, np.nansum(values, axis=axis) / np.maximum(count, 1), np.nan))
