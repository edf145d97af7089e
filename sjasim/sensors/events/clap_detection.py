"""When hands have met: the one rule behind claps seen from the front and from the side, compiled.

A clap is a local minimum of a ratio, which is small where hands meet, below ``clap_ratio``. Hands that touch stay
together for a while; which of the small numbers of that while is the least is chance. Below `TOUCHING_RATIO` the
minimum is where the ratio falls by less than `STILL_RATIO` between frames.

The event comes with the frame after the minimum. Hands must have been apart (above `APART_RATIO`) since the last clap,
which must be ``clap_refractory_s`` ago: hands held together clap once. A hand that was inferred to be apart from the other,
behind somebody's arm, say, and comes into sight on its way was so if it is then seen farther off than `MIDWAY_RATIO`.
Touching hands hide each other, so they may be inferred as they meet, if they were last tracked nearer than
`NEAR_RATIO`. A time longer than a memory's without tracked hands forgets everything, so that hands that jump into sight
cannot clap.
"""

from __future__ import annotations

from math import inf, isnan, nan

import numpy as np
from numba import njit

from .thresholds import Record, Records

APART_RATIO = 0.8
"""Above this ratio hands are apart; arms that hang or open for a clap have 1.1 to 1.4."""

MIDWAY_RATIO = 0.4
"""Hands in sight farther apart than this do not touch: they may yet come together (assumed)."""

NEAR_RATIO = 1.0
"""Hands nearer than this may clap: early starts are disarmed until ``clap_refractory_s`` after it, also when the clap
itself stayed hidden; and tracked hands that come so near have been seen to close (assumed)."""

TOUCHING_RATIO, STILL_RATIO = 0.3, 0.03
"""Hands nearer than the first may touch; from frame to frame their ratio is uncertain by less than the second: some
half a centimetre per hand (assumed)."""

HANDS = np.dtype([
    ("ratio", np.float64),  # of the last frame; NaN where it said nothing
    ("ratio_before", np.float64),  # of the frame before that
    ("t_ratio_s", np.float64),  # when the last frame was
    ("t_clap_s", np.float64),  # when the last clap was seen
    ("t_near_s", np.float64),  # when tracked hands were last near
    ("t_seen_s", np.float64),  # when they were last tracked
    ("apart", np.bool_),  # whether they have been apart since the last clap
    ("guessed", np.bool_),  # whether they were inferred to be apart before they came into sight
    ("near", np.bool_),  # whether they were near when they were last tracked
])  # fmt: skip
"""What is remembered of one person's hands; times are the sensor's."""


def unseen_hands(count: int) -> Records:
    """(count,) `HANDS` that nobody has seen yet."""
    never = (nan, nan, nan, -inf, -inf, -inf, False, False, False)
    return np.array([never] * count, dtype=HANDS)


@njit(cache=True)
def met_s(hands: Record, t_s: float, ratio: float, tracked: bool, memory_s: float, rules: Record) -> float:
    """Judge one frame.

    Args:
        hands: what is remembered of them, one of `HANDS`; changed.
        t_s: the sensor's time of the frame.
        ratio: of the hands; NaN where it says nothing.
        tracked: whether the hands that it rests on are tracked.
        memory_s: how long they may be inferred.
        rules: one of `thresholds.RULES`.

    Returns:
        the time at which the hands met, or NaN.
    """
    hands.guessed = ratio >= MIDWAY_RATIO and hands.guessed if tracked else hands.guessed or ratio > APART_RATIO
    if tracked and not isnan(ratio):
        hands.t_seen_s = t_s
        hands.near = ratio < NEAR_RATIO
        if hands.near:
            hands.t_near_s = t_s
    elif t_s - hands.t_seen_s > memory_s:
        hands.ratio = hands.ratio_before = hands.t_ratio_s = nan
        hands.apart = hands.near = False
        return nan
    before, least, t_least_s = hands.ratio_before, hands.ratio, hands.t_ratio_s
    hands.ratio_before, hands.ratio, hands.t_ratio_s = least, ratio, t_s
    lowest = before >= least and least < ratio + (STILL_RATIO if least < TOUCHING_RATIO else 0.0)
    rested = t_s - hands.t_clap_s >= rules.clap_refractory_s
    if hands.apart and hands.near and lowest and least < rules.clap_ratio and rested:
        hands.t_clap_s = t_s
        hands.apart = False
        return float(t_least_s)
    least_apart = MIDWAY_RATIO if hands.guessed else max(APART_RATIO, rules.clap_ratio)
    hands.apart = hands.apart or (tracked and ratio > least_apart)
    return nan


@njit(cache=True)
def clapping(hands: Record, t_s: float, rules: Record) -> bool:
    """Whether a clap may be under way or just over."""
    return bool(t_s - hands.t_near_s < rules.clap_refractory_s)
